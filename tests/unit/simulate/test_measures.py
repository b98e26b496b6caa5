"""The measures of the simulated set, on vectors whose result is known."""

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.simulated_features import Features, features_in
from benchmarks.simulated_probe import READINGS, judged, sensor_accuracy
from benchmarks.simulated_real import predictions, real_pairs, wilson
from benchmarks.simulated_table import by_source, chance, matrix, print_table, questions
from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.store import save_embeddings
from omnivat.kit.errors import DataError

MATERIALS = ("wood", "steel", "ceramic")


def made(*, ceramic_in_b: bool = True) -> Features:
    """Return domains A and B of ten pairs a class. In B, wood and steel have changed places by touch.

    One pair of three looks like another class: its photo is that of the class after its own.
    """
    random = np.random.default_rng(3)
    rows = [
        {
            "domain": domain, "material": material, "split": "test" if n < 3 else "train",
            "object": f"{domain}{material}{n}",
            "looks_like": MATERIALS[(index + 1) % 3] if n % 3 == 0 else "", "feels_like": "",
        }
        for domain in "AB"
        for index, material in enumerate(MATERIALS)
        for n in range(10)
        if domain == "A" or material != "ceramic" or ceramic_in_b
    ]  # fmt: skip
    swapped = {"wood": 1, "steel": 0, "ceramic": 2}
    place = [MATERIALS.index(row["material"]) for row in rows]
    felt = [i if r["domain"] == "A" else swapped[r["material"]] for i, r in zip(place, rows, strict=True)]
    seen = [MATERIALS.index(row["looks_like"] or row["material"]) for row in rows]
    vis, tac = (
        (np.eye(5)[index] * 9 + random.normal(size=(len(rows), 5)) * 0.1).astype(np.float32) for index in (seen, felt)
    )
    return Features(vis=vis, tac=tac, rows=rows)


ALL = np.ones(60, dtype=bool)


def test_a_probe_is_right_within_a_domain_and_wrong_where_classes_changed_places() -> None:
    features = made()
    shares = matrix(judged(features), features, "TAC", ALL)

    np.testing.assert_allclose(np.diag(shares), 1.0)
    np.testing.assert_allclose([shares[0, 1], shares[1, 0]], 1 / 3)
    np.testing.assert_allclose(by_source(shares, within=False), 1 / 3)


def test_ceramic_is_left_out_where_either_domain_has_none() -> None:
    features = made(ceramic_in_b=False)
    found = judged(features)
    tested = found.predictions["VIS"] != ""
    domains = features.column("domain")

    assert (tested[0] & (domains == "A")).sum() == 9  # three test pairs of three classes
    assert (tested[0] & (domains == "B")).sum() == 20  # every pair of the two shared classes
    assert (tested[1] & (domains == "A")).sum() == 20
    assert "ceramic" not in found.predictions["VIS"][1]
    assert chance(found, features, within=True) == pytest.approx((1 / 3 + 1 / 2) / 2)


def test_no_training_pair_is_tested_in_its_own_domain() -> None:
    features = made()
    tested = judged(features).predictions["product"] != ""
    own = features.column("domain") == "A"

    assert not (tested[0] & own & (features.column("split") == "train")).any()


def test_touch_tells_what_looks_alike_and_every_fusion_uses_it() -> None:
    features = made()
    found, alike = judged(features), features.column("looks_like") != ""
    shares = {name: by_source(matrix(found, features, name, alike), within=True) for name in READINGS}

    assert shares["VIS"].max() == 0.0
    assert shares["TAC"].min() == 1.0
    for fusion in ("concatenation", "mean"):
        assert shares[fusion].min() > 0.6


def test_the_table_has_a_row_for_look_alikes_and_none_for_groups_without_pairs(capsys) -> None:
    features = made()
    print_table(judged(features), features)
    printed = capsys.readouterr().out

    assert "| imitate another class by sight, within a domain | 6 | 0.0 | 100.0 |" in printed
    assert "by touch" not in printed
    assert "Chance: 33.3 within a domain, 33.3 in other domains." in printed
    assert len(questions(features)) == 6


def test_a_sensor_is_told_by_its_nearest_training_image() -> None:
    features = made()
    domains = features.column("domain")
    shifted = features.tac + 20 * np.eye(5, dtype=np.float32)[4] * (domains == "B")[:, None]
    unit = shifted / np.linalg.norm(shifted, axis=1, keepdims=True)
    told = sensor_accuracy(unit, domains=domains, splits=features.column("split"))

    assert [cell.share for cell in told.values()] == [1.0, 1.0]


def kept(encoder: str) -> Embeddings:
    values = np.random.default_rng(0).normal(size=(2, 4)).astype(np.float32) * 7
    columns = {"vis": ["a", "b"], "tac": ["c", "d"], "object": ["o", "p"]}
    return Embeddings(
        header=Header(
            encoder=encoder, weights_hash="0", preprocessing="none",
            domains=("TAG-sim", "OF Real-sim"), classes=MATERIALS, simulated=True,
        ),
        vis=values, tac=-values, domain=np.array([1, 0]), label=np.array([2, 0]),
        rows=columns | {"split": ["train", "test"], "part": ["", ""], "looks_like": ["wood", ""]},
    )  # fmt: skip


def test_shipped_features_are_read_with_their_names_at_unit_length(tmp_path) -> None:
    file = tmp_path / "set.safetensors"
    save_embeddings(file, kept("efficientnet-lite0"))
    found = features_in(file)

    assert list(found.column("domain")) == ["OF Real-sim", "TAG-sim"]
    assert list(found.column("material")) == ["ceramic", "wood"]
    assert list(found.column("looks_like")) == ["wood", ""]
    np.testing.assert_allclose(np.linalg.norm(found.vis, axis=1), 1.0, rtol=1e-5)


def test_features_of_another_encoder_are_refused(tmp_path) -> None:
    file = tmp_path / "set.safetensors"
    save_embeddings(file, kept("clip-vit-b16"))
    with pytest.raises(DataError, match="holds clip-vit-b16; expected efficientnet-lite0"):
        features_in(file)


def test_real_pairs_are_predicted_by_probes_of_the_whole_set() -> None:
    features = made()
    own = features.column("domain") == "A"
    real = replace(
        _real(features), vis=features.vis[own], tac=features.tac[own],
        materials=features.column("material")[own],
    )  # fmt: skip
    found = predictions(features, real)

    assert set(found) == set(READINGS)
    assert all(len(names) == 30 for names in found.values())


def _real(features: Features):
    from benchmarks.simulated_real import Real

    none = np.array([""])
    return Real(vis=features.vis, tac=features.tac, materials=none, sensors=none)


def test_a_folder_without_labels_is_refused_by_name(tmp_path) -> None:
    with pytest.raises(DataError, match="labels.csv' is not there"):
        real_pairs(tmp_path)
    (tmp_path / "labels.csv").write_text("folder,vis,tac,material\na,v.png,t.png,felt\n")
    with pytest.raises(DataError, match="names no pair of wood, steel"):
        real_pairs(tmp_path)


def test_wilsons_interval_lies_inside_zero_and_one() -> None:
    low, high = wilson(0, 10)
    assert low == pytest.approx(0.0, abs=1e-9)
    assert high == pytest.approx(0.2775, abs=1e-3)
