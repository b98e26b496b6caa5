"""What the sensor alone costs, and what in it (docs/twins.md).

    python -m benchmarks.twins --pack FOLDER      examples/twins.npz: twins, embedded with the dots
                                                  kept and filled
    python -m benchmarks.twins --page FOLDER      examples/twins.json, twins.map.json and twins/,
                                                  for the page
    python -m benchmarks.twins --split METHOD,... home, sensor changed, scene changed, both, other
                                                  objects
    python -m benchmarks.twins --parts 12         one group of a gel's parts changed at a time, on
                                                  so many new presses of each class
    python -m benchmarks.twins                    docs/benchmarks/twins.json and twins.svg from
                                                  what was measured, and the split for the page

FOLDER is what `omnivat simulate --set twins` drew; of an interrupted drawing, objects count as
photographed that have all photographs. `--learn KEPT FILLED` are the embeddings that heads learn
from: the simulated domains, with the dots kept and filled. Results wait in build/twins.
"""

import argparse
import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray
from PIL import Image
from sklearn.linear_model import LogisticRegression

from benchmarks._twins_page import (
    Plain,
    about,
    learned,
    moved,
    own_twin,
    page,
    rows_of,
    sheets,
    threads,
    write_json,
)
from omnivat.data.domains import paper_name
from omnivat.data.dots import fill_dots
from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import channels_of
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.figures.scores import dots as dot_figure
from omnivat.figures.still import svg_of
from omnivat.head.heads import EXAMPLES
from omnivat.kit.files import write_text
from omnivat.kit.seeding import derive_seed
from omnivat.kit.tables import load
from omnivat.kit.threads import one_thread
from omnivat.measure.twins import Twins, twins, write_twins
from omnivat.simulate.build import image_path
from omnivat.simulate.contact import pressed_height
from omnivat.simulate.domains import SIMULATED
from omnivat.simulate.drawing import pressing
from omnivat.simulate.plan import Planned
from omnivat.simulate.sensors import GELS, Sensor
from omnivat.simulate.tactile import imaged
from omnivat.simulate.twins import Twin, pressed, unmet_objects
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Source
from omnivat.training import TrainSettings, Watch
from omnivat.training.from_pairs import plan_training
from omnivat.training.loop import train_once

Array = NDArray[Any]
BUILD, OUT = Path("build/twins"), Path("docs/benchmarks")
RECIPE = {"noise": 4.0, "shift": 1.0, "epochs": 120}  # of OmniVaT, as in examples/make.sh
READINGS = {"touch": "tac", "photo": "vis", "both": "fused"}
DRAWS = 1000
DOTS = ("kept", "filled")
METHODS = ("linear_maps", "erm_mlp", "omnivat")
GROUPS = {
    "markers": ("markers", "plain_gels"),
    "lamps": ("lamps", "gain"),
    "camera": ("vignette", "noise", "blur"),
    "field, depth": ("field", "depth"),
    "softness": ("skin", "give", "dome"),
    "tint": ("base",),
}
HUB = "GelSight"  # the sensor that the page's head learned from
# VIS and TAC (n, W) -> reading -> (n,) predicted classes
Reads = Callable[[Array, Array], dict[str, Array]]


