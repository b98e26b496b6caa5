"""Save, Interactive figure: the open view as one page."""

import json
from dataclasses import replace

import pytest

from app.shared.resources import Resources
from app.shared.tables import tables
from omnivat.maps.frames import read_frames, write_frames

from .conftest import served


@pytest.fixture(scope="module")
def client(framed):
    resources = Resources(framed)
    yield served(resources)
    resources.shared.close()


def figures_of(page):
    """Return the figures of a saved page."""
    start = page.index("const figures = ") + len("const figures = ")
    return json.JSONDecoder().raw_decode(page[start:])[0]


@pytest.mark.parametrize(
    ("stage", "title"), [("f_hat", "F̂ after DTG"), ("projection", "Projection")]
)
def test_the_open_view_is_a_page_of_three_figures_that_loads_nothing(client, stage, title):
    """The figures name a step as the page does, the projection's map of the transform, too."""
    view = {"stage": stage, "map": "pca", "colour": "confidence", "mode": "", "order": 0.5}
    sent = client.post("/omnivat/save/figure", json=view)
    assert sent.status_code == 200 and sent.headers["content-type"].startswith("text/html")
    assert sent.text.count('class="plot"') == 3 and "default-src 'none'" in sent.text
    titles = [figure["layout"]["title"]["text"] for figure in figures_of(sent.text)]
    assert titles[0] == f"OmniVaT, {title}, p = 0.50"
    assert titles[1] == f"OmniVaT, {title}, against p"


@pytest.mark.parametrize(
    ("view", "words"),
    [
        ({"stage": "nothing"}, "stage is 'nothing'; choose one of raw"),
        ({"map": "umap", "stage": "relu"}, "There is no map 'umap/relu'"),
        ({"colour": "<b>"}, "The colour is '<b>'"),
    ],
)
def test_a_view_that_is_not_there_is_refused_in_one_sentence(client, view, words):
    sent = client.post("/omnivat/save/figure", json=view)
    assert sent.status_code == 400 and words in sent.json()["error"]


def test_the_figures_of_an_added_mode_have_its_name_and_show_what_it_can_do(
    framed, tmp_path, monkeypatch
):
    row = {"id": "frozen", "file": str(tmp_path / "frozen.bin"), "can": ["heads"]}
    row["caption"] = "a frozen head for each p"
    monkeypatch.setitem(tables(), "modes", [*tables()["modes"], row])
    frames = read_frames(framed.frames)
    write_frames(row["file"], replace(frames, head={**frames.head, "kind": "frozen"}))
    resources = Resources(framed)
    page = served(resources).post("/omnivat/save/figure", json={"mode": "frozen"}).text
    resources.shared.close()
    assert "what-if" not in page
    _, curves, stairs = figures_of(page)
    for figure in (curves, stairs):
        assert row["caption"] in json.dumps(figure["layout"])
    assert {trace["mode"] for trace in curves["data"]} == {"lines+markers"}
