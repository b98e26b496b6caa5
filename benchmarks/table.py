"""One table of results: methods by what is known of a sensor that they have not met.

    python -m benchmarks.table [--methods NAME,...] [--seeds 0,1,2,3,4] [--out build/table.jsonl]

Protocol. Sources: each of the eight simulated domains, its training pairs. Targets: the test pairs
of the seven others, OF 2.0 A and B too, although one simulator draws their touches. Pairs of a
class that the source lacks are left out: TacQuad's four domains have no ceramic. Every method takes
rows standardised by its source's profile. Heads that are trained in batches share one recipe
(`RECIPE`). Known of the target: nothing; 5 or 20 training pairs without labels, by a profile; 5
labelled training pairs of each class, by a profile of them and a ridge regression of the classes on
the method's features of the source's pairs and these. A seed draws weights, batches, noise and the
known pairs.

One line is written for each method, source and seed: the class predicted for every test pair, as a
letter, on every rung, seconds of training and the number of parameters. `NAME@10` is a method that
learned ten pairs of each class. When all seeds are there, one line more has the mean of their
probabilities, as it comes: each seed knows other pairs of the target. Finished lines are kept, so a
stopped run goes on.

With `--relief`, a method learns and reads touches by relief (`benchmarks.relief` embedded them):
with nothing known by each touch's own lamps, a20 by these and a profile of 20 pairs, l5 and l20 by
the lamps of 5 or 20 known pairs and nothing else, n5, n20 and k5 by these lamps beside the rest.
`NAME+colours` is two heads of one method and seed, which learned relief and colours, and the mean
of their log-probabilities; the second knows as much of the target by its profile. `three_maps` is
linear maps of photo, colours, relief and all three. `wide_maps` is linear maps of photo, touch and
both, for which a touch is one vector of its colours beside its relief.
"""

import argparse
import gzip
import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import normalize

from benchmarks._table_methods import (
    METHODS,
    PUBLISHED,
    Array,
    Learned,
    Raw,
    published,
    raw_of,
    ridge,
    three_maps,
    wide_maps,
)
from benchmarks._table_record import BOTH, THREE, WIDE
from benchmarks.relief import FOLDER, KNOWN, Reliefs, Wide, order
from omnivat.cli.arguments import listed, numbers
from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import profile_of
from omnivat.data.store import load_embeddings
from omnivat.head.fusion import fused_logs
from omnivat.head.heads import LADDERS, RELIEF, default_embeddings
from omnivat.head.linear_maps import FittedMaps
from omnivat.head.predict_set import predicted
from omnivat.head.teach import Lesson
from omnivat.kit.lines import lines
from omnivat.kit.stages import IMAGES
from omnivat.kit.threads import pin_thread
from omnivat.measure.known import parts
from omnivat.measure.ladder import FORMAT, lettered
from omnivat.measure.readers import Reader
from omnivat.measure.rungs import ALL, NOTHING, Known, labels, pairs, sensors
from omnivat.study.baselines.descent import size
from omnivat.study.protocol.records import append, fingerprint, mend

PICTURES = (1, 5, 20, 50)  # pairs of the target without labels
LABELLED = (1, 3, 5)  # labelled pairs of each class
SOURCES = (2, 4, 7)  # source domains, for the method that needs no training
UNKNOWN = ("home", "none", *IMAGES)  # rungs that know no pair of the target; others draw some
WEIGHT = 20  # pairs, as which the labelled ones of a class count in the ridge regression


