"""VIS: the contact is in view, flat surfaces, the textures and the camera behave."""

from dataclasses import replace
from unittest.mock import MagicMock

import numpy as np
import pytest

from omnivat.kit.errors import MissingPackageError
from omnivat.simulate import drawing, vision
from omnivat.simulate.contact import Press
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.grounds import GROUNDS, ground
from omnivat.simulate.photograph import exposed, framed
from omnivat.simulate.plan import planned
from omnivat.simulate.scenes import OUTDOORS, SCENES
from omnivat.simulate.staging import place, textured, unresolved_slopes
from omnivat.simulate.surfaces import Surface
from omnivat.simulate.things import thing
from omnivat.simulate.vision import denoised, panorama


def thing_of(domain, material="wood", index=1):
    return thing(planned(SIMULATED[domain], material, pairs=60)[index], seed=0)


def framing_of(domain, made, seed=3):
    return framed(SCENES[domain], made, outdoors=False, seed=seed)


def flat(**changes):
    even = {
        "relief": lambda x, y: np.zeros_like(x),
        "colour": lambda x, y: np.full((*x.shape, 3), 0.5),
        "gloss": "matte",
        "roughness": 0.5,
    }
    return Surface(**(even | changes))


@pytest.mark.parametrize("domain", SCENES)
def test_the_contact_lies_in_the_picture_and_faces_the_camera(domain):
    for index in range(4):
        made = thing_of(domain, "steel", index)
        framing = framing_of(domain, made, seed=index)
        ahead = framing.target - framing.eye
        sight = made.spot.point - framing.eye
        cos = sight @ ahead / np.linalg.norm(sight) / np.linalg.norm(ahead)

        assert np.arccos(min(cos, 1.0)) < 0.75 * framing.lens
        assert -sight @ made.spot.normal > 0
        assert framing.eye[2] > 0


def test_whole_objects_fit_into_the_picture_where_a_domain_shows_them_whole():
    made = thing_of("OF Real", "ceramic")
    framing = framing_of("OF Real", made)
    extent = np.linalg.norm(np.ptp(made.solid.vertices, axis=0))

    assert framing.view > extent


def test_fine_grooves_widen_the_highlight_across_them_only():
    grooved = flat(relief=lambda x, y: 0.01 * np.sin(2 * np.pi * y / 0.35))
    along, across = unresolved_slopes(grooved, np.zeros(2), spacing=0.6)

    assert across > 0.05
    assert along < 0.01


def test_a_texture_covers_the_solid_and_its_colours_are_the_surface_s():
    made = replace(thing_of("OF Real"), sight=flat())
    texture = textured(made, framing_of("OF Real", made))

    assert texture.uv.min() >= 0.0
    assert texture.uv.max() <= 1.0
    assert np.ptp(texture.colour) == 0.0
    assert not texture.bumps.any()


def test_the_key_light_gives_the_same_power_small_or_large():
    framing = framing_of("OF 2.0 A", thing_of("OF 2.0 A"))
    weight = np.sin((np.arange(64) + 0.5) / 64 * np.pi)[:, None, None]
    small, large = (
        (panorama(framing, least_softness=width) * weight).sum() for width in (0.25, 0.7)
    )

    assert small == pytest.approx(large, rel=0.02)


def test_every_place_that_a_scene_names_can_be_drawn():
    x, y = np.meshgrid(np.linspace(-300, 300, 20), np.linspace(0, 600, 20))
    names = {n for scene in SCENES.values() for n in (*scene.ground, *scene.behind)}
    assert names.union(*OUTDOORS) == set(GROUNDS)
    colours = [ground(name, x, y, seed=1) for name in GROUNDS]

    assert all(colour.shape == (20, 20, 3) for colour in colours)
    assert all(0.0 <= colour.min() <= colour.max() <= 1.0 for colour in colours)


def test_the_camera_opens_up_for_dark_scenes_but_not_all_the_way():
    scene = SCENES["OF 2.0 A"]
    dark, bright = (exposed(np.full((16, 16, 3), v), scene, seed=0).mean() for v in (0.02, 0.8))

    assert 0.1 < dark < bright < 0.98


def test_grain_is_taken_out_and_edges_of_colour_stay():
    rng = np.random.default_rng(0)
    colour = np.where(np.arange(48)[None, :, None] < 24, 0.2, 0.8) * np.ones((48, 48, 3))
    normal = np.broadcast_to([0.0, 0.0, 1.0], (48, 48, 3))
    noisy = colour * rng.gamma(12.0, 1 / 12.0, (48, 48, 1))
    clean = denoised(noisy, colour, normal)

    assert np.abs(clean - colour).mean() < 0.35 * np.abs(noisy - colour).mean()
    assert clean[:, 25].mean() - clean[:, 22].mean() > 0.5


def gone(name, **said):
    raise MissingPackageError(f"{name} is needed for {said['purpose']}.")


def test_the_ground_and_what_stands_behind_vary_across_and_along():
    made = thing_of("TAG")
    shapes = place(MagicMock(Bitmap=np.asarray), made, framing_of("TAG", made))
    for name in ("ground", "behind"):
        colours = shapes[name]["bsdf"]["bsdf"]["reflectance"]["bitmap"]
        assert min(colours.std(0).max(), colours.std(1).max()) > 0.02


def test_without_mitsuba_a_render_says_what_is_missing(monkeypatch):
    vision._mitsuba.cache_clear()
    monkeypatch.setattr(vision, "need", gone)
    made = thing_of("TAG")
    with pytest.raises(MissingPackageError, match="mitsuba is needed for rendering VIS"):
        vision.rendered(made, framing_of("TAG", made), size=32)


def test_without_taxim_a_calibrated_touch_says_what_is_missing(monkeypatch):
    press = Press(turn=0.0, lean=(0.0, 0.0), depth=0.5, shear=(0.0, 0.0))
    drawing._simulator.cache_clear()
    monkeypatch.setattr(drawing, "need", gone)
    with pytest.raises(MissingPackageError, match="taxim is needed for tactile images"):
        drawing.calibrated(thing_of("OF 2.0 A"), press, "CALIB_GELSIGHT", size=32)
