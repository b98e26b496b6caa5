"""What heads make of printed dots that are kept, filled, or on half of a source's touches.

    git show c37643a:examples/simulated.safetensors > build/kept.safetensors
    python -m benchmarks.dots_heads --kept build/kept.safetensors [--sources NAME,...] [--methods NAME;...]
    python -m benchmarks.dots_heads --table

KEPT has the pairs of the shipped set, embedded by `embed --dots keep`. Protocol and classes as in
`benchmarks.table`, one seed. The touches that a head learns and those of the tests are kept or
filled independently. "half": half of a source's touches with dots keep them. A source that has no
dots is trained once. "noise": white noise and offsets of the recipe; without: neither. OmniVaT's
parts are switched off one at a time, on fewer sources (PARTED), because each takes a training.

A line of docs/benchmarks/dots_heads.jsonl is a head on one kind of test: for each rung and reading
the accuracy in percent in each of the eight domains. Finished lines are kept.
"""

import argparse
import json
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from functools import partial
from itertools import product
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._table_methods import RECIPE, Array, Learned, erm_mlp, of_maps, omnivat, source_of
from benchmarks.table import WEIGHT, Measured
from benchmarks.table_text import interval
from omnivat.cli.arguments import listed
from omnivat.data.embeddings import Embeddings
from omnivat.data.store import load_embeddings
from omnivat.head.heads import default_embeddings
from omnivat.kit.threads import pin_thread
from omnivat.study.baselines import linear_maps

OUT = Path("docs/benchmarks/dots_heads.jsonl")
LEARNED = ("filled", "kept", "half")
TESTED = ("filled", "kept")
READINGS = {"photo": ("vis",), "touch": ("tac",), "both": ("vis", "tac")}
PARTED = ("TAG-sim", "TQ-DIGIT-sim")
PLAIN = RECIPE | {"noise": 0.0, "shift": 0.0}
RUNGS = {"home": "home", "none": "as it comes", "n5": "5", "n20": "20", "k5": "5 labels"}


def maps(embeddings: Embeddings, source: str, seed: int, noise: str) -> Learned:
    """Train linear maps with a stated noise."""
    return of_maps(linear_maps._fitted(source_of(embeddings, source, seed), noise))


WHOLE: dict[str, Callable[[Embeddings, str, int], Learned]] = {
    "linear maps": partial(maps, noise="noise 4, shift 1"),
    "linear maps, no noise": partial(maps, noise="none"),
    "ERM-MLP": erm_mlp,
    "ERM-MLP, no noise": partial(erm_mlp, recipe=PLAIN),
    "OmniVaT": omnivat,
    "OmniVaT, no noise": partial(omnivat, recipe=PLAIN),
}
PARTS: dict[str, Callable[[Embeddings, str, int], Learned]] = {
    "OmniVaT without MFFA": partial(omnivat, mffa=False),
    "OmniVaT without the tree": partial(omnivat, generation="none"),
    "OmniVaT without MMA": partial(omnivat, recipe=RECIPE | {"mma_weight": 0.0}),
    "OmniVaT without NOD": partial(omnivat, recipe=RECIPE | {"nod_weight": 0.0}),
    "OmniVaT without LANG": partial(omnivat, recipe=RECIPE | {"lang": False}),
}