class Measured:
    """One method, one source, one seed."""

    def __init__(
        self,
        embeddings: Embeddings,
        name: str,
        source: str,
        seed: int,
        methods: dict[str, Callable[[Embeddings, str, int], Learned]] = METHODS,
        relief: Reliefs | None = None,
    ) -> None:
        self.relief = relief
        name, _, count = name.partition("@")
        if count:
            embeddings = few(embeddings, source, int(count), seed)
        self.set, self.name, self.seed = embeddings, name, seed
        started = time.perf_counter()
        if name in PUBLISHED:
            self.method: Learned = published(name, embeddings, source, seed)
        else:
            self.method = methods[name](embeddings, source, seed)
        self.seconds = time.perf_counter() - started
        self.reader = reader_of(self.method, embeddings, source)

    def steps(self) -> Iterator[tuple[str, Reader, Known]]:
        """Yield each rung, with what reads it and what is known of the target."""
        if self.relief:
            yield from self.by_relief(self.relief)
            return
        for name in IMAGES if self.method.alone else ():
            alone = partial(predicted, self.method.readings, modalities=(name,))
            yield name, replace(self.reader, predict=alone), NOTHING
        steps = [NOTHING, *map(pairs, PICTURES), pairs(ALL, every=True), *map(labels, LABELLED)]
        if self.name == "nearest_mean" and self.seed == 0:
            steps += [sensors(m, profiles=moved) for m in SOURCES for moved in (False, True)]
        for known in steps:
            yield known.name, self.reader, replace(known, draw=self.drawn)

    def by_relief(self, relief: Reliefs) -> Iterator[tuple[str, Reader, Known]]:
        """Yield the rungs of a reading by relief; at home, the source has its own lamps."""
        touch = replace(
            self.reader, predict=partial(predicted, self.method.readings, modalities=("tac",))
        )
        yield "home", self.reader, NOTHING
        alone = replace(NOTHING, rested=relief.alone)
        yield "none", self.reader, alone
        yield "a20", self.reader, replace(pairs(20), draw=self.drawn, rested=relief.alone)
        if self.method.alone:
            yield "tac", touch, alone
        for known in KNOWN:
            read = relief.target(known, self.seed)
            yield known.name, self.reader, replace(known, draw=self.drawn, rested=read)
            if known.pairs:
                lit = replace(NOTHING, rested=read)
                yield f"l{known.pairs}", self.reader, lit
                if self.method.alone:
                    yield f"l{known.pairs}, touch", touch, lit

    def drawn(self, stream: str, seed: int, domain: str, pool: Array) -> Array:
        """Return a pool in the order of the records."""
        return order(self.set, stream, seed, domain, pool)

    def shares(self) -> dict[str, Array]:
        """Return rung -> class probabilities of all test pairs (N, K); NaN where none was made."""
        found: dict[str, Array] = {}
        tested = np.flatnonzero(np.array(self.set.rows["split"]) == "test")
        own = "home" if self.relief else "none"
        for rung, reader, known in self.steps():
            for part in parts(reader, self.set, known, seed=self.seed):
                home = part.domain == reader.source
                if (rung == "home" and not home) or (home and rung != own):
                    continue
                values = part.reader.predict(part.embeddings, rows=part.rows)["fused"]
                empty = np.full((len(tested), len(reader.classes)), np.nan, np.float32)
                place = np.searchsorted(tested, part.rows)
                found.setdefault("home" if home else rung, empty)[place] = values.numpy()
        return found


def reader_of(method: Learned, embeddings: Embeddings, source: str) -> Reader:
    """Return a method as it is measured; labels teach a ridge regression on its features, and
    several sources are learned as class means of them.
    """
    train, classes = embeddings.rows_of(source, split="train"), embeddings.header.classes
    profile = replace(profile_of(embeddings, train, domain=source), step=method.step)
    own = method.features(raw_of(embeddings, train))

    def taught(lessons: Sequence[Lesson]) -> Reader:
        raw = {n: torch.cat([getattr(lesson, n) for lesson in lessons]) for n in IMAGES}
        some = np.array([classes.index(lesson.label) for lesson in lessons])
        features = torch.cat((own, method.features(raw)))
        labels = torch.from_numpy(np.concatenate((embeddings.label[train], some)))
        weights = torch.ones(len(features))
        weights[len(train) :] = WEIGHT / np.bincount(some).max()

        def readings(raw: Raw) -> dict[str, Tensor]:
            return {"fused": ridge(features, labels, len(classes), weights, method.features(raw))}

        return replace(reader, predict=partial(predicted, readings))

    def learned(near: Embeddings, domains: Sequence[str]) -> Reader:
        rows = np.concatenate([near.rows_of(name, split="train") for name in domains])
        features = method.features(raw_of(near, rows))
        sums = features.new_zeros(len(classes), features.shape[1])
        sums.index_add_(0, torch.from_numpy(near.label[rows]), features)
        means = normalize(sums, dim=-1)

        def readings(raw: Raw) -> dict[str, Tensor]:
            cosines = normalize(method.features(raw), dim=-1) @ means.T
            return {"fused": (10 * cosines).softmax(-1)}

        return replace(reader, predict=partial(predicted, readings))

    reader = Reader(
        classes=classes,
        source=source,
        predict=partial(predicted, method.readings),
        profile=lambda: profile,
        taught=taught,
        learned=learned,
    )
    return reader


