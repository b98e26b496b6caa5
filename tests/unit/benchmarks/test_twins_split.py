"""The split of a loss between two domains, on predictions written down by hand."""

import numpy as np
import pytest

from benchmarks.twins import GROUPS, answers, changed, split
from omnivat.data.embeddings import Embeddings, Header
from omnivat.measure.twins import Twins
from omnivat.simulate.sensors import GELS

NAMES = ("A-sim", "B-sim")
HEADER = Header(
    encoder="e", weights_hash="w", preprocessing="p", domains=NAMES, classes=("wood", "steel")
)
LABEL = np.array([0, 1] * 5)


def rows(count: int, code: int) -> np.ndarray:
    """Rows (count, 2) of a class for each row, and a code that says which pictures they are."""
    return np.stack([LABEL[:count], np.full(count, code)], axis=1).astype(np.float32)


def made() -> Twins:
    nothing = ("",) * 10
    return Twins(
        vis=np.stack([rows(10, 1), rows(10, 2)], axis=1), tac=np.stack([rows(10, 10), rows(10, 20)], axis=1),
        filled=np.stack([rows(10, 10), rows(10, 20)], axis=1), label=LABEL, objects=nothing, looks_like=nothing,
        feels_like=nothing, header=HEADER, as_filled="", printed=rows(0, 0), rows=np.zeros(0, int),
    )  # fmt: skip


def pairs() -> Embeddings:
    names = {name: [""] * 20 for name in ("object", "part")} | {"split": ["test"] * 20}
    domain, label = np.repeat([0, 1], 10), np.tile(LABEL, 2)
    vis, tac = (np.concatenate([rows(10, k), rows(10, 2 * k)]) for k in (1, 10))
    return Embeddings(header=HEADER, vis=vis, tac=tac, domain=domain, label=label, rows=names)


def read(vis: np.ndarray, tac: np.ndarray) -> dict[str, np.ndarray]:
    """A head of A: each foreign picture makes it wrong on rows of its own; both on two more."""
    wrong = {"vis": 2 * (vis[:, 1] == 2), "tac": 4 * (tac[:, 1] == 20)}
    wrong["fused"] = wrong["vis"] + wrong["tac"] + 2 * ((wrong["vis"] > 0) & (wrong["tac"] > 0))
    truth, place = vis[:, 0].astype(int), np.arange(len(vis))
    return {name: np.where(place < count, 1 - truth, truth) for name, count in wrong.items()}


def test_the_terms_are_what_the_sensor_the_scene_and_both_cost_and_sum_to_the_loss() -> None:
    said = answers(read, made(), pairs(), "A-sim", filled=False)
    found = split({"A-sim": said}, made(), pairs())

    both = {term: cell[0] for term, cell in found["both"].items() if term != "by_source"}
    assert both == {
        "home": 100, "new_objects": 0, "sensor": 40, "scene": 20, "interplay": 20, "objects": 0, "away": 20,
    }  # fmt: skip
    assert both["home"] - both["away"] == sum(
        both[term] for term in ("sensor", "scene", "interplay", "objects")
    )
    assert (found["touch"]["sensor"][0], found["touch"]["scene"][0]) == (40, 0)
    assert (found["photo"]["sensor"][0], found["photo"]["scene"][0]) == (0, 20)
    assert found["both"]["by_source"]["A-sim"]["interplay"] == 20


def test_every_part_of_a_gel_is_in_one_group() -> None:
    names = [name for group in GROUPS.values() for name in group]

    assert sorted(names) == sorted(GELS["DIGIT"].__dataclass_fields__)


@pytest.mark.parametrize("group", GROUPS)
def test_a_changed_gel_differs_in_its_group_alone(group: str) -> None:
    gel = changed("GelSight", "DIGIT", group)

    for name in GELS["DIGIT"].__dataclass_fields__:
        assert getattr(gel, name) == getattr(
            GELS["DIGIT" if name in GROUPS[group] else "GelSight"], name
        )
