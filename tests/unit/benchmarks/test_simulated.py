"""The measures of the simulated set, on vectors whose result is known."""

import numpy as np

from benchmarks.simulated import READINGS, _gain, by_source, matrix, predictions
from tests.builders import embeddings_of

CLASSES = ("wood", "steel", "ceramic")


def made():
    """Return domains A and B of ten pairs a class. In B, wood and steel have changed places by
    touch.

    One pair of three looks like another class: its photo is that of the class after its own.
    """
    random = np.random.default_rng(3)
    kept = [(d, c, n) for d in range(2) for c in range(3) for n in range(10)]
    domain, label, number = map(np.array, zip(*kept, strict=True))
    alike = number % 3 == 0
    seen, felt = (
        np.where(alike, (label + 1) % 3, label),
        np.where(domain == 1, np.array([1, 0, 2])[label], label),
    )
    vis, tac = (
        np.eye(5)[place] * 9 + random.normal(size=(len(kept), 5)) * 0.1 for place in (seen, felt)
    )
    names = [str(row) for row in kept]
    rows = {"vis": names, "tac": names, "object": names}
    rows["split"] = ["test" if n < 3 else "train" for n in number]
    rows["looks_like"] = [CLASSES[c] if a else "" for c, a in zip(seen, alike, strict=True)]
    return embeddings_of(
        vis, tac, domain, label, domains=("A-sim", "B-sim"), classes=CLASSES, rows=rows
    )


def test_a_probe_is_right_within_a_domain_and_wrong_where_classes_changed_places():
    pairs = made()
    shares = matrix(predictions(pairs)["TAC"], pairs, np.ones(60, bool))
    np.testing.assert_allclose(np.diag(shares), 1.0)
    np.testing.assert_allclose(by_source(shares, home=False), 1 / 3)


def test_touch_tells_what_looks_alike_and_both_images_use_it():
    pairs = made()
    said, alike = predictions(pairs), np.array(pairs.rows["looks_like"]) != ""
    vis, tac, both = (by_source(matrix(said[name], pairs, alike), home=True) for name in READINGS)
    assert vis.max() == 0 and tac.min() == 1 and both.min() > 0.6


def test_a_gain_has_students_interval():
    """Sleep data of Student (1908): mean 1.58, 95 % interval 0.70 to 2.46."""
    sleep = np.array([1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4])
    assert _gain(sleep / 100, np.zeros(10)) == "+1.6 [0.7, 2.5]"