def gathered(folder: Path, learning: Sequence[Embeddings]) -> Twins:
    """Embed the twins of a folder, with the dots kept and filled."""
    encoder, plan = load_encoder("efficientnet-lite0"), unmet_objects()
    header = learning[0].header

    def images(kind: str, objects: Sequence[Planned]) -> list[Array]:
        twins_of = [
            Twin(unmet=unmet, domain=domain).pair()
            for unmet in objects
            for domain in SIMULATED.values()
        ]
        return [
            np.asarray(Image.open(image_path(folder, pair, kind)).convert("RGB"))
            for pair in twins_of
        ]

    def rows(pictures: Sequence[Array]) -> Array:
        return embedded(encoder, pictures).reshape(-1, len(SIMULATED), encoder.width)

    def whole(unmet: Planned) -> bool:
        pairs = (Twin(unmet=unmet, domain=domain).pair() for domain in SIMULATED.values())
        return all(image_path(folder, pair, "vis").is_file() for pair in pairs)

    touches = images("tac", plan)
    clean = [fill_dots(picture)[0] for picture in touches]
    photographed = plan[
        : [*map(whole, plan), False].index(False) // len(header.classes) * len(header.classes)
    ]
    printed = np.flatnonzero((learning[0].tac != learning[1].tac).any(-1))
    return Twins(
        vis=rows(images("vis", photographed)),
        tac=rows(touches),
        filled=rows(clean),
        label=np.array([header.classes.index(unmet.material) for unmet in plan]),
        objects=tuple(unmet.object for unmet in plan),
        looks_like=tuple(unmet.looks_like for unmet in plan),
        feels_like=tuple(unmet.feels_like for unmet in plan),
        header=replace(header, origin="twins simulated by omnivat, seed 0, mitsuba renderer"),
        as_filled=learning[1].header.preprocessing,
        printed=learning[0].tac[printed],
        rows=printed,
    )


def fitted(method: str, pairs: Embeddings, source: str, seed: int = 0) -> Reads:
    """Train a method on the training pairs of one domain: "omnivat" by the page's recipe, or a
    baseline.
    """
    own = pairs.in_domain(source, split="train")
    names = tuple(name for k, name in enumerate(pairs.header.classes) if k in own.label)
    known = np.array([pairs.header.classes.index(name) for name in names])
    if method == "omnivat":
        training = TrainSettings(**RECIPE)  # type: ignore[arg-type]
        plan = plan_training(pairs, source, head={"width": 64}, training=training, seed=seed)
        given: dict[str, Any] = {"bank": plan.bank, "seed": seed, "resume": None, "watch": Watch()}
        model = train_once(plan.pairs, plan.settings, plan.training, **given).model.eval()

        def predict(*rows: torch.Tensor) -> Mapping[str, torch.Tensor]:
            found: Mapping[str, torch.Tensor] = model(*rows).readings
            return found

    else:
        arrays: dict[str, Any] = {
            name: torch.from_numpy(np.asarray(rows, np.float32))
            for name, rows in own.vectors.items()
        }
        labels = torch.from_numpy(np.searchsorted(known, own.label))
        objects = tuple(own.rows["object"])
        source_pairs = Source(**arrays, labels=labels, objects=objects, classes=names, seed=seed)
        predict = load(BASELINES, method, kind="method")(source_pairs).predict

    @torch.inference_mode()
    def read(*images: Array) -> dict[str, Array]:
        found = predict(
            *(torch.from_numpy(np.ascontiguousarray(rows, np.float32)) for rows in images)
        )
        return {name: known[found[name].argmax(-1).numpy()] for name in READINGS.values()}

    return read


def answers(
    read: Reads, made: Twins, pairs: Embeddings, source: str, *, filled: bool
) -> dict[str, str]:
    """Return the predicted classes of one head as digits.

    "touch S", "photo S"  of the twins by the sensor, and in the scene, of domain S
    "both S|T"            of the twins by the sensor of S in the scene of T
    "touch test S", ...   of the test pairs of S
    """
    touch, domains, home = (
        made.filled if filled else made.tac,
        made.header.domains,
        made.place(source),
    )
    found = {}
    for there, name in enumerate(domains):
        # One image alone is read whatever the other is.
        found[f"touch {name}"] = read(touch[:, there], touch[:, there])["tac"]
        found[f"photo {name}"] = read(made.vis[:, there], made.vis[:, there])["vis"]
        for sensor, scene in ((there, home), (home, there), (there, there)):
            both = read(made.vis[:, scene], touch[: len(made.vis), sensor])["fused"]
            found[f"both {domains[sensor]}|{domains[scene]}"] = both
        test = pairs.in_domain(name, split="test")
        found |= {
            f"{reading} test {name}": rows
            for reading, rows in _named(read(test.vis, test.tac)).items()
        }
    return {name: "".join(map(str, rows)) for name, rows in found.items()}