def few(embeddings: Embeddings, source: str, count: int, seed: int) -> Embeddings:
    """Return the set with at most `count` training pairs of each class of the source."""
    pool = embeddings.rows_of(source, split="train")
    mixed = np.random.default_rng([seed, count]).permutation(pool)
    label = embeddings.label[mixed]
    kept = np.concatenate([mixed[label == c][:count] for c in np.unique(label)])
    return embeddings.select(np.setdiff1d(np.arange(len(embeddings)), np.setdiff1d(pool, kept)))


def letters_of(shares: Array) -> str:
    """Return the classes of the largest probabilities (N, K) as letters; a dot where none was
    made.
    """
    made = np.asarray(~np.isnan(shares).any(axis=1))
    answers = np.where(made, np.where(made[:, None], shares, 0).argmax(1), -1)
    return lettered(answers)


def facts(embeddings: Embeddings) -> dict[str, Any]:
    """Return the first line of the records: the test pairs, for tables without the set."""
    tested = np.array(embeddings.rows["split"]) == "test"
    looks = np.array([bool(name) for name in embeddings.rows["looks_like"]])[tested]
    return {
        "format": FORMAT,
        "data": fingerprint(embeddings),
        "domains": list(embeddings.header.domains),
        "classes": list(embeddings.header.classes),
        "domain": embeddings.domain[tested].tolist(),
        "truth": lettered(embeddings.label[tested]),
        "look_alike": "".join("01"[int(look)] for look in looks),
    }


