"""What a gel's lamps cost after its dots are filled, and five ways to be rid of their colours.

    python -m benchmarks.lamps [--learn 20] [--test 15] [--out docs/benchmarks/lamps.json]

A logistic regression learns touches of GelSight, dots filled, and reads new presses of the same
objects imaged by each gel. Every way changes the pictures of both. "turned": a picture less its
blurred self is taken apart into two slopes by the lamps' colours and directions, as `SENSORS` has
them, and drawn again with GelSight's lamps. Tac3D has no lamps and stays as it is.
"""

import argparse
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image
from scipy.ndimage import gaussian_filter
from sklearn.linear_model import LogisticRegression

from omnivat.data.dots import fill_dots
from omnivat.encoders import load_encoder
from omnivat.encoders.cache import embed_image
from omnivat.kit.files import write_json
from omnivat.kit.seeding import derive_seed
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.drawing import tactile
from omnivat.simulate.plan import classes, planned
from omnivat.simulate.sensors import SENSORS, Sensor
from omnivat.simulate.things import thing
from omnivat.study.shift.measure import interval

HOME, NEW = "GelSight", 87_000  # number of the first object; no set has these
NAMES = [name for name in SENSORS if not name.startswith("Taxim")]
WIDE = 24.0  # pixels: blur that leaves only slow light
COPIES = 2  # of a training picture with mixed channels

Array = np.ndarray[Any, np.dtype[Any]]


def colours_of(name: str) -> Array:
    """Return what a slope to the right and one downwards add to the three colours, (3, 2)."""
    sensor = SENSORS[name]
    assert isinstance(sensor, Sensor)
    parts = []
    for lamp in sensor.lamps:
        angle = np.radians(lamp.azimuth)
        parts.append(np.outer(lamp.colour, (np.cos(angle), np.sin(angle))))
    return np.asarray(sensor.gain * np.sum(parts, 0))


def slopes(picture: Array, name: str) -> tuple[Array, Array]:
    """Return two slopes (H, W, 2) and the slow light (H, W, 3) of a picture."""
    slow = np.stack([gaussian_filter(c, WIDE) for c in np.moveaxis(picture, 2, 0)], 2)
    return (picture - slow) @ np.linalg.pinv(colours_of(name)).T, slow


def turned(picture: Array, name: str) -> Array:
    if name == "Tac3D":
        return picture
    found, slow = slopes(picture, name)
    return np.asarray(slow + found @ colours_of(HOME).T)


def as_slopes(picture: Array, name: str) -> Array:
    if name == "Tac3D":
        return picture
    found = 255 * np.tanh(slopes(picture, name)[0] / 255)
    return 128 + np.dstack([found / 2, np.hypot(*np.moveaxis(found, 2, 0)) / 2])


def grey(picture: Array, name: str) -> Array:
    return np.repeat(picture.mean(2, keepdims=True), 3, 2)


def levelled(picture: Array, name: str) -> Array:
    """Return each channel with one mean and spread."""
    return np.asarray(128 + 40 * (picture - picture.mean((0, 1))) / (picture.std((0, 1)) + 1))


WAYS: dict[str, Callable[[Array, str], Array]] = {
    "as it is": lambda picture, name: picture,
    "colours turned to GelSight's lamps": turned,
    "slopes in place of colours": as_slopes,
    "grey": grey,
    "each channel of one mean and spread": levelled,
}


def mixed(picture: Array, random: np.random.Generator) -> Array:
    """Return a picture whose colour differences are turned at random."""
    turn, _ = np.linalg.qr(random.normal(size=(3, 3)))
    middle = picture.mean((0, 1))
    return np.asarray(middle + (picture - middle) @ turn.T)


def drawn(pairs: list[Any], name: str) -> list[Array]:
    """Return the touches of planned pairs by a sensor, dots filled, 0 to 255."""
    touches = []
    for pair in pairs:
        stream = derive_seed(0, "pair", pair.domain, pair.material, pair.object)
        touch = 255 * tactile(thing(pair, seed=0), SENSORS[name], stream, size=224)
        touches.append(fill_dots(touch.round().astype(np.uint8))[0].astype(float))
    return touches


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--learn", type=int, default=20, help="presses of each class")
    parser.add_argument("--test", type=int, default=15, help="presses of each class")
    parser.add_argument("--out", type=Path, default=Path("docs/benchmarks/lamps.json"))
    options = parser.parse_args()
    encoder = load_encoder("efficientnet-lite0")
    domain = replace(SIMULATED["TAG"], seed_base=NEW)
    learn, test = [], []
    for material in classes(domain):
        pairs = planned(domain, material, pairs=60)
        learn += pairs[: options.learn]
        test += pairs[options.learn : options.learn + options.test]

    def rows(pictures: list[Array]) -> Array:
        images = (Image.fromarray(p.round().clip(0, 255).astype(np.uint8)) for p in pictures)
        made = np.stack([embed_image(encoder, image) for image in images])
        return np.asarray(made / np.linalg.norm(made, axis=1, keepdims=True))

    own, truth = drawn(learn, HOME), np.array([pair.material for pair in test])
    labels = [pair.material for pair in learn]
    seen = {name: drawn(test, name) for name in NAMES}
    random, right = np.random.default_rng(0), {}
    plain = {name: rows(pictures) for name, pictures in seen.items()}
    for way, change in {**WAYS, "channels mixed in training": WAYS["as it is"]}.items():
        if way == "channels mixed in training":
            copies = [mixed(p, random) for _ in range(COPIES) for p in own]
            known, named = rows(own + copies), labels * (1 + COPIES)
            shown = plain
        else:
            known, named = rows([change(p, HOME) for p in own]), labels
            shown = {n: rows([change(p, n) for p in seen[n]]) for n in NAMES}
        mean, spread = known.mean(0), known.std(0) + 1e-6
        head = LogisticRegression(C=0.003, max_iter=1500).fit((known - mean) / spread, named)
        right[way] = {
            n: (head.predict((x - mean) / spread) == truth).astype(float) for n, x in shown.items()
        }
        print(way, {n: round(100 * x.mean(), 1) for n, x in right[way].items()}, flush=True)
    record = {}
    for way, found in right.items():
        away = np.mean([found[n] for n in NAMES if n != HOME], 0)
        gain = away - np.mean([right["as it is"][n] for n in NAMES if n != HOME], 0)
        record[way] = {
            "of each sensor": {n: round(100 * float(x.mean()), 1) for n, x in found.items()},
            "five others": numbers(away),
            "less as it is": numbers(gain),
        }
    write_json(options.out, {"learned": len(learn), "presses": len(test), "percent": record})


def numbers(values: Array) -> list[float]:
    """Return the mean in percent and its 95 % interval over presses."""
    low, high = interval(values, np.arange(len(values)))
    return [round(100 * one, 1) for one in (float(values.mean()), low, high)]


if __name__ == "__main__":
    main()