def _named(shares: Mapping[str, Array]) -> dict[str, Array]:
    return {reading: shares[name] for reading, name in READINGS.items()}


def draws(label: Array, random: np.random.Generator) -> Array:
    """Return weights (1 + DRAWS, n) of objects: ones, then draws with replacement within each
    class.
    """
    weights = np.ones((1 + DRAWS, len(label)))
    for one in np.unique(label):
        own = np.flatnonzero(label == one)
        weights[1:, own] = random.multinomial(len(own), np.full(len(own), 1 / len(own)), DRAWS)
    return weights


@dataclass(frozen=True, slots=True)
class Split:
    """Twins and test pairs, and weights of their objects: ones, then draws."""

    made: Twins
    tests: Mapping[str, Array]  # domain -> labels of its test pairs
    of_tests: Mapping[str, Array]
    of_touches: Array
    of_pairs: Array  # of the photographed twins

    def twin(
        self, said: Mapping[str, str], reading: str, sensor: str, scene: str, shared: Array
    ) -> Array:
        """Return the accuracy (1 + DRAWS,) in percent on twins by a sensor in a scene, of some
        classes.
        """
        names = {
            "touch": f"touch {sensor}",
            "photo": f"photo {scene}",
            "both": f"both {sensor}|{scene}",
        }
        weights = self.of_touches if reading == "touch" else self.of_pairs
        return accuracy(said[names[reading]], self.made.label[: weights.shape[1]], weights, shared)

    def test(self, said: Mapping[str, str], reading: str, domain: str, shared: Array) -> Array:
        """Return the accuracy on the test pairs of a domain."""
        return accuracy(
            said[f"{reading} test {domain}"], self.tests[domain], self.of_tests[domain], shared
        )

    def terms(
        self, said: Mapping[str, str], reading: str, source: str, target: str
    ) -> dict[str, Array]:
        """Return the terms of `split` between two domains; only classes of both count."""
        shared = np.intersect1d(self.tests[source], self.tests[target])
        home, away = (self.test(said, reading, name, shared) for name in (source, target))
        start, by_sensor, by_scene, by_both = (
            self.twin(said, reading, sensor, scene, shared)
            for sensor, scene in (
                (source, source),
                (target, source),
                (source, target),
                (target, target),
            )
        )
        return {
            "home": home,
            "new_objects": home - start,
            "sensor": start - by_sensor,
            "scene": start - by_scene,
            "interplay": by_sensor + by_scene - start - by_both,
            "objects": home - start + by_both - away,
            "away": away,
        }


def accuracy(said: str, label: Array, weights: Array, shared: Array) -> Array:
    """Return the percentage right (B,) of predictions (n digits) of some classes; weights (B,
    n).
    """
    keep = np.isin(label, shared)
    return 100 * share_of(np.array(list(said), int) == label, keep, weights)