def main() -> None:
    """Add the missing lines to the records, and pack them where wanted."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--methods", default=",".join((*METHODS, *PUBLISHED)), help="by name")
    parser.add_argument("--seeds", default="0,1,2,3,4", help="of training and drawing")
    parser.add_argument("--out", type=Path, default=Path("build/table.jsonl"), help="the records")
    parser.add_argument("--relief", action="store_true", help=f"touches by relief, of {FOLDER}")
    parser.add_argument("--pack", action="store_true", help="write them to examples/records, too")
    options = parser.parse_args()
    if not options.relief and any(method in options.methods for method in (BOTH, THREE, WIDE)):
        parser.error(f"'{THREE}', '{WIDE}' and names with '{BOTH}' read relief, too; add --relief")
    pin_thread()
    embeddings = load_embeddings(options.embeddings)
    relief = Reliefs(embeddings) if options.relief else None
    embeddings = relief.source if relief else embeddings
    mend(options.out)
    done = list(lines(options.out, FORMAT))
    if not done:
        append(options.out, facts(embeddings))
    have = {(line["method"], line["source"], line["seed"]) for line in done[1:]}
    for seed in numbers(options.seeds):
        for source in embeddings.header.domains:
            for name in listed(options.methods):  # two of them share one fit
                if (name, source, seed) not in have:
                    write_run(embeddings, name, source, seed, options.out, relief)
    if options.pack:
        if not relief:
            average(options.out, listed(options.methods), embeddings.header.domains)
        record = RELIEF if relief else LADDERS
        record.write_bytes(gzip.compress(options.out.read_bytes(), 9, mtime=0))


def write_run(
    embeddings: Embeddings,
    name: str,
    source: str,
    seed: int,
    out: Path,
    relief: Reliefs | None = None,
) -> None:
    """Measure one method on one source with one seed; keep its probabilities for their mean."""
    made = [(embeddings, relief)]
    if relief and (name.endswith(BOTH) or name == THREE):
        made.append((relief.colours, None))
    bare = "nearest_mean" if name == THREE else name.removesuffix(BOTH)  # it needs no training
    methods = METHODS
    if relief and name == WIDE:
        wide = Wide(relief)
        made, methods = [(wide.source, wide)], {WIDE: partial(wide_maps, relief.colours)}
    heads = [Measured(learned, bare, source, seed, methods, by) for learned, by in made]
    if relief and name == THREE:
        started = time.perf_counter()
        maps = three_maps(relief.colours, embeddings, source, seed)
        cost = time.perf_counter() - started, size(maps.maps)
        shares = beside(heads[0], heads[1], maps)
    else:
        cost = sum(run.seconds for run in heads), sum(run.method.parameters for run in heads)
        shares, *colours = (head.shares() for head in heads)
        for rung, drawn in shares.items() if colours else ():
            logs = (torch.from_numpy(rows).log() for rows in (drawn, colours[0][as_much(rung)]))
            shares[rung] = fused_logs("product", *logs).exp().numpy()
    place = kept(out, name, source, seed)
    place.parent.mkdir(parents=True, exist_ok=True)
    packed: dict[str, Any] = {rung: v.astype(np.float16) for rung, v in shares.items()}
    np.savez(place, **packed)
    line = {
        "format": FORMAT,
        "method": name,
        "source": source,
        "seed": seed,
        "heads": 1 if name == THREE else len(heads),
        "seconds": round(cost[0], 1),
        "parameters": cost[1],
        "answers": {rung: letters_of(values) for rung, values in shares.items()},
    }
    append(out, line)
    print(name, source, seed, f"{line['seconds']} s", flush=True)


def as_much(rung: str) -> str:
    """Return the rung at which colours know as much of the target as relief does at this one."""
    if rung.startswith("l"):
        return "tac" if "touch" in rung else "none"
    return {"a20": "n20"}.get(rung, rung)


def beside(lit: Measured, plain: Measured, maps: FittedMaps) -> dict[str, Array]:
    """Return the class probabilities of `three_maps` by rung; labels teach them nothing.

    lit, plain  one method by relief and in colours, whose profiles and known pairs are used
    """
    found: dict[str, Array] = {}
    tested = np.flatnonzero(np.array(plain.set.rows["split"]) == "test")
    for rung, reader, known in lit.steps():
        if known.labels:
            continue
        both = (
            parts(reader, lit.set, known, seed=lit.seed),
            parts(plain.reader, plain.set, replace(known, rested=None), seed=lit.seed),
        )
        found[rung] = np.full((len(tested), len(reader.classes)), np.nan, np.float32)
        for drawn, part in zip(*both, strict=True):
            if (part.domain == reader.source) == (rung == "home"):
                raw = raw_of(part.embeddings, part.rows)
                raw["relief"] = raw_of(drawn.embeddings, part.rows)["tac"]
                if "tac" in rung or "touch" in rung:
                    del raw["vis"]
                with torch.inference_mode():
                    values = maps(raw)["fused"].numpy()
                found[rung][np.searchsorted(tested, part.rows)] = values
    return found


def kept(out: Path, name: str, source: str, seed: int) -> Path:
    """Return the file of a run's probabilities."""
    return out.with_suffix("") / f"{name}-{source.replace(' ', '')}-{seed}.npz"


def average(out: Path, names: Sequence[str], sources: Sequence[str]) -> None:
    """Add a line for the mean of all heads of each method and source, where each source has
    several.
    """
    have = [line for line in lines(out, FORMAT) if "method" in line]
    there = {(line["method"], line["source"], line["heads"]) for line in have}
    for name in names:
        seeds = {
            s: sorted(r["seed"] for r in have if (r["method"], r["source"]) == (name, s))
            for s in sources
        }
        number = min(map(len, seeds.values()))
        for source in sources if number > 1 else ():
            if (f"{name}_mean", source, number) in there:
                continue
            files = [np.load(kept(out, name, source, seed)) for seed in seeds[source][:number]]
            rungs = [r for r in UNKNOWN if all(r in file.files for file in files)]
            answers = {
                r: letters_of(np.mean([file[r].astype(np.float32) for file in files], axis=0))
                for r in rungs
            }
            line = {"method": f"{name}_mean", "source": source, "seed": 0, "heads": number}
            append(out, {"format": FORMAT, **line, "answers": answers})


if __name__ == "__main__":
    main()
