"""The ladder: every quick method of the table, with more and more known about the target domain.

    python -m benchmarks.ladder [--methods NAME,...] [--sources NAME,...] [--seeds 0,1,2] [--out build/ladder.jsonl]

A method is trained once for each source and seed, on embeddings standardised by the source's profile. Then every
rung is evaluated: the target's profile of n pairs without labels; test-time methods beside it (T3A, LAME,
self-training); for the closed-form methods, labelled pairs and more source domains. Test objects only. One line is
written for each method, source and seed: the class predicted for every test pair, as a letter, on every rung; of
trained methods the log-odds of every test pair as it comes (`omnivat.data.packing.odds`), of OmniVaT also gaps and
retrieval in its features (`benchmarks._ladder_space`).
Finished lines are kept, so a stopped run goes on. `python -m benchmarks.ladder_table` makes the table and the figure.
"""

import argparse
import gzip
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._ladder_methods import (
    CLOSED,
    RECIPES,
    Array,
    Pair,
    baseline,
    closed,
    light_head,
    onto,
    profile,
    rows_of,
)
from benchmarks._ladder_space import space
from benchmarks._ladder_unlabelled import lame, self_trained, t3a
from omnivat.cli.arguments import listed, numbers
from omnivat.data.packing import odds
from omnivat.data.profile import STEP_SHIFTED
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.kit.lines import lines
from omnivat.kit.threads import pin_thread
from omnivat.measure.ladder import COUNTS, FORMAT, METHOD, lettered
from omnivat.study.protocol.records import append, fingerprint, mend

RECIPE = ("logistic_recipe", "erm_recipe", "dtg_recipe", "omnivat")  # trained as the page's head
METHODS = (*CLOSED, "linear_probe", "erm_mlp", "vt_cmc_head", "ldc_icd", *RECIPE)
# and, with --seeds 0, of several heads of the recipe: omnivat_soft, dtg_soft, erm_soft, logistic_soft, distilled
ONE_CLASS = 20  # pictures without labels, all of one class
LABELLED, SOURCES = (1, 3, 5), (2, 4, 7)


