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
"""

import argparse
import gzip
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
import torch
from torch import Tensor
from torch.nn.functional import normalize

from benchmarks._table_methods import METHODS, PUBLISHED, Array, Learned, published, raw_of
from omnivat.cli.arguments import listed, numbers
from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import Channels, channels_of, moved
from omnivat.data.store import load_embeddings
from omnivat.head.heads import LADDERS, default_embeddings
from omnivat.kit.lines import lines
from omnivat.kit.stages import IMAGES
from omnivat.kit.threads import pin_thread
from omnivat.measure.ladder import FORMAT, lettered
from omnivat.study.protocol.records import append, fingerprint, mend

PICTURES = (1, 5, 20, 50)  # pairs of the target without labels
LABELLED = (1, 3, 5)  # labelled pairs of each class
SOURCES = (2, 4, 7)  # source domains, for the method that needs no training
UNKNOWN = (
    "home",
    "none",
    *IMAGES,
)  # rungs that know no pair of the target; others draw some by seed
# of the ridge regression; labelled pairs of a class count as WEIGHT pairs
PENALTY, WEIGHT = 1.0, 20
Profiles = dict[str, Channels]


class Measured:
    """One method, one source, one seed."""

    def __init__(
        self,
        embeddings: Embeddings,
        name: str,
        source: str,
        seed: int,
        methods: Mapping[str, Callable[[Embeddings, str, int], Learned]] = METHODS,
    ) -> None:
        name, _, count = name.partition("@")
        if count:
            embeddings = few(embeddings, source, int(count), seed)
        self.set, self.name, self.seed = embeddings, name, seed
        self.source = embeddings.header.domains.index(source)
        self.split = np.array(embeddings.rows["split"])
        self.tested = np.flatnonzero(self.split == "test")
        self.train = self.rows(self.source, "train")
        own = raw_of(embeddings, self.train)
        self.profile = {n: channels_of(x.numpy()) for n, x in own.items()}
        started = time.perf_counter()
        if name in PUBLISHED:
            self.method: Learned = published(name, embeddings, source, seed)
        else:
            self.method = methods[name](embeddings, source, seed)
        self.seconds = time.perf_counter() - started
        self.own_features = self.method.features(own)

    def rows(self, domain: int, split: str) -> Array:
        """Return the rows of a domain's training or test pairs."""
        return np.flatnonzero((self.set.domain == domain) & (self.split == split))

    def seen(self, rows: Array, known: Array) -> dict[str, Tensor]:
        """Return rows of a target, moved by the profile of its rows `known`."""
        raw = raw_of(self.set, rows)
        if not len(known):
            return raw
        pictures = raw_of(self.set, known)
        return {
            n: torch.from_numpy(
                moved(
                    x.numpy(), channels_of(pictures[n].numpy()), self.profile[n], self.method.step
                )
            )
            for n, x in raw.items()
        }

    def shares(self) -> dict[str, Array]:
        """Return rung -> class probabilities of all test pairs (N, K); NaN where none was made."""
        found: dict[str, Array] = {}
        for target in range(len(self.set.header.domains)):
            place = self.set.domain[self.tested] == target
            for rung, values in self.of(target):
                empty = np.full(
                    (len(self.tested), len(self.set.header.classes)), np.nan, np.float32
                )
                found.setdefault(rung, empty)[place] = values.numpy()
        return found

    def of(self, target: int) -> Iterator[tuple[str, Tensor]]:
        """Yield rung and probabilities for the test pairs of one domain."""
        test, pool = self.rows(target, "test"), self.rows(target, "train")
        plain = raw_of(self.set, test)
        if target == self.source:
            yield "home", self.method.readings(plain)["fused"]
            return
        for name in IMAGES if self.method.alone else ():
            yield name, self.method.readings({name: plain[name]})["fused"]
        drawn = np.random.default_rng([self.seed, target]).permutation(pool)
        for count in (0, *PICTURES, len(pool)):
            rung = {0: "none", len(pool): "all"}.get(count, f"n{count}")
            yield rung, self.method.readings(self.seen(test, drawn[:count]))["fused"]
        label = self.set.label[drawn]
        for k in LABELLED:
            some = np.concatenate([drawn[label == c][:k] for c in np.unique(label)])
            yield f"k{k}", self.taught(test, some, WEIGHT / k)
        if self.name == "nearest_mean" and self.seed == 0:
            for count in SOURCES:
                yield f"m{count}", self.of_several(test, target, count, profiled=False)
                yield f"m{count}+", self.of_several(test, target, count, profiled=True)

    def taught(self, test: Array, some: Array, weight: float) -> Tensor:
        """Return the probabilities of a ridge regression on features, with labelled pairs
        `some`.
        """
        features = torch.cat((self.own_features, self.method.features(self.seen(some, some))))
        labels = np.concatenate((self.set.label[self.train], self.set.label[some]))
        weights = torch.ones(len(features))
        weights[len(self.train) :] = weight
        classes = len(self.set.header.classes)
        asked = self.method.features(self.seen(test, some))
        return ridge(features, torch.from_numpy(labels), classes, weights, asked)

    def of_several(self, test: Array, target: int, count: int, *, profiled: bool) -> Tensor:
        """Return nearest class means of several sources.

        profiled  each domain by its own profile
        """
        others = [d for d in range(len(self.set.header.domains)) if d not in (self.source, target)]
        random = np.random.default_rng([self.seed, target, 1])
        chosen = random.permutation(others)[: count - 1]
        rows = [self.rows(d, "train") for d in chosen]
        none = np.zeros(0, np.int64)
        parts = [raw_of(self.set, self.train)]
        parts += [self.seen(each, each if profiled else none) for each in rows]
        features = torch.cat([self.method.features(part) for part in parts])
        labels = np.concatenate(
            [self.set.label[self.train], *(self.set.label[each] for each in rows)]
        )
        asked = self.seen(test, self.rows(target, "train") if profiled else none)
        sums = features.new_zeros(len(self.set.header.classes), features.shape[1])
        sums.index_add_(0, torch.from_numpy(labels), features)
        means = normalize(sums, dim=-1)
        return (10 * normalize(self.method.features(asked), dim=-1) @ means.T).softmax(-1)


