"""The loss of linear maps on another domain in parts, touch by relief (docs/twins.md).

    python -m benchmarks.twins_split FOLDER

FOLDER is what `python -m simulator twins` drew. It adds "relief" to the split of linear maps in
docs/benchmarks/twins.json, beside "kept" and "filled". With T(s, c) the accuracy on twins by sensor
s in scene c, from the source's own s and c to the target's s' and c':

    home         on test pairs of the source
    new_objects  home - T(s, c)
    sensor       T(s, c) - T(s', c)
    scene        T(s, c) - T(s, c')
    interplay    T(s, c) - T(s', c') - sensor - scene
    objects      new_objects + T(s', c') - away
    away         on test pairs of the target

A source is read by its own lamps: its test pairs by those of 50 of its training pairs, its twins by
those of 20 other twins. Nothing is known of a target. 95 % intervals: bootstrap over sources, then
objects within classes.
"""

import json
import sys
from collections.abc import Callable, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks.relief import Reliefs
from benchmarks.twins import RECORD, Array, reliefs, thirds
from omnivat.data.embeddings import Embeddings
from omnivat.data.store import load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.kit.files import write_text
from omnivat.kit.tables import load
from omnivat.kit.threads import pin_thread
from omnivat.measure.twins import Twins, twins
from omnivat.study.baselines import BASELINES
from omnivat.study.baselines.contract import Source

DRAWS = 1000
READINGS = {"touch": "tac", "photo": "vis", "both": "fused"}
Read = Callable[[Array, Array], dict[str, Array]]


def fitted(pairs: Embeddings, source: str) -> Read:
    """Return linear maps of a source: photos and touches (n, W) -> reading -> classes (n,)."""
    own = pairs.in_domain(source, split="train")
    known = np.unique(own.label)
    rows: dict[str, Any] = {
        n: torch.from_numpy(np.array(v, np.float32)) for n, v in own.vectors.items()
    }
    names = tuple(pairs.header.classes[k] for k in known)
    labels = torch.from_numpy(np.searchsorted(known, own.label))
    learning = Source(
        **rows, labels=labels, objects=tuple(own.rows["object"]), classes=names, seed=0
    )
    predict = load(BASELINES, "linear_maps", kind="method")(learning).predict

    @torch.inference_mode()
    def read(vis: Array, tac: Array) -> dict[str, Array]:
        found = predict(*(torch.from_numpy(np.array(x, np.float32)) for x in (vis, tac)))
        return {what: known[found[name].argmax(-1).numpy()] for what, name in READINGS.items()}

    return read


def weights(label: Array, random: np.random.Generator) -> Array:
    """Return weights (1 + DRAWS, n) of objects: ones, then draws within each class."""
    found = np.ones((1 + DRAWS, len(label)))
    for one in np.unique(label):
        own = np.flatnonzero(label == one)
        found[1:, own] = random.multinomial(len(own), np.full(len(own), 1 / len(own)), DRAWS)
    return found


class Split:
    """The twins and the test pairs of a set, touches by one look."""

    def __init__(
        self, made: Twins, own: Embeddings, new: Embeddings, touches: tuple[Array, Array]
    ) -> None:
        """own, new: the set as sources and as targets are read; touches: so the twins (N, S, W)."""
        self.made, self.own, self.new, self.touches = made, own, new, touches
        self.random = np.random.default_rng(0)
        self.label = {d: own.in_domain(d, split="test").label for d in made.header.domains}
        self.tests = {d: weights(label, self.random) for d, label in self.label.items()}
        self.twins = (
            weights(made.label, self.random),
            weights(made.label[: len(made.vis)], self.random),
        )

    def terms(self, read: Read, what: str, source: str, target: str) -> dict[str, Array]:
        """Return each term (1 + DRAWS,) between two domains, in points; only classes of both."""
        shared = np.intersect1d(self.label[source], self.label[target])

        def share(said: Array, label: Array, weight: Array) -> Array:
            keep = np.isin(label, shared)
            found: Array = 100 * weight[:, keep] @ (said == label)[keep] / weight[:, keep].sum(1)
            return found

        def test(pairs: Embeddings, domain: str) -> Array:
            some = pairs.in_domain(domain, split="test")
            return share(read(some.vis, some.tac)[what], self.label[domain], self.tests[domain])

        def twin(sensor: str, scene: str) -> Array:
            tac = self.touches[sensor != source][:, self.made.place(sensor)]
            vis = self.made.vis[:, self.made.place(scene)]
            if what == "touch":
                return share(read(tac, tac)[what], self.made.label, self.twins[0])
            said = read(vis, tac[: len(vis)])[what]
            return share(said, self.made.label[: len(vis)], self.twins[1])

        home, away = test(self.own, source), test(self.new, target)
        start, sensor, scene, both = (
            twin(*place)
            for place in ((source, source), (target, source), (source, target), (target, target))
        )
        return {
            "home": home,
            "new_objects": home - start,
            "sensor": start - sensor,
            "scene": start - scene,
            "interplay": sensor + scene - start - both,
            "objects": home - start + both - away,
            "away": away,
        }

    def over(self, values: Sequence[Array]) -> list[float]:
        """Return the mean of sources and its 95 % interval."""
        every = np.stack(values)
        drawn = self.random.integers(len(every), size=(DRAWS, len(every)))
        found = every[drawn, 1 + np.arange(DRAWS)[:, None]].mean(1)
        return [
            round(float(v), 1) for v in (every[:, 0].mean(), *np.quantile(found, [0.025, 0.975]))
        ]

    def record(self, reads: Mapping[str, Read], readings: Sequence[str]) -> dict[str, Any]:
        """Return reading -> term -> [mean, low, high], and "by_source" -> source -> term."""
        results: dict[str, Any] = {}
        for what in readings:
            by_source = {}
            for source, read in reads.items():
                every = [self.terms(read, what, source, t) for t in reads if t != source]
                by_source[source] = {
                    term: np.mean([one[term] for one in every], axis=0) for term in every[0]
                }
            terms = next(iter(by_source.values()))
            results[what] = {
                term: self.over([own[term] for own in by_source.values()]) for term in terms
            }
            results[what]["by_source"] = {
                source: {term: round(float(values[0]), 1) for term, values in own.items()}
                for source, own in by_source.items()
            }
        return results


def main() -> None:
    """Measure the split by relief and write the record."""
    pin_thread()
    made, pairs = twins(), Reliefs(load_embeddings(default_embeddings()))
    lit = np.empty_like(made.relief)
    for sensor, one in enumerate(reliefs(Path(sys.argv[1]), len(made.vis))["touch"]):
        for k, part in enumerate(thirds(len(made.label), len(made.header.classes))):
            lit[part, sensor] = one[-1, k, part]
    split = Split(made, pairs.source, pairs.alone, (lit, made.relief))
    reads = {domain: fitted(split.own, domain) for domain in made.header.domains}
    record = json.loads(RECORD.read_bytes())
    record["split"]["linear_maps"]["relief"] = split.record(reads, ("touch", "both"))
    write_text(RECORD, json.dumps(record, separators=(",", ":")) + "\n")


if __name__ == "__main__":
    main()
