"""Solids are closed, stand on the ground at true scale, and can be touched from outside."""

from collections import Counter

import numpy as np
import pytest

from simulator.shapes import KINDS, blocked, made_of
from simulator.shapes.solid import block


def made(kind, *, material="ceramic", seed=1):
    rng = np.random.default_rng(seed)
    return KINDS[kind](rng, made_of(material, rng))


def borders(solid):
    """Count the edges of faces that are open, or passed twice the same way."""
    _, same = np.unique(np.round(solid.vertices, 2), axis=0, return_inverse=True)
    edges = Counter()
    for a, b, c in same.ravel()[solid.faces]:
        if len({a, b, c}) == 3:
            edges.update([(a, b), (b, c), (c, a)])
    return Counter({e: n for e, n in edges.items() if edges[e[::-1]] != n})


@pytest.mark.parametrize("kind", ["bowl", "plate", "tray", "tile"])
def test_a_solid_is_closed(kind):
    assert not borders(made(kind))


@pytest.mark.parametrize("kind", KINDS)
def test_every_kind_stands_on_the_ground_and_faces_outwards(kind):
    solid = made(kind)
    corner = solid.vertices[solid.faces]
    volume = np.einsum("fd,fd->f", corner[:, 0], np.cross(corner[:, 1], corner[:, 2])).sum() / 6

    assert solid.vertices[:, 2].min() == pytest.approx(0.0, abs=0.1)
    assert volume > 1000  # mm³; negative if the faces looked inwards
    assert 60 < np.ptp(solid.vertices, axis=0).max() < 1000
    assert np.isfinite(solid.normals()).all()
    assert solid.faces.max() < len(solid.vertices) == len(solid.uv)


def test_what_lies_behind_a_wall_is_blocked():
    wall = block((2.0, 50.0, 50.0), bevel=0.5)

    assert blocked(wall, np.array([-10.0, 1.0, 2.0]), np.array([10.0, 1.0, 2.0]))
    assert not blocked(wall, np.array([-10.0, 1.0, 2.0]), np.array([-5.0, 1.0, 2.0]))