def split(
    answers: Mapping[str, Mapping[str, str]], made: Twins, pairs: Embeddings
) -> dict[str, Any]:
    """Return the loss between two domains in parts, in points, by reading: means over sources and
    targets.

    answers  source -> `answers`
    return   reading -> term -> [mean, low, high], and "by_source" -> source -> term -> mean

    With T(s, c) the accuracy on twins by sensor s in scene c, from the source's own s and c to the
    target's s' and c':

    home         on test pairs of the source
    new_objects  home - T(s, c)
    sensor       T(s, c) - T(s', c)
    scene        T(s, c) - T(s, c')
    interplay    T(s, c) - T(s', c') - sensor - scene
    objects      new_objects + T(s', c') - away
    away         on test pairs of the target

    95 % intervals: bootstrap over sources, then objects within classes.
    """
    random = np.random.default_rng(0)
    tests = {name: pairs.in_domain(name, split="test").label for name in made.header.domains}
    ready = Split(
        made=made,
        tests=tests,
        of_tests={name: draws(label, random) for name, label in tests.items()},
        of_touches=draws(made.label, random),
        of_pairs=draws(made.label[: len(made.vis)], random),
    )
    results: dict[str, Any] = {}
    for reading in READINGS:
        by_source: dict[str, dict[str, Array]] = {}
        for source, said in answers.items():
            every = [
                ready.terms(said, reading, source, target) for target in tests if target != source
            ]
            by_source[source] = {
                term: np.mean([one[term] for one in every], axis=0) for term in every[0]
            }
        terms = next(iter(by_source.values()))
        results[reading] = {
            term: over([own[term] for own in by_source.values()], random) for term in terms
        }
        results[reading]["by_source"] = {
            source: {term: round(float(values[0]), 1) for term, values in own.items()}
            for source, own in by_source.items()
        }
    return results


def changed(base: str, donor: str, group: str) -> Sensor:
    """Return a gel with one group of its parts from another."""
    return replace(GELS[base], **{name: getattr(GELS[donor], name) for name in GROUPS[group]})


def part_rows(folder: Path, base: str, each: int) -> dict[str, Array]:
    """Return unit embeddings "DONOR|GROUP|DOTS" (n, W) of presses by a gel with one group changed;
    "|" is the gel itself.

    They wait in `folder`.
    """
    file = folder / f"parts-{base}-{each}.npz"
    if not file.is_file():
        encoder = load_encoder("efficientnet-lite0")
        found: dict[str, Array] = {}
        plan = [
            (donor, group)
            for donor in GELS
            for group in GROUPS
            if changed(base, donor, group) != GELS[base]
        ]
        things = [pressed(unmet, seed=0) for unmet in unmet_objects(each)]
        heights: dict[tuple[int, float], Array] = {}
        for donor, group in [("", ""), *plan]:
            sensor = changed(base, donor, group) if donor else GELS[base]
            images = []
            for n, (made, stream) in enumerate(things):
                press = pressing(np.random.default_rng(derive_seed(stream, "press")))
                if (n, sensor.field) not in heights:
                    heights[n, sensor.field] = pressed_height(
                        made, press, field=sensor.field, size=224
                    )
                image = imaged(
                    heights[n, sensor.field], press, sensor, seed=derive_seed(stream, "sensor")
                )
                images.append(np.round(image * 255).astype(np.uint8))
            kept = embedded(encoder, images)
            clean, dots = zip(*map(fill_dots, images), strict=True)
            there = np.array([one is not None for one in dots])
            filled = kept.copy()
            if there.any():
                filled[there] = embedded(
                    encoder, [image for image, dot in zip(clean, there, strict=True) if dot]
                )
            for name, rows in (("kept", kept), ("filled", filled)):
                found[f"{donor}|{group}|{name}"] = rows / np.linalg.norm(
                    rows, axis=1, keepdims=True
                )
        folder.mkdir(parents=True, exist_ok=True)
        np.savez(file, **found)  # type: ignore[arg-type]
    with np.load(file) as arrays:
        return dict(arrays)


def embedded(encoder: Any, images: Sequence[Array]) -> Array:
    """Return embeddings (n, W) of images (H, W, 3), 25 at a time."""
    parts = [
        encoder.embed(
            torch.stack(
                [encoder.preprocess(Image.fromarray(image)) for image in images[k : k + 25]]
            )
        )
        for k in range(0, len(images), 25)
    ]
    rows: Array = torch.cat(parts).numpy()
    return rows


