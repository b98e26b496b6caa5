"""The simulator draws what it drew for the shipped set.

`as_shipped.json` holds three numbers of everything below, from a state whose pictures by Mitsuba
3.9.1 and Taxim 1.4.1 were the shipped ones but for what JPEG loses. If the set is drawn anew, write
the file again: `python -m simulator.tests.test_as_shipped`.
"""

import json
import zlib
from functools import partial
from pathlib import Path
from types import SimpleNamespace
from unittest.mock import patch

import numpy as np
import pytest

from omnivat.data.images import read_image
from simulator import drawing, vision
from simulator.domains import SIMULATED
from simulator.grounds import GROUNDS, ground
from simulator.noise import plane
from simulator.plan import PAIRS, classes, planned
from simulator.props import props
from simulator.renderer import mitsuba
from simulator.scenes import SCENES
from simulator.sensors import Sensor, TaximSensor
from simulator.shapes import KINDS, made_of
from simulator.surfaces import RECIPES, SKINS
from simulator.tests.stand_ins import Mitsuba, Transform, packages

FILE = Path(__file__).with_name("as_shipped.json")
SHIPPED = Path(__file__).parents[2] / "examples" / "pairs"
X, Y = plane(18.0, 40)


def shape(kind, seed):
    rng = np.random.default_rng(seed)
    material = list(RECIPES)[seed]
    solid = KINDS[kind](rng, made_of(material, rng))
    return solid.vertices, solid.faces, solid.uv, solid.normals(), rng.random()


def surface(recipe, seed):
    rng = np.random.default_rng(seed)
    made = recipe(rng)
    facts = made.gloss, made.roughness, made.brushing, made.angle, rng.random()
    return made.relief(X, Y), made.colour(X, Y), facts


def skin(material, seed):
    rng = np.random.default_rng(seed)
    return SKINS[material](rng, 0.3)(X, Y), rng.random()


def hand(seed):
    spot = SimpleNamespace(point=np.array([5.0, 9.0, 30.0]), normal=np.array([0.0, 0.6, 0.8]))
    seen = {"scene": SCENES["TAG"], "spot": spot, "eye": np.array([90.0, 150.0, 300.0])}
    with patch("simulator.props.mitsuba", Mitsuba):
        return props(SimpleNamespace(**seen, held=True, seed=seed))


def image(pair, kind):
    """Return an image, and the scene that Mitsuba was to render."""
    modules = packages()
    mitsuba.cache_clear()
    drawing._simulator.cache_clear()
    with patch.dict("sys.modules", modules):
        seen = drawing.drawn(pair, kind, seed=0, size=48, renderer=vision.rendered)
        still = drawing.resting(pair.made.sensor, size=24) if kind == "tac" else ()
    mitsuba.cache_clear()
    drawing._simulator.cache_clear()
    return seen, still, getattr(modules["mitsuba"], "rendered", ())


SHAPES = {f"{kind} {k}": partial(shape, kind, k) for kind in KINDS for k in range(3)}
SURFACES = {
    f"{material} {recipe.__name__} {k}": partial(surface, recipe, k)
    for material, recipes in RECIPES.items()
    for recipe in recipes
    for k in range(3)
}
SKINNED = {
    f"skin of {material} {k}": partial(skin, material, k) for material in SKINS for k in (0, 1)
}
FLOORS = {
    f"{name} {k}": partial(ground, name, 40 * X, 40 * Y, seed=k) for name in GROUNDS for k in (0, 1)
}
QUICK = {**SHAPES, **SURFACES, **SKINNED, **FLOORS, "hand": partial(hand, 0)}
# one photo and one touch of every domain; together they are of every class
SLOW = {
    f"{kind} {pair.object}": partial(image, pair, kind)
    for number, domain in enumerate(SIMULATED.values())
    for step, kind in enumerate(("vis", "tac"))
    for material in [classes(domain)[(number + 2 * step) % len(classes(domain))]]
    for pair in planned(domain, material, pairs=PAIRS)[number : number + 1]
}


def parts(value):
    """Yield everything in a record as arrays of numbers."""
    if isinstance(value, Transform):
        value = value.steps
    if isinstance(value, dict):
        value = [part for item in value.items() for part in item]
    if isinstance(value, (list, tuple)):
        for part in value:
            yield from parts(part)
    elif isinstance(value, str):
        yield np.array([zlib.crc32(value.encode()) % 997])
    elif value is not None:
        yield np.ravel(value)


def figures(value):
    """Return how many numbers a record has, and two sums in which each has a weight of its own."""
    numbers = np.concatenate([*parts(value)]).astype(np.float64)
    place = np.arange(len(numbers))
    return [len(numbers), float(numbers @ np.cos(place)), float(numbers @ np.sin(place))]


@pytest.mark.parametrize(
    "name", [*QUICK, *(pytest.param(name, marks=pytest.mark.slow) for name in SLOW)]
)
def test_everything_is_drawn_as_it_was_for_the_shipped_set(name):
    wanted = json.loads(FILE.read_text(encoding="utf-8"))[name]
    assert figures((QUICK | SLOW)[name]()) == pytest.approx(wanted, rel=1e-7, abs=1e-7)


@pytest.mark.slow
@pytest.mark.parametrize("domain", SIMULATED)
def test_a_touch_is_the_shipped_picture_but_for_what_jpeg_loses(domain):
    made = SIMULATED[domain]
    if isinstance(made.sensor, TaximSensor):
        pytest.skip("drawn by Taxim, which is not installed")
    file = min((SHIPPED / f"{domain}-sim").glob("*/*_tac.jpg"))
    plan = planned(made, file.parent.name, pairs=PAIRS)
    pair = next(p for p in plan if Path(p.object).name == file.stem.removesuffix("_tac"))
    seen = drawing.drawn(pair, "tac", seed=0, size=224, renderer=None)
    lost = np.abs(seen - np.asarray(read_image(file)) / 255).mean()
    assert lost < (0.015 if isinstance(made.sensor, Sensor) else 0.003)


if __name__ == "__main__":
    kept = {name: figures(draw()) for name, draw in (QUICK | SLOW).items()}
    FILE.write_text(json.dumps(kept, indent=0), encoding="utf-8")
