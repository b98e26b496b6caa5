"""VIS: the mesh is closed, the framing fits the object, the built-in shader and camera behave."""

from collections import Counter

import numpy as np
import pytest

from omnivat.errors import MissingPackageError
from omnivat.simulate import calibrated, vision
from omnivat.simulate.camera import exposed
from omnivat.simulate.contact import Press
from omnivat.simulate.environment import panorama
from omnivat.simulate.framing import framed
from omnivat.simulate.mesh import object_mesh, unresolved_slopes
from omnivat.simulate.scenes import SCENES
from omnivat.simulate.shading import shaded
from omnivat.simulate.surfaces import Form, Surface, surface


def framing_of(domain: str, thing: Surface, seed: int = 3):
    return framed(SCENES[domain], thing, at=(0.0, 0.0), part="", seed=seed)


def flat(**changes) -> Surface:
    even = {
        "recipe": "even",
        "relief": lambda x, y: np.zeros_like(x),
        "colour": lambda x, y: np.full((*x.shape, 3), 0.5),
        "gloss": "matte",
        "roughness": 0.5,
    }
    return Surface(**(even | changes))


def test_the_object_is_a_closed_mesh() -> None:
    thing = surface("wood", 1, seed=0)
    mesh = object_mesh(thing, framing_of("TAG", thing))
    corners = np.round(mesh.vertices, 9)
    _, same = np.unique(corners, axis=0, return_inverse=True)
    edges = Counter()
    for a, b, c in same[mesh.faces.astype(int)]:
        for edge in ((a, b), (b, c), (c, a)):
            edges[tuple(sorted(edge))] += 1

    assert set(edges.values()) == {2}
    assert mesh.vertices[:, 2].min() > mesh.ground


def test_a_curved_object_is_no_wider_than_its_curvature_allows() -> None:
    rod = flat(form=Form(across=1 / 12.0))
    framing = framing_of("TQ-DIGIT", rod)

    assert framing.size[1] < 2 * 12.0
    assert framing.view <= framing.size[1] / 0.5


def test_fine_grooves_widen_the_highlight_across_them_only() -> None:
    grooved = flat(relief=lambda x, y: 0.01 * np.sin(2 * np.pi * y / 0.35))
    along, across = unresolved_slopes(grooved, framing_of("TAG", grooved))

    assert across > 0.05
    assert along < 0.01


def test_the_key_light_gives_the_same_power_small_or_large() -> None:
    thing = flat()
    framing = framing_of("OF 2.0 A", thing)
    weight = np.sin((np.arange(64) + 0.5) / 64 * np.pi)[:, None, None]
    small, large = (
        (panorama(framing, least_softness=width) * weight).sum() for width in (0.2, 0.7)
    )

    assert small == pytest.approx(large, rel=0.02)


@pytest.mark.parametrize("material", ["wood", "steel", "plastic", "ceramic", "glass"])
def test_the_built_in_shader_shows_the_object_before_its_ground(material: str) -> None:
    thing = surface(material, 2, seed=0)
    framing = framing_of("OF 2.0 B", thing)
    image = shaded(thing, framing, size=64)

    assert image.shape == (64, 64, 3)
    assert np.isfinite(image).all()
    assert image[28:36, 28:36].mean() > 2 * image[:4, :4].mean()


def test_the_camera_opens_up_for_dark_scenes_but_not_all_the_way() -> None:
    scene = SCENES["OF 2.0 A"]
    dark, bright = (exposed(np.full((16, 16, 3), v), scene, seed=0).mean() for v in (0.05, 0.8))

    assert 0.25 < dark < bright < 0.95


def gone(name: str, **said: str) -> None:
    raise MissingPackageError(f"{name} is needed for {said['purpose']}.")


def test_without_mitsuba_a_render_says_what_is_missing(monkeypatch) -> None:
    vision._mitsuba.cache_clear()
    monkeypatch.setattr(vision, "need", gone)
    with pytest.raises(MissingPackageError, match="mitsuba is needed for rendering VIS"):
        vision.rendered(flat(), framing_of("TAG", flat()), size=32)


def test_without_taxim_a_calibrated_touch_says_what_is_missing(monkeypatch) -> None:
    press = Press(at=(0.0, 0.0), turn=0.0, lean=(0.0, 0.0), depth=0.5, shear=(0.0, 0.0))
    calibrated._simulator.cache_clear()
    monkeypatch.setattr(calibrated, "need", gone)
    with pytest.raises(MissingPackageError, match="taxim is needed for tactile images"):
        calibrated.calibrated(flat(), press, "Taxim GelSight", size=32)