def parts(learning: Sequence[Embeddings], each: int) -> dict[str, Any]:
    """Return what a change of one group of parts costs a plain head that learned from a gel, by
    touch.

    return  "every" (from each gel, the part of each other), "from" (the head learned from GelSight)
            and "to" (the part is GelSight's) -> group ("whole": all) -> way -> [mean, low, high] of
            home minus changed in points, over the other gels with such a part; "pairs" ->
            "FROM|TO" -> group -> way -> [share right with only this changed, with all but this
            changed]. Ways: `WAYS`; a profile knows mean and spread of all presses, without labels.
            95 % intervals: bootstrap over the gels that vary (in "every", those learned from), then
            objects within classes
    """
    label = np.array(
        [learning[0].header.classes.index(unmet.material) for unmet in unmet_objects(each)]
    )
    random = np.random.default_rng(0)
    weights, rows = draws(label, random), {name: part_rows(BUILD, name, each) for name in GELS}
    domain = {
        name: f"{key}-sim"
        for name in GELS
        for key, one in SIMULATED.items()
        if one.sensor is GELS[name]
    }
    losses: dict[str, dict[str, dict[str, list[Array]]]] = {"every": {}, "from": {}, "to": {}}
    cells: dict[str, dict[str, dict[str, list[float]]]] = {}
    for start in GELS:
        for dots, pairs in zip(DOTS, learning, strict=True):
            own = pairs.in_domain(domain[start], split="train")
            reads = partial(
                part_share,
                learned(rows_of(own.vectors, "touch"), own.label),
                label=label,
                weights=weights,
            )
            home = reads(rows[start][f"||{dots}"], profiled=False)
            from_here: dict[str, dict[str, list[Array]]] = {}
            for other in (name for name in GELS if name != start):
                unlike = [group for group in GROUPS if f"{other}|{group}|kept" in rows[start]]
                for group, profiled in product(("whole", *unlike), (False, True)):
                    changed_rows = (
                        rows[other]["||" + dots]
                        if group == "whole"
                        else rows[start][f"{other}|{group}|{dots}"]
                    )
                    only = reads(changed_rows, profiled=profiled)
                    rest = (
                        home
                        if group == "whole"
                        else reads(rows[other][f"{start}|{group}|{dots}"], profiled=profiled)
                    )
                    way = WAYS[dots, profiled]
                    cells_of = [from_here]
                    if HUB in (start, other):
                        cells_of.append(losses["from" if start == HUB else "to"])
                    for some in cells_of:
                        some.setdefault(group, {}).setdefault(way, []).append(100 * (home - only))
                    cell = cells.setdefault(f"{start}|{other}", {}).setdefault(group, {})
                    cell[way] = [round(float(share[0]), 3) for share in (only, rest)]
            for group, ways in from_here.items():
                for way, lost in ways.items():
                    every = losses["every"].setdefault(group, {}).setdefault(way, [])
                    every.append(np.mean(lost, axis=0))
    return {
        "presses": len(label),
        "pairs": cells,
        **{
            direction: {
                group: {way: over(gels, random) for way, gels in ways.items()}
                for group, ways in groups.items()
            }
            for direction, groups in losses.items()
        },
    }


def part_share(head: Plain, seen: Array, *, label: Array, weights: Array, profiled: bool) -> Array:
    """Return the share right (1 + DRAWS,) of unit rows (n, W); `profiled`: their own mean and
    spread are known.
    """
    answer = head.model.classes_[
        head.probabilities(seen, channels_of(seen) if profiled else None).argmax(1)
    ]
    return share_of(answer == label, np.isin(label, head.model.classes_), weights)


def share_of(right: Array, keep: Array, weights: Array) -> Array:
    """Return the weighted share (B,) of right predictions (n,) among those to keep (n,); weights
    (B, n).
    """
    share: Array = weights[:, keep] @ right[keep] / weights[:, keep].sum(1)
    return share


