"""The report of a domain shift: what each number means, and sets that lack something."""

import csv
import math
import re

import numpy as np
import pytest
from scipy.stats import t as student

from omnivat.cli import main
from omnivat.head import linear_maps
from omnivat.kit.progress import ignore
from omnivat.study.shift import read_features
from omnivat.study.shift.measure import _summed, gaps, interval, neighbours, retrieval
from omnivat.study.shift.probe import UNEVEN, probes
from omnivat.study.shift.reading import features_of
from omnivat.study.shift.words import methods, notes


@pytest.fixture(autouse=True)
def short(monkeypatch):
    monkeypatch.setattr(linear_maps, "PLAIN_STEPS", 30)


@pytest.fixture
def made(tmp_path):
    """Return a maker of features: two domains, four classes, an offset of the touches of the
    second.
    """

    def make(*, offset=0.0, same=False, pairs=80, **arrays):
        random = np.random.default_rng(0)
        label = np.tile(np.arange(4), pairs // 4)
        domain = np.repeat(["=A", "B"], pairs // 2)
        centres = 2 * random.normal(size=(4, 16))
        vis, tac = (centres[label] + random.normal(size=(pairs, 16)) for _ in range(2))
        tac[domain == "B"] += offset * random.normal(size=16)
        whole = {"vis": vis, "tac": vis if same else tac, "domain": domain, "material": label}
        kept = {k: v for k, v in {**whole, **arrays}.items() if v is not None}
        np.savez(tmp_path / "f.npz", **kept)
        return tmp_path / "f.npz"

    return make


def mean_of(records, measure, **fields):
    wanted = {"measure": measure, "from": "", **fields}
    return next(r for r in records if all(r[k] == v for k, v in wanted.items()))


def test_equal_photos_and_touches_have_no_gap_and_find_their_partner(made):
    found = read_features(made(same=True))
    assert mean_of(gaps(found, ignore), "centroid", modality="")["value"] == pytest.approx(
        0, abs=1e-6
    )
    ranks = [r["value"] for r in retrieval(found) if r["measure"] == "recall@1"]
    assert ranks == [1.0] * 4
    few = retrieval(read_features(made(same=True, pairs=8)))  # of four pairs ten cannot be taken
    assert {r["note"] for r in few if r["measure"] == "recall@10"} == {"chance 1.0000"}


def test_of_a_large_set_every_reader_draws_the_same_pairs(made, monkeypatch):
    whole = read_features(made())
    monkeypatch.setattr("omnivat.study.shift.reading.MOST", 20)
    found, again = read_features(made()), features_of(whole.embeddings)
    assert (len(found.embeddings), found.drawn_of) == (20, 80)
    np.testing.assert_array_equal(found.embeddings.vis, again.embeddings.vis)


def test_an_offset_raises_the_gap_and_costs_a_probe_what_a_profile_gives_back(made):
    near, far = (read_features(made(offset=offset)) for offset in (0.0, 4.0))
    gap = [mean_of(gaps(one, ignore), "centroid", modality="tac")["value"] for one in (near, far)]
    assert gap[1] > 2 * gap[0]
    records = probes(far, ignore)
    home, away, back = (
        mean_of(records, name, modality="tac")["value"]
        for name in ("home", "away", "away, with a profile")
    )
    assert home > 0.9 and away < 0.8 and back > away + 0.1
    assert mean_of(records, "gain of the profile", modality="tac")["value"] == pytest.approx(
        back - away
    )
    assert mean_of(records, "loss: home less away", modality="tac")["value"] == pytest.approx(
        home - away, abs=1e-6
    )


def test_an_interval_covers_the_mean_and_widens_when_pairs_share_objects():
    values = np.random.default_rng(0).random(200)
    alone, grouped = (
        interval(values, np.arange(200)),
        interval(np.sort(values), np.arange(200) // 20),
    )
    assert alone[0] < values.mean() < alone[1]
    assert grouped[1] - grouped[0] > 2 * (alone[1] - alone[0])
    assert all(math.isnan(end) for end in interval(values, np.zeros(200)))


def test_the_interval_of_a_mean_gap_is_a_jackknife_of_eight_blocks_with_students_t():
    found = [*_summed("centroid", *({("", "A", "A"): k / 10} for k in range(4, 13)))]
    parts = np.arange(5, 13) / 10
    error = (7 / 8 * ((parts - parts.mean()) ** 2).sum()) ** 0.5
    half = student.ppf(0.975, 7) * error
    assert found[0]["low"] == 0 and found[0]["high"] == pytest.approx(0.4 + half, rel=1e-4)


def test_domains_that_do_not_mix_are_seen(made):
    line = mean_of(
        neighbours(read_features(made(offset=20.0))), "own domain among 10 nearest", modality="tac"
    )
    assert line["value"] > 0.99 and float(line["note"].split()[0]) == pytest.approx(
        39 / 79, abs=0.001
    )


def report(file, tmp_path, *more):
    out = tmp_path / "out"
    code = main(["report", str(file), "--out", str(out), *more])
    return code, out


def test_the_command_writes_a_page_figures_and_a_table_that_no_spreadsheet_computes(
    made, tmp_path, capsys
):
    code, out = report(made(), tmp_path, "--encoder", "mine")
    assert code == 0 and "open " in capsys.readouterr().out
    page = (out / "report.html").read_text(encoding="utf-8")
    assert not re.findall(r'(?:src|href)="[^"]', page) and "Features of mine (16 values)" in page
    assert {f.stem for f in (out / "figures").iterdir()} >= {
        "map_umap_domain",
        "gaps_centroid",
        "retrieval",
        "probe",
    }
    with (out / "numbers.csv").open(newline="", encoding="utf-8") as handle:
        rows = list(csv.DictReader(handle))
    assert {r["part"] for r in rows} == {
        "modality gap",
        "domain gap",
        "no gap",
        "retrieval",
        "neighbours",
        "probe",
        "map",
    }
    assert any(r["from"] == "'=A" for r in rows)
    assert not [cell for r in rows for cell in r.values() if cell[:1] in ("=", "+", "@")]


def test_balanced_accuracy_and_the_largest_class_stand_beside_probes_of_uneven_classes(made):
    labels = np.array(["wood", "steel"])[(np.arange(80) % 10 == 0).astype(int)]
    records = probes(read_features(made(material=labels)), ignore)
    found = {r["measure"]: r["value"] for r in records if r["note"] and r["modality"] == "both"}
    assert found["away, always the largest class"] == 0.9
    assert found["away, balanced over classes"] < found["away"]
    assert not any(r["measure"] in UNEVEN for r in probes(read_features(made()), ignore))


@pytest.mark.parametrize(
    ("lacking", "words"),
    [
        ({"domain": None}, ["One domain: there is no gap between domains"]),
        (
            {"tac": None, "material": None},
            ["No classes: probes and mAP are left out.", "One modality (photos): there is no gap"],
        ),
        ({"vis": None, "domain": None, "material": None}, ["One modality (touches)"]),
    ],
)
def test_a_set_that_lacks_something_is_reported_and_the_page_says_what_is_left_out(
    lacking, words, made, tmp_path
):
    code, out = report(made(pairs=40, **lacking), tmp_path)
    assert code == 0
    page = (out / "report.html").read_text(encoding="utf-8")
    assert all(sentence in page for sentence in words)


def test_domains_without_gaps_are_told(made, monkeypatch):
    found = read_features(made(pairs=40, domain=np.repeat(["A", "B", "C"], [9, 10, 21])))
    few = "Fewer than 10 pairs, so no gap and no probe: A."
    measured = (r["from"] for r in gaps(found, ignore) if r["part"] == "modality gap")
    assert set(measured) == {"", "B", "C"} and "between domains" in methods(found, 0)
    for most, more in ((2, []), (1, ["Gaps are of the 1 largest domains."])):
        monkeypatch.setattr("omnivat.study.shift.words.MOST_DOMAINS", most)
        assert notes(found) == [few, *more]


def test_what_cannot_be_reported_is_one_sentence_and_no_folder(made, tmp_path, capsys):
    code, out = report(made(pairs=40, vis=np.full((40, 16), np.nan)), tmp_path)
    assert code == 1 and not out.exists()
    assert "has nan in vis, row 0" in capsys.readouterr().err
    code, _ = report(tmp_path / "none.npz", tmp_path)
    assert code == 1 and "No such file" in capsys.readouterr().err
    (tmp_path / "out").write_text("x")
    assert report(made(), tmp_path)[0] == 1 and "name a folder" in capsys.readouterr().err
