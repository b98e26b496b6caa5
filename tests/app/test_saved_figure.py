"""Save, Interactive figure: the open view as one page."""

import json

import pytest

from app.resources import Resources

from .conftest import served


@pytest.fixture(scope="module")
def client(framed):
    resources = Resources(framed)
    yield served(resources)
    resources.shared.close()


def test_the_open_view_is_a_page_of_three_figures_that_loads_nothing(client):
    view = {"stage": "f_hat", "map": "pca", "colour": "confidence", "mode": "", "order": 0.5}
    sent = client.post("/omnivat/save/figure", json=view)
    assert sent.status_code == 200 and sent.headers["content-type"].startswith("text/html")
    assert sent.text.count('class="plot"') == 3 and "default-src 'none'" in sent.text
    start = sent.text.index("const figures = ") + len("const figures = ")
    map_figure = json.JSONDecoder().raw_decode(sent.text[start:])[0][0]
    assert (
        sum(
            len(trace["customdata"]) if "customdata" in trace else 1 for trace in map_figure["data"]
        )
        >= 1
    )


@pytest.mark.parametrize(
    ("view", "words"),
    [
        ({"stage": "nothing"}, "stage is 'nothing'; choose one of raw"),
        ({"map": "umap", "stage": "relu"}, "There is no map 'umap/relu'"),
        ({"colour": "<b>"}, "The colour is '<b>'"),
        ({"order": "x"}, "p"),
    ],
)
def test_a_view_that_is_not_there_is_refused_in_one_sentence(client, view, words):
    sent = client.post("/omnivat/save/figure", json=view)
    assert sent.status_code == 400 and words in sent.json()["error"]