def over(values: Sequence[Array], random: np.random.Generator) -> list[float]:
    """Return the mean over things with values (1 + DRAWS,) each, and its 95 % interval: things
    are drawn, too.
    """
    every, drawn = np.stack(values), random.integers(len(values), size=(DRAWS, len(values)))
    found = every[drawn, 1 + np.arange(DRAWS)[:, None]].mean(1)
    return [round(float(v), 1) for v in (every[:, 0].mean(), *np.quantile(found, [0.025, 0.975]))]


WAYS = {
    ("kept", False): "as it comes",
    ("kept", True): "profile",
    ("filled", False): "dots filled",
    ("filled", True): "dots filled, profile",
}


def moves(made: Twins, learning: Sequence[Embeddings]) -> dict[str, Any]:
    """Return, by the sensor learned from, what moving the mean, and mean and spread, of all presses
    brings another sensor: touch.

    return  source -> {"unit": [as it comes, mean, mean and spread], "standardised": the same,
            "offset": the share of the squared move of a press that is one vector for all presses}
            for the dots as printed; means over the other sensors. "mean": of all
    """
    touch, found = rows_of({"tac": made.tac}, "touch"), {}
    for home, name in enumerate(made.header.domains):
        own = learning[0].in_domain(name, split="train")
        rows, others = (
            rows_of(own.vectors, "touch"),
            [k for k in range(touch.shape[1]) if k != home],
        )
        heads = {
            "unit": logistic(rows, own.label),
            "standardised": logistic(rows, own.label, standardised=True),
        }
        keep = np.isin(made.label, own.label)
        mean, deviation = rows.mean(0), rows.std(0) + 1e-6
        cells: dict[str, list[list[float]]] = {way: [] for way in heads}
        offset = []
        for other in others:
            x = touch[:, other]
            there, wide = x.mean(0), x.std(0) + 1e-6
            ways = (x, x - there + mean, (x - there) / wide * deviation + mean)
            for way, read in heads.items():
                cells[way].append([float((read(some) == made.label)[keep].mean()) for some in ways])
            move = x - touch[:, home]
            offset.append(float((move.mean(0) ** 2).sum() / (move**2).sum(1).mean()))
        found[name] = {way: np.mean(rows, axis=0).round(3).tolist() for way, rows in cells.items()}
        found[name]["offset"] = [
            round(float(v), 2) for v in (np.mean(offset), min(offset), max(offset))
        ]
    found["mean"] = {
        way: np.mean([one[way] for one in found.values()], axis=0).round(3).tolist()
        for way in (*heads, "offset")
    }
    return found


def logistic(rows: Array, labels: Array, *, standardised: bool = False) -> Callable[[Array], Array]:
    """Return a function from unit rows to classes: a regression on unit rows as they are, or
    standardised.
    """
    if not standardised:
        predict: Callable[[Array], Array] = (
            LogisticRegression(C=10, max_iter=3000).fit(rows, labels).predict
        )
        return predict
    head = learned(rows, labels)
    return lambda some: head.model.classes_[head.probabilities(some).argmax(1)]


def figure(record: Mapping[str, Any]) -> str:
    """Return the SVG of what each group of a gel's parts costs a head that learned from
    GelSight.
    """
    found = record["parts"]["from"]
    rows = [
        {
            "row": NAMES.get(group, group),
            "series": way,
            "value": cell[0],
            "low": cell[1],
            "high": cell[2],
        }
        for group in ("whole", *GROUPS)
        for way, cell in found[group].items()
    ]
    words = (
        f"Simulated: {record['parts']['presses']} presses, means over four other gels, 95 %"
        " intervals. "
    )
    drawn = dot_figure(
        rows,
        title="What one group of a gel's parts costs a head that learned from GelSight",
        across="points lost, touch alone, logistic regression",
        caption=words + "A profile knows mean and spread of all presses, without labels.",
    )
    return svg_of(drawn)


NAMES = {"whole": "the whole sensor"}