def halved(kept: Embeddings, filled: Embeddings) -> Embeddings:
    """Return the filled set in which half of the touches with dots keep them."""
    printed = np.flatnonzero((kept.tac != filled.tac).any(1))
    some = np.random.default_rng(0).permutation(printed)[: len(printed) // 2]
    changed: dict[str, Any] = {}
    for name in ("tac", "tac_flip"):
        changed[name] = np.array(getattr(filled, name))
        changed[name][some] = getattr(kept, name)[some]
    return replace(filled, **changed)


def accuracies(run: Measured, tests: Embeddings) -> dict[str, dict[str, list[float]]]:
    """Return rung -> reading -> accuracy in percent in each domain; "home" has one.

    run    a method that has learned its source
    tests  the set with the targets' pairs
    """
    run.set = tests
    known = np.unique(tests.label[run.train])
    found: dict[str, dict[str, list[float]]] = {}
    for target in range(len(tests.header.domains)):
        test = run.rows(target, "test")
        test = test[np.isin(tests.label[test], known)]
        drawn = np.random.default_rng([run.seed, target]).permutation(run.rows(target, "train"))
        counts = {"home": 0} if target == run.source else {"none": 0, "n5": 5, "n20": 20}
        for rung, count in counts.items():
            raw = run.seen(test, drawn[:count])
            for reading, images in READINGS.items():
                if run.method.alone or reading == "both":
                    shares = run.method.readings({n: raw[n] for n in images})["fused"]
                    note(found, rung, reading, shares, tests.label[test])
        if target != run.source:
            label = tests.label[drawn]
            some = np.concatenate([drawn[label == c][:5] for c in np.unique(label)])
            note(found, "k5", "both", run.taught(test, some, WEIGHT / 5), tests.label[test])
    return found


def note(found: dict[str, Any], rung: str, reading: str, shares: Any, label: Array) -> None:
    """Add the accuracy of class probabilities (N, K) to a rung and reading."""
    right = 100 * float((shares.argmax(-1).numpy() == label).mean())
    found.setdefault(rung, {}).setdefault(reading, []).append(round(right, 2))


def trained(
    sets: Mapping[str, Embeddings],
    sources: Sequence[str],
    methods: Sequence[str],
    done: set[tuple[str, str, str]],
) -> Iterator[dict[str, Any]]:
    """Yield the lines that are missing."""
    domain = sets["filled"].domain
    printed = set(domain[(sets["kept"].tac != sets["filled"].tac).any(1)].tolist())
    for part, source in product((WHOLE, PARTS), sources):
        has = sets["filled"].header.domains.index(source) in printed
        for name in part if part is WHOLE or source in PARTED else ():
            if any(methods) and name not in methods:
                continue
            for learned in (LEARNED[: 3 if part is WHOLE else 2]) if has else ("filled",):
                if (name, source, learned) in done:
                    continue
                run = Measured(sets[learned], name, source, 0, {**WHOLE, **PARTS})
                for tested in TESTED:
                    line = {
                        "method": name,
                        "source": source,
                        "learned": learned,
                        "tested": tested,
                        "printed": has,
                    }
                    yield {**line, **accuracies(run, sets[tested])}


def cells(
    lines: Sequence[Mapping[str, Any]],
    method: str,
    learned: str,
    tested: str,
    place: tuple[str, str],
    sources: Sequence[str],
) -> Array:
    """Return accuracies (sources, targets, 1) of a rung and reading; NaN: none was made. A source
    without dots has learned the same either way.
    """
    own = {
        line["source"]: line[place[0]].get(place[1])
        for line in lines
        if (line["method"], line["tested"]) == (method, tested)
        and line["learned"] in ((learned,) if line["printed"] else ("filled",))
    }
    if not sources or set(sources) - set(own) or None in own.values():
        return np.full((1, 1, 1), np.nan)
    return np.array([own[source] for source in sources])[..., None]


def table(lines: Sequence[Mapping[str, Any]]) -> Iterator[str]:
    """Yield the tables of docs/dots.md."""
    every = sorted({line["source"] for line in lines if line["method"] == "OmniVaT"})
    marked = sorted({line["source"] for line in lines if line["printed"]})
    parted = sorted({line["source"] for line in lines if line["method"] in PARTS})
    of = partial(cells, lines)

    def change(name: str, place: tuple[str, str]) -> str:
        means = (of(name, state, state, place, every).mean() for state in ("kept", "filled"))
        return " → ".join(f"{mean:.1f}" for mean in means)

    yield f"| head | reading | {' | '.join(RUNGS.values())} | filled less kept, as it comes |"
    yield "| --- | --- |" + " ---: |" * (len(RUNGS) + 1)
    for name, reading in product(WHOLE, READINGS):
        gain = _difference(
            *(of(name, state, state, ("none", reading), every) for state in ("filled", "kept"))
        )
        if gain != "–":
            values = [change(name, (rung, reading)) for rung in RUNGS]
            row = " | ".join(values).replace("nan → nan", "–")
            yield f"| {name} | {reading} | {row} | {gain} |"
    states = list(product(LEARNED, TESTED))
    yield f"\n{', '.join(marked)}:\n"
    yield "| head | " + " | ".join(f"{one}, {other}" for one, other in states) + " |"
    yield "| --- |" + " ---: |" * len(states)
    for name in WHOLE:
        values = [
            " / ".join(
                f"{of(name, *state, (rung, 'both'), marked).mean():.1f}"
                for rung in ("home", "none")
            )
            for state in states
        ]
        yield f"| {name} | {' | '.join(values)} |"
    yield "\n| OmniVaT less | sources | kept, as it comes | filled | kept, 20 pictures | filled |"
    yield "| --- | ---: |" + " ---: |" * 4
    for name in (*list(WHOLE)[:4], *PARTS):
        own = parted if name in PARTS else every
        base = "OmniVaT, no noise" if name.endswith("no noise") else "OmniVaT"
        values = [
            _difference(*(of(one, state, state, (rung, "both"), own) for one in (base, name)))
            for rung, state in product(("none", "n20"), ("kept", "filled"))
        ]
        yield f"| {name} | {len(own)} | {' | '.join(values)} |"


def _difference(one: Array, other: Array) -> str:
    if np.isnan(one).any() or np.isnan(other).any():
        return "–"
    mean, low, high = interval(one - other)
    return f"{mean:+.1f} [{low:.1f}, {high:.1f}]".replace("-", "−")


def main() -> None:
    """Add the missing lines, or print the tables."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--kept", type=Path, help="the shipped set's pairs, dots kept")
    parser.add_argument("--sources", default="", help="domains to learn from; all by default")
    parser.add_argument("--methods", default="", help="heads, as a line names them, by ';'")
    parser.add_argument("--out", type=Path, default=OUT)
    parser.add_argument("--table", action="store_true", help="print the tables of the record")
    options = parser.parse_args()
    there = options.out.read_text().splitlines() if options.out.exists() else []
    lines = [json.loads(line) for line in there]
    if options.table:
        print("\n".join(table(lines)))
        return
    pin_thread()
    sets = {"filled": load_embeddings(default_embeddings()), "kept": load_embeddings(options.kept)}
    sets["half"] = halved(sets["kept"], sets["filled"])
    sources = listed(options.sources) or sets["filled"].header.domains
    done = {(line["method"], line["source"], line["learned"]) for line in lines}
    with options.out.open("a") as file:
        for line in trained(sets, sources, options.methods.split(";"), done):
            file.write(json.dumps(line) + "\n")
            file.flush()
            print(*list(line.values())[:4], line.get("none"), flush=True)


if __name__ == "__main__":
    main()
