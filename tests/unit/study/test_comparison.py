"""Several embeddings of the same pairs in one table: what is marked, what is refused."""

import json
from dataclasses import replace

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.store import save_embeddings
from omnivat.head import linear_maps
from omnivat.kit.errors import DataError
from omnivat.study.comparison import compare, table
from omnivat.study.comparison.draws import draws_of
from omnivat.study.comparison.matching import matched
from omnivat.study.shift.reading import features_of
from tests.builders import embeddings_of

pytestmark = pytest.mark.slow
PAIRS, WIDTH = 120, 12
DOMAINS = ("A", "B", "C")


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 30)


@pytest.fixture
def made():
    """Return a maker of sets of the same 120 pairs: three domains, two classes, several
    pairs of an object. `clear` separates the classes; without it, the set is noise.
    """
    truth = np.random.default_rng(1)
    label, domain = np.tile(np.arange(2), PAIRS // 2), np.repeat(np.arange(3), PAIRS // 3)
    offset = truth.normal(size=(3, WIDTH))
    rows = {
        "object": [f"{'ab'[c]}{k // 12 % 4}" for k, c in enumerate(label)],
        "vis": [f"{d}/{k}-vis.png" for k, d in enumerate(domain)],
        "tac": [f"{d}/{k}-tac.png" for k, d in enumerate(domain)],
        "split": ["test" if k // 12 % 4 == 3 else "train" for k in range(PAIRS)],
        "force": [f"{force:.6f}" for force in truth.uniform(1, 9, PAIRS)],
    }

    def make(clear=0.0, moved=0.0, forced=0.0, seed=0, order=None):
        noise = np.random.default_rng(seed).normal(size=(2, PAIRS, WIDTH))
        signal = clear * label[:, None] * np.ones(WIDTH)
        signal = signal + moved * offset[domain]
        signal[:, 0] += forced * np.array(rows["force"], float)
        whole = embeddings_of(
            *(noise + signal), domain, label, domains=DOMAINS, classes=("wood", "steel"), rows=rows
        )
        return features_of(whole if order is None else whole.select(order))

    return make


def cells(found, column):
    return {one["name"]: one["cells"][column] for one in found["sets"]}


def test_a_clear_encoder_is_marked_above_a_random_one_and_equal_ones_are_not(made):
    sets = {"clear": made(clear=3), "random": made(seed=5)}
    away = cells(compare(sets, draws=2, cost=False), "away")
    assert away["clear"]["value"] == 1 and away["clear"]["best"]
    assert away["random"]["less"]["high"] < 0 and not away["random"]["best"]
    again = compare({**sets, "again": made(clear=3)}, draws=2, cost=False)
    assert not any(one["best"] for column in again["sets"] for one in column["cells"].values())
    assert cells(again, "away")["again"]["less"] == {"value": 0.0, "low": 0.0, "high": 0.0}
    words = table(again)
    assert "**" not in words and "again less clear" in words and "domains and objects" in words


def test_a_profile_gives_back_what_a_moved_sensor_takes(made):
    found = compare({"still": made(clear=2), "moved": made(clear=2, moved=9)}, draws=2, cost=False)
    moved = found["sets"][1]
    value = {name: one["value"] for name, one in moved["cells"].items()}
    assert value["away"] < value["away5"] <= value["away20"] + 0.05
    assert value["away"] < value["labels5"]
    gap = {one["name"]: one["gaps"]["between domains, tac"] for one in found["sets"]}
    assert gap["moved"]["value"] > 2 * gap["moved"]["floor"]
    assert gap["still"]["value"] < 2 * gap["still"]["floor"]


def test_pairs_in_another_order_are_the_same_pairs(made):
    mixed = np.random.default_rng(0).permutation(PAIRS)
    one, two = matched({"one": made(), "two": made(order=mixed)}).values()
    np.testing.assert_array_equal(one.embeddings.vis, two.embeddings.vis)
    assert one.embeddings.rows == two.embeddings.rows


def test_zeros_beside_a_narrow_encoder_change_no_cell_of_its_modality(made):
    one = made(clear=1)
    wide = {n: np.pad(rows, ((0, 0), (0, 500))) for n, rows in one.embeddings.vectors.items()}
    padded = replace(one, embeddings=replace(one.embeddings, **wide))
    found = compare({"one": one, "padded": padded}, view="tac", draws=2, cost=False)
    first, other = ([c["value"] for c in one["cells"].values()] for one in found["sets"])
    assert first == other and [one["width"] for one in found["sets"]] == [WIDTH, WIDTH]


def test_a_sentence_names_the_pairs_that_differ(made):
    fewer = {"one": made(), "two": made(order=np.arange(1, PAIRS))}
    with pytest.raises(DataError, match="'two' lacks 1 of the 120 of 'one', such as A/wood/a0"):
        compare(fewer)
    with pytest.raises(DataError, match="give two or more"):
        compare({"one": made()})


def test_intervals_draw_domains_and_whole_objects(made):
    data = made().embeddings
    drawn = draws_of(data, ["A"])
    assert (drawn.domains[1:].sum(1) == 3).all() and (drawn.pairs[0] == 1).all()
    for object in np.unique(data.objects):
        assert (np.ptp(drawn.pairs[:, data.objects == object], axis=1) == 0).all()
    right = np.tile([1.0, 0.0, 0.0], (1, PAIRS // 3))
    assert drawn.mean(right, home=True).value == pytest.approx(14 / 40)


def test_numbers_are_predicted_where_features_hold_them(made):
    sets = {"noise": made(seed=5), "holds": made(forced=3)}
    found = compare(sets, target="force", draws=2, cost=False)
    for column in ("home", "away", "away5", "away20"):
        r2, error = (cells(found, f"{column}:{kind}") for kind in ("r2", "mae"))
        assert r2["holds"]["value"] > 0.8 > 0.3 > r2["noise"]["value"]
        assert r2["holds"]["low"] < r2["holds"]["value"] < r2["holds"]["high"]
        assert error["holds"]["less"]["high"] < 0 and not r2["noise"]["best"]
        assert error["holds"]["value"] < 0.9 < 1.5 < error["noise"]["value"]  # of 1 to 9
    with pytest.raises(DataError, match="no column 'forse'; it has the numbers force"):
        compare(sets, target="forse")


def test_the_command_writes_table_numbers_and_figure(made, tmp_path, capsys):
    for name, one in (("a", made(clear=2)), ("b", made(seed=5))):
        save_embeddings(tmp_path / f"{name}.safetensors", one.embeddings)
    files = [str(tmp_path / f) for f in ("a.safetensors", "b.safetensors")]
    out = {end: tmp_path / f"found.{end}" for end in ("json", "md", "svg")}
    options = ["--json", out["json"], "--markdown", out["md"], "--figure", out["svg"]]
    ended = main(["compare", *files, "--draws", "1", *map(str, options)])
    said = capsys.readouterr()
    assert ended == 0, said.err
    assert said.out == out["md"].read_text(encoding="utf-8") and "| a " in said.out
    assert json.loads(out["json"].read_text())["sets"][0]["cells"]["home"]["value"] > 0.9
    assert "<svg" in out["svg"].read_text(encoding="utf-8")
    assert main(["compare", files[0], files[0]]) == 1
    assert "Two sets are called 'a'; name one with NAME=FILE." in capsys.readouterr().err


def test_numbers_beside_vectors_reach_the_report(made, tmp_path, capsys):
    one = made(forced=3).embeddings
    force = np.array(one.rows["force"], float)
    names = np.array(one.header.domains)[one.domain]
    vectors = {"tac": one.tac, "material": one.label, "domain": names, "force": force}
    np.savez(tmp_path / "v.npz", **vectors)
    words = ["report", tmp_path / "v.npz", "--out", tmp_path / "out", "--target", "force"]
    assert main(list(map(str, words))) == 0
    assert "force, predicted by ridge regression: home, R² 0." in capsys.readouterr().out
    assert 'force,"home, R²"' in (tmp_path / "out" / "numbers.csv").read_text("utf-8")