class Climb:
    """One method, one source, one seed."""

    def __init__(self, embeddings: Embeddings, name: str, source: int, seed: int) -> None:
        self.set, self.name, self.source, self.seed = embeddings, name, source, seed
        self.split = np.array(embeddings.rows["split"])
        self.train = self.rows(source, "train")
        self.own = rows_of(embeddings, self.train)
        self.labels = embeddings.label[self.train]
        self.profile = profile(self.own)
        self.classes = len(embeddings.header.classes)
        self.method = self.trained()

    def trained(self) -> Any:
        if self.name in CLOSED:
            return closed(self.name, self.own, self.labels, self.profile, self.classes)
        if self.name in RECIPES:
            return RECIPES[self.name](self.set, self.set.header.domains[self.source], self.seed)
        return baseline(self.name, self.set, self.train, self.profile, self.seed)

    def rows(self, domain: int, split: str) -> Array:
        return np.flatnonzero((self.set.domain == domain) & (self.split == split))

    def seen(self, rows: Array, known: Array) -> Pair:
        """Return rows of a target, moved by the profile of its rows `known`."""
        target = profile(rows_of(self.set, known)) if len(known) else None
        step = STEP_SHIFTED if self.name in RECIPES else 1.0  # as a head of that recipe
        return onto(rows_of(self.set, rows), target, self.profile, step)

    def rungs(self) -> dict[str, str]:
        """Return rung -> answers over all test pairs, as letters."""
        tested = np.flatnonzero(self.split == "test")
        found: dict[str, Array] = {}
        for target in range(len(self.set.header.domains)):
            place = self.set.domain[tested] == target
            for rung, answers in self.of(target):
                found.setdefault(rung, np.full(len(tested), -1))[place] = answers
        return {rung: lettered(answers) for rung, answers in found.items()}

    def odds(self) -> str:
        """Return the log-odds of all test pairs as they come."""
        pair = rows_of(self.set, np.flatnonzero(self.split == "test"))
        return odds(np.log(np.maximum(self.method.probabilities(pair), 1e-12)))

    def more_of(self) -> dict[str, Any]:
        """Return what a line has besides: odds, and of a single head its gaps and retrieval."""
        if self.name in CLOSED:
            return {}
        if self.name != METHOD:
            return {"odds": self.odds()}
        model = light_head(self.set, self.set.header.domains[self.source], self.seed)
        tested = np.flatnonzero(self.split == "test")
        return {"odds": self.odds(), "space": space(model, self.set, self.train, tested)}

    def of(self, target: int) -> Iterator[tuple[str, Array]]:
        """Yield rung and answers for the test pairs of one domain."""
        test, pool = self.rows(target, "test"), self.rows(target, "train")
        if target == self.source:
            yield "home", self.method.predict(rows_of(self.set, test))
            return
        drawn = np.random.default_rng([self.seed, target]).permutation(pool)
        label = self.set.label[drawn]
        for count in (0, *COUNTS):  # fewer pairs are among more
            name = f"n{count}" if count else "none"
            yield name, self.method.predict(self.seen(test, drawn[:count]))
        for c in np.unique(label):
            one = drawn[label == c][:ONE_CLASS]
            yield f"one:{self.set.header.classes[c]}", self.method.predict(self.seen(test, one))
        asked, new = self.seen(test, pool), self.seen(pool, pool)
        yield "all", self.method.predict(asked)
        yield "t3a", t3a(self.method, self.own, self.labels, new, asked)
        yield "lame", lame(self.method, new, asked)
        if self.name in CLOSED:
            given = (self.own, self.labels, new, asked, self.profile, self.classes)
            yield "self", self_trained(self.name, *given)
            for k in LABELLED:
                some = np.concatenate([drawn[label == c][:k] for c in np.unique(label)])
                yield f"k{k}", self.taught(test, some, max(1, 20 // k))
            for m in SOURCES if self.seed == 0 else ():  # the dearest rungs
                yield f"m{m}", self.more(test, target, m, None)
                yield f"m{m}+", self.more(test, target, m, pool)

    def taught(self, test: Array, some: Array, weight: int) -> Array:
        """Return answers after labelled pairs `some`, counted `weight` times, and their profile."""
        new = self.seen(some, some)
        both = tuple(np.vstack([a, *[b] * weight]) for a, b in zip(self.own, new, strict=True))
        labels = np.r_[self.labels, np.tile(self.set.label[some], weight)]
        model = closed(self.name, both, labels, self.profile, self.classes)  # type: ignore[arg-type]
        return model.predict(self.seen(test, some))

    def more(self, test: Array, target: int, count: int, pool: Array | None) -> Array:
        """Return answers of `count` source domains; with `pool`, every domain by its own profile."""
        others = [d for d in range(len(self.set.header.domains)) if d not in (self.source, target)]
        random = np.random.default_rng([self.seed, target, 1])
        chosen = [self.rows(d, "train") for d in random.permutation(others)[: count - 1]]
        labels = np.concatenate([self.labels, *(self.set.label[rows] for rows in chosen)])
        none = np.zeros(0, np.int64)
        pairs = [self.seen(rows, none if pool is None else rows) for rows in chosen]
        both: Any = tuple(np.vstack(x) for x in zip(self.own, *pairs, strict=True))
        base = profile(both) if pool is None else self.profile
        model = closed(self.name, both, labels, base, self.classes)
        return model.predict(self.seen(test, none if pool is None else pool))


def facts(embeddings: Embeddings) -> dict[str, Any]:
    """Return the first line of the records: the test pairs, for tables without the set."""
    tested = np.array(embeddings.rows["split"]) == "test"
    return {
        "format": FORMAT,
        "data": fingerprint(embeddings),
        "domains": list(embeddings.header.domains),
        "classes": list(embeddings.header.classes),
        "domain": embeddings.domain[tested].tolist(),
        "truth": lettered(embeddings.label[tested]),
    }


def main() -> None:
    """Add the missing lines to the records, and pack them where asked to."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--methods", default=",".join(METHODS), help="of the table")
    parser.add_argument("--sources", default="", help="domains; default: all")
    parser.add_argument("--seeds", default="0,1,2", help="of training and drawing")
    parser.add_argument("--out", type=Path, default=Path("build/ladder.jsonl"), help="the records")
    parser.add_argument("--pack", type=Path, help="also write the records here, compressed (.gz)")
    options = parser.parse_args()
    pin_thread()
    embeddings = load_embeddings(options.embeddings)
    domains = embeddings.header.domains
    mend(options.out)
    done = list(lines(options.out, FORMAT))
    if not done:
        append(options.out, facts(embeddings))
    have = {(one["method"], one["source"], one["seed"]) for one in done[1:]}
    for seed in numbers(options.seeds):
        for name in listed(options.methods):
            for source in listed(options.sources) or domains:
                if (name, source, seed) not in have:
                    climb = Climb(embeddings, name, domains.index(source), seed)
                    found = climb.rungs()
                    line = {"method": name, "source": source, "seed": seed, "answers": found}
                    append(options.out, {"format": FORMAT, **line, **climb.more_of()})
                    print(name, source, seed, len(found), "rungs", flush=True)
    if options.pack:
        options.pack.write_bytes(gzip.compress(options.out.read_bytes(), 9, mtime=0))


if __name__ == "__main__":
    main()
