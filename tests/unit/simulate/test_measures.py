"""The measures of the simulated set, on vectors whose answer is known."""

import numpy as np
import pytest

from benchmarks.simulated import features_in
from benchmarks.simulated_probe import (
    cross_validated,
    fitted,
    probe_matrix,
    sensor_accuracy,
    within_with,
)
from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.store import save_embeddings
from omnivat.errors import DataError

MATERIALS = ("wood", "steel", "ceramic")
RANDOM = np.random.default_rng(3)


def made(*, ceramic_in_b: bool) -> dict[str, np.ndarray]:
    """Return two domains of ten pairs a class; in B, wood and steel have changed places."""
    rows = [
        (domain, material, "test" if n < 3 else "train", f"{domain}{material}{n // 2}")
        for domain in "AB"
        for material in MATERIALS
        for n in range(10)
        if domain == "A" or material != "ceramic" or ceramic_in_b
    ]
    domains, materials, splits, objects = map(np.array, zip(*rows, strict=True))
    swapped = {"wood": 1, "steel": 0, "ceramic": 2}
    where = [MATERIALS.index(m) if d == "A" else swapped[m] for d, m, *_ in rows]
    values = np.eye(5)[where] * 4 + RANDOM.normal(size=(len(rows), 5)) * 0.1
    values[:, 4] += 10 * (domains == "B")
    names = {"domains": domains, "materials": materials, "splits": splits}
    return {"values": values.astype(np.float32), **names, "objects": objects}


def matrix(given):
    return probe_matrix(**{k: v for k, v in given.items() if k != "objects"})


def test_a_probe_is_right_within_a_domain_and_wrong_where_classes_changed_places():
    found = matrix(made(ceramic_in_b=True))

    assert found["A", "A"].share == found["B", "B"].share == 1.0
    assert found["A", "B"].share == pytest.approx(1 / 3)


def test_ceramic_is_left_out_where_either_domain_has_none():
    found = matrix(made(ceramic_in_b=False))

    assert found["A", "A"].of == 9  # three test pairs of three classes
    assert found["A", "B"].of == found["B", "A"].of == 20  # all of wood and steel


def test_more_objects_are_never_taken_than_asked_for():
    given = made(ceramic_in_b=True)
    given["values"][given["domains"] == "A"] += RANDOM.normal(size=(30, 5)) * 3

    few, many = (within_with(**given, count=n)["A"].share for n in (1, 4))
    assert few < many


def test_cross_validation_asks_about_objects_that_were_not_trained_on():
    """Every object looks like nothing else, its pairs alike: who had seen it would know it."""
    objects = np.repeat([f"o{number}" for number in range(60)], 4)
    materials = np.repeat(RANDOM.choice(MATERIALS, 60), 4)
    values = np.repeat(np.eye(60, dtype=np.float32), 4, axis=0)

    found = cross_validated(values, materials=materials, objects=objects, strength=1.0)
    assert found.of == 240
    assert found.share < 0.6
    assert (fitted(values, materials)(values) == materials).all()


def test_a_probe_ignores_the_scale_of_a_feature():
    given = made(ceramic_in_b=True)
    here = given["domains"] == "A"
    wide = given["values"][here] * [1, 10, 100, 1, 1]

    assert (fitted(wide, given["materials"][here])(wide) == given["materials"][here]).all()


def test_a_sensor_is_told_by_its_nearest_training_image():
    given = made(ceramic_in_b=True)
    values = given["values"] / np.linalg.norm(given["values"], axis=1, keepdims=True)
    told = sensor_accuracy(values, domains=given["domains"], splits=given["splits"])

    assert [cell.share for cell in told.values()] == [1.0, 1.0]


def kept(encoder: str) -> Embeddings:
    values = RANDOM.normal(size=(2, 4)).astype(np.float32) * 7
    columns = {"vis": ["a", "b"], "tac": ["c", "d"], "object": ["o", "p"]}
    return Embeddings(
        header=Header(
            encoder=encoder, weights_hash="0", preprocessing="none",
            domains=("TAG-sim", "OF Real-sim"), classes=MATERIALS, simulated=True,
        ),
        vis=values, tac=-values, domain=np.array([1, 0]), label=np.array([2, 0]),
        rows=columns | {"split": ["train", "test"], "part": ["", ""]},
    )  # fmt: skip


def test_shipped_features_are_read_with_their_names_at_unit_length(tmp_path):
    file = tmp_path / "set.safetensors"
    save_embeddings(file, kept("efficientnet-lite0"))
    found = features_in(file)

    assert list(found.column("domain")) == ["OF Real-sim", "TAG-sim"]
    assert list(found.column("material")) == ["ceramic", "wood"]
    np.testing.assert_allclose(np.linalg.norm(found.vis, axis=1), 1.0, rtol=1e-5)


def test_features_of_another_encoder_are_refused(tmp_path):
    file = tmp_path / "set.safetensors"
    save_embeddings(file, kept("clip-vit-b16"))
    with pytest.raises(DataError, match="holds clip-vit-b16; wanted efficientnet-lite0"):
        features_in(file)