def main() -> None:
    """Do one step, or write the record."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--pack", type=Path, metavar="FOLDER")
    parser.add_argument("--page", type=Path, metavar="FOLDER")
    parser.add_argument("--split", default="", metavar="METHOD,...")
    parser.add_argument("--parts", type=int, metavar="N")
    parser.add_argument("--learn", nargs=2, type=Path, metavar=("KEPT", "FILLED"), required=True)
    options = parser.parse_args()
    learning = [load_embeddings(file) for file in options.learn]
    if options.pack:
        write_twins(EXAMPLES / "twins.npz", gathered(options.pack, learning))
    made = twins()
    with one_thread():
        if options.page:
            _write_page(made, learning, options.page)
        for method in filter(None, options.split.split(",")):
            _measure(method, made, learning)
        if options.parts:
            write_json(BUILD / "parts.json", parts(learning, options.parts))
        if not (options.pack or options.page or options.split or options.parts):
            _write_record(made, learning)


def _write_page(made: Twins, learning: Sequence[Embeddings], folder: Path) -> None:
    domains = [about(name, SIMULATED[paper_name(name)]) for name in made.header.domains]
    content, objects = page(made, learning, domains)
    write_json(EXAMPLES / "twins.json", content)
    write_json(EXAMPLES / "twins.map.json", threads(made, learning[0]))
    sheets(made, objects, folder, lambda picture: fill_dots(picture)[0], EXAMPLES / "twins")


def _measure(method: str, made: Twins, learning: Sequence[Embeddings]) -> None:
    for dots, pairs in zip(DOTS, learning, strict=True):
        for source in made.header.domains:
            if not (file := _file(method, source, dots)).is_file():
                write_json(
                    file,
                    answers(
                        fitted(method, pairs, source), made, pairs, source, filled=dots == "filled"
                    ),
                )
                print(file, flush=True)


def _write_record(made: Twins, learning: Sequence[Embeddings]) -> None:
    found = {}
    for method in METHODS:
        measured = [
            name
            for name in made.header.domains
            if all(_file(method, name, dots).is_file() for dots in DOTS)
        ]
        found[method] = {"sources": measured} | {
            dots: split(
                {name: json.loads(_file(method, name, dots).read_bytes()) for name in measured},
                made,
                pairs,
            )
            for dots, pairs in zip(DOTS, learning, strict=True)
        }
    near = {
        dots: moved(rows_of({"tac": rows}, "touch"))
        for dots, rows in zip(DOTS, (made.tac, made.filled), strict=True)
    }
    record = {
        "command": "python -m benchmarks.twins",
        "touches": len(made.label),
        "photographed": len(made.vis),
        "split": found,
        "moves": moves(made, learning),
        "own_twin": {
            dots: [round(mean_own_twin(rows), 3) for rows in ways] for dots, ways in near.items()
        },
        "parts": json.loads((BUILD / "parts.json").read_bytes()),
    }
    write_json(OUT / "twins.json", record)
    page_file = EXAMPLES / "twins.json"
    write_json(page_file, json.loads(page_file.read_bytes()) | {"split": for_the_page(found)})
    write_text(OUT / "twins.svg", figure(record))


def for_the_page(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return the loss of linear maps: reading -> [dots kept, filled] -> term -> [mean, low,
    high].
    """
    maps = record["linear_maps"]
    terms = ("home", "sensor", "scene", "interplay", "objects", "away")
    return {
        "head": "three linear maps",
        "sources": len(maps["sources"]),
        "loss": {
            reading: [{term: maps[dots][reading][term] for term in terms} for dots in DOTS]
            for reading in READINGS
        },
    }


def _file(method: str, source: str, dots: str) -> Path:
    return BUILD / f"{method}-{source}-{dots}.json"


def mean_own_twin(rows: Array) -> float:
    """Return the share of presses (N, S, W) whose nearest press by another sensor is their own
    twin, over pairs of sensors.
    """
    near = own_twin(rows)
    return float(near[~np.eye(len(near), dtype=bool)].mean())


if __name__ == "__main__":
    main()
