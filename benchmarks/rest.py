"""What a rest picture is worth beside a profile: the simulated tactile images, embedded in three ways.

    python -m benchmarks.rest [--pairs 774] [--cache build/rest.npz] [--out docs/benchmarks/rest.json]

Tactile images of pairs drawn from the shipped set are drawn again (the simulator's packages are needed; photos are
not drawn) and embedded as they come, minus the rest picture of their sensor, and minus the one of their own gel.
Then logistic regression (C = 1) on standardised unit embeddings: one source, seven targets, eight sources, test
objects only; with the target as it comes, and with the profile of its training pairs.
"""

import argparse
import json
from pathlib import Path
from typing import Any

import numpy as np
from PIL import Image

from benchmarks._ladder_methods import logistic, onto, profile, unit
from omnivat.data.domains import simulated
from omnivat.data.profile import standardised
from omnivat.data.rest import has_markers, minus_rest
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.kit.files import write_json
from omnivat.kit.seeding import derive_seed
from omnivat.study.reports.intervals import bootstrap_interval

WAYS = {
    "plain": "as they come",
    "auto": "minus the sensor's rest picture, gels with markers left out",
    "rest": "minus the sensor's rest picture",
    "own": "minus the rest picture of each press's own gel",
}
Arrays = dict[str, np.ndarray[Any, Any]]


def embedded(found: Embeddings, count: int) -> Arrays:
    """Return TAC embeddings (N, D) in three ways, and the `rows` that were drawn."""
    from omnivat.encoders import load_encoder
    from omnivat.simulate.domains import SIMULATED
    from omnivat.simulate.drawing import resting, tactile
    from omnivat.simulate.plan import classes, planned
    from omnivat.simulate.things import thing

    encoder = load_encoder("efficientnet-lite0")
    plan = {
        (simulated(pair.domain), pair.material, pair.object): pair
        for domain in SIMULATED.values()
        for material in classes(domain)
        for pair in planned(domain, material, pairs=60)
    }

    def picture(pixels: Any) -> Image.Image:
        return Image.fromarray(np.round(pixels * 255).astype(np.uint8))

    def vector(image: Image.Image) -> Any:
        return encoder.embed(encoder.preprocess(image)[None])[0].numpy()

    rests = {name: picture(resting(made.sensor, size=224)) for name, made in SIMULATED.items()}
    rows = np.random.default_rng(0).permutation(len(found))[:count]
    arrays = {way: np.zeros((len(found), found.width), np.float32) for way in ("plain", "rest", "own")}
    for row in rows:
        domain = found.header.domains[found.domain[row]]
        pair = plan[domain, found.header.classes[found.label[row]], found.rows["object"][row]]
        stream = derive_seed(0, "pair", pair.domain, pair.material, pair.object)
        image = picture(tactile(thing(pair, seed=0), pair.made.sensor, stream, size=224))
        own = picture(resting(pair.made.sensor, size=224, stream=stream))
        arrays["plain"][row] = vector(image)
        arrays["rest"][row] = vector(minus_rest(image, rests[pair.domain]))
        arrays["own"][row] = vector(minus_rest(image, own))
    return {**arrays, "rows": np.sort(rows)}


def measured(found: Embeddings, arrays: Arrays) -> dict[str, Any]:
    """Return accuracy (%) by way, images and knowledge, and gains with intervals over sources."""
    markers = np.array([has_markers(name) for name in found.header.domains])[found.domain]
    touch = {**arrays, "auto": np.where(markers[:, None], arrays["plain"], arrays["rest"])}
    drawn = np.isin(np.arange(len(found)), arrays["rows"])
    split = np.array(found.rows["split"])
    shares: dict[str, dict[str, list[float]]] = {}
    for way in WAYS:
        for source, name in enumerate(found.header.domains):
            for key, values in _of(found, touch[way], drawn, split, source).items():
                shares.setdefault(f"{way}, {key}", {})[name] = [float(np.mean(values))]
    record = {key: float(np.mean(list(by.values()))) for key, by in shares.items()}
    gains = {}
    for images in ("both", "touch"):
        first = shares[f"plain, {images}, nothing"]
        base = shares[f"plain, {images}, profile"]
        for way in WAYS:
            for known, start in (("nothing", first), ("profile", base)):
                own = shares[f"{way}, {images}, {known}"]
                if way != "plain":
                    gains[f"{way} over plain, {images}, {known}"] = _interval(own, start)
        gains[f"profile over nothing, plain, {images}"] = _interval(base, first)
    return {"pairs": int(drawn.sum()), "ways": WAYS, "accuracy": record, "gains": gains}


def _interval(own: dict[str, list[float]], base: dict[str, list[float]]) -> list[float]:
    one = bootstrap_interval({name: [own[name][0] - base[name][0]] for name in own})
    return [one.mean, one.low, one.high]


def _of(found: Embeddings, tac: Any, drawn: Any, split: Any, source: int) -> dict[str, list[float]]:
    """Return "images, knowledge" -> accuracy (%) in each unseen domain."""

    def rows(domain: int, part: str) -> Any:
        return np.flatnonzero(drawn & (found.domain == domain) & (split == part))

    def pair(index: Any) -> Any:
        return found.vis[index], tac[index]

    train = rows(source, "train")
    own = profile(pair(train))
    shares: dict[str, list[float]] = {}
    for images, names in (("both", ("vis", "tac")), ("touch", ("tac",))):

        def inputs(given: Any, names: Any = names) -> Any:
            parts = dict(zip(("vis", "tac"), given, strict=True))
            return np.hstack([unit(standardised(parts[n], own[n])) for n in names])

        model = logistic(inputs(pair(train)), found.label[train], len(found.header.classes))
        for target in range(len(found.header.domains)):
            test = rows(target, "test")
            test = test[np.isin(found.label[test], found.label[train])]
            if target == source:
                continue
            for known in ("nothing", "profile"):
                there = profile(pair(rows(target, "train"))) if known == "profile" else None
                said = model(inputs(onto(pair(test), there, own))).argmax(1)
                right = 100 * float((said == found.label[test]).mean())
                shares.setdefault(f"{images}, {known}", []).append(right)
    return shares


def main() -> None:
    """Draw and embed where needed, measure, print, write."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="the set")
    parser.add_argument("--pairs", type=int, default=774, help="pairs to draw again")
    parser.add_argument("--cache", type=Path, default=Path("build/rest.npz"), help="their vectors")
    parser.add_argument("--out", type=Path, help="JSON file to write")
    options = parser.parse_args()
    found = load_embeddings(options.embeddings)
    if not options.cache.is_file():
        options.cache.parent.mkdir(parents=True, exist_ok=True)
        np.savez(options.cache, **embedded(found, options.pairs))  # type: ignore[arg-type]
    record = measured(found, dict(np.load(options.cache)))
    print(json.dumps(record, indent=1))
    if options.out:
        write_json(options.out, record)


if __name__ == "__main__":
    main()