def few(embeddings: Embeddings, source: str, count: int, seed: int) -> Embeddings:
    """Return the set with at most `count` training pairs of each class of the source."""
    pool = embeddings.rows_of(source, split="train")
    mixed = np.random.default_rng([seed, count]).permutation(pool)
    label = embeddings.label[mixed]
    kept = np.concatenate([mixed[label == c][:count] for c in np.unique(label)])
    return embeddings.select(np.setdiff1d(np.arange(len(embeddings)), np.setdiff1d(pool, kept)))


def ridge(rows: Tensor, labels: Tensor, classes: int, weights: Tensor, asked: Tensor) -> Tensor:
    """Return the scores of a weighted ridge regression of one-hot classes as probabilities.

    Rows are brought to unit length. A class without a row gets probability 0.
    """
    rows, asked = (normalize(x.double(), dim=-1) for x in (rows, asked))
    hot = torch.nn.functional.one_hot(labels, classes).double()
    mean = (weights[:, None] * rows).sum(0) / weights.sum()
    base = (weights[:, None] * hot).sum(0) / weights.sum()
    root = weights.double().sqrt()[:, None]
    centred, targets = root * (rows - mean), root * (hot - base)
    gram = centred @ centred.T
    gram.diagonal().add_(PENALTY)
    scores = (asked - mean) @ (centred.T @ torch.linalg.solve(gram, targets)) + base
    absent = hot.sum(0) == 0
    shares: Tensor = (10 * scores).masked_fill(absent, -torch.inf).softmax(-1).float()
    return shares


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
        "look_alike": "".join("01"[int(one)] for one in looks),
    }


def main() -> None:
    """Add the missing lines to the records, and pack them where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--methods", default=",".join((*METHODS, *PUBLISHED)), help="by name")
    parser.add_argument("--seeds", default="0,1,2,3,4", help="of training and drawing")
    parser.add_argument("--out", type=Path, default=Path("build/table.jsonl"), help="the records")
    parser.add_argument("--pack", action="store_true", help=f"write them to {LADDERS.name}, too")
    options = parser.parse_args()
    pin_thread()
    embeddings = load_embeddings(options.embeddings)
    mend(options.out)
    done = list(lines(options.out, FORMAT))
    if not done:
        append(options.out, facts(embeddings))
    have = {(one["method"], one["source"], one["seed"]) for one in done[1:]}
    for seed in numbers(options.seeds):
        for source in embeddings.header.domains:
            for name in listed(options.methods):  # two of them share one fit
                if (name, source, seed) not in have:
                    write_run(embeddings, name, source, seed, options.out)
    if options.pack:
        average(options.out, listed(options.methods), embeddings.header.domains)
        LADDERS.write_bytes(gzip.compress(options.out.read_bytes(), 9, mtime=0))


def write_run(embeddings: Embeddings, name: str, source: str, seed: int, out: Path) -> None:
    """Measure one method on one source with one seed; keep its probabilities for their mean."""
    run = Measured(embeddings, name, source, seed)
    shares = run.shares()
    place = kept(out, name, source, seed)
    place.parent.mkdir(parents=True, exist_ok=True)
    packed: dict[str, Any] = {rung: v.astype(np.float16) for rung, v in shares.items()}
    np.savez(place, **packed)
    line = {
        "format": FORMAT,
        "method": name,
        "source": source,
        "seed": seed,
        "heads": 1,
        "seconds": round(run.seconds, 1),
        "parameters": run.method.parameters,
        "answers": {rung: letters_of(values) for rung, values in shares.items()},
    }
    append(out, line)
    print(name, source, seed, f"{run.seconds:.1f} s", flush=True)


def kept(out: Path, name: str, source: str, seed: int) -> Path:
    """Return the file of a run's probabilities."""
    return out.with_suffix("") / f"{name}-{source.replace(' ', '')}-{seed}.npz"


def average(out: Path, names: Sequence[str], sources: Sequence[str]) -> None:
    """Add a line for the mean of all heads of each method and source, where each source has
    several.
    """
    have = [one for one in lines(out, FORMAT) if "method" in one]
    there = {(one["method"], one["source"], one["heads"]) for one in have}
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
            rungs = [r for r in UNKNOWN if all(r in one.files for one in files)]
            answers = {
                r: letters_of(np.mean([one[r].astype(np.float32) for one in files], axis=0))
                for r in rungs
            }
            line = {"method": f"{name}_mean", "source": source, "seed": 0, "heads": number}
            append(out, {"format": FORMAT, **line, "answers": answers})


if __name__ == "__main__":
    main()
