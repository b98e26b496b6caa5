"""Heads with the same budget on further sets, drawn with other seeds, so that a lead is not one set's luck.

    python -m omnivat simulate --out SET --seed 1 --pairs-per-class 30
    python -m omnivat embed SET --out SET.safetensors --dtype float16
    python -m benchmarks.ladder_sets --embeddings SET.safetensors --name 1 [--sources NAME,...] [--members 0,1,2,3,4]

Every method is trained by the page's recipe (standardised input, noise, imitated sensors), five members of each. One line
is written for each set, source, method and member: the class predicted for every pair as it comes, the log-odds of the test
pairs, and the classes of the test pairs with 5 and 20 unlabelled pairs of their domain. Lines of "mean" are the soft
ensembles of all five, "distilled" is one OmniVaT head taught by five. Finished lines are kept.
`python -m benchmarks.ladder_sets_table` makes the table.
"""

import argparse
import gzip
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._ladder_methods import RECIPES, Array, Trained, distilled, ensemble, onto, profile, rows_of
from omnivat.cli.arguments import listed, numbers
from omnivat.data.packing import odds
from omnivat.data.profile import STEP_SHIFTED
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.kit.lines import lines
from omnivat.kit.threads import pin_thread
from omnivat.measure.ladder import lettered
from omnivat.study.protocol.records import append, fingerprint, mend

FORMAT = "omnivat-sets-1"
METHODS = ("logistic_recipe", "erm_recipe", "dtg_recipe", "omnivat")
MEMBERS = 5
KNOWN = {"n5": 5, "n20": 20}  # pairs without labels
OUT = Path("build/ladder_sets.jsonl")


class FromSource:
    """All pairs of a set, as a head of one source meets them."""

    def __init__(self, embeddings: Embeddings, source: int) -> None:
        self.set, self.source = embeddings, source
        self.tested = np.array(embeddings.rows["split"]) == "test"
        self.profile = profile(rows_of(embeddings, self.rows(source, test=False)))

    def rows(self, domain: int, *, test: bool) -> Array:
        return np.flatnonzero((self.set.domain == domain) & (self.tested == test))

    def predictions(self, method: Trained, draw: int) -> dict[str, str]:
        """Return what a line holds of a method; `draw` is the seed of the unlabelled pairs."""
        shares = method.probabilities(rows_of(self.set, np.arange(len(self.set))))
        found = {"odds": odds(np.log(np.maximum(shares[self.tested], 1e-12))), "all": lettered(shares.argmax(1))}
        for name, count in KNOWN.items():
            guess = np.full(len(self.set), -1)
            for domain in range(len(self.set.header.domains)):
                if domain != self.source:
                    pool, test = self.rows(domain, test=False), self.rows(domain, test=True)
                    some = np.random.default_rng([draw, domain]).permutation(pool)[:count]
                    target = profile(rows_of(self.set, some))
                    pair = onto(rows_of(self.set, test), target, self.profile, STEP_SHIFTED)
                    guess[test] = method.predict(pair)
            found[name] = lettered(guess[self.tested])
        return found


def facts(embeddings: Embeddings, name: str) -> dict[str, Any]:
    """Return a set's first line: its pairs, for tables without the set."""
    return {
        "format": FORMAT,
        "set": name,
        "data": fingerprint(embeddings),
        "domains": list(embeddings.header.domains),
        "classes": list(embeddings.header.classes),
        "domain": lettered(embeddings.domain),
        "truth": lettered(embeddings.label),
        "split": "".join(split[1] for split in embeddings.rows["split"]),  # r of train, e of test
    }


def of_source(
    embeddings: Embeddings, name: str, source: str, methods: Sequence[str], members: Sequence[int], out: Path
) -> None:
    """Train what has no line yet and write it."""
    have = {(one["set"], one["source"], one["method"], one["member"]) for one in lines(out, FORMAT) if "method" in one}
    pairs = FromSource(embeddings, embeddings.header.domains.index(source))

    def note(method: str, member: int | str, trained: Trained, draw: int) -> None:
        line = {"format": FORMAT, "set": name, "source": source, "method": method, "member": member}
        append(out, {**line, **pairs.predictions(trained, draw)})
        print(name, source, method, member, flush=True)

    every = list(members) == list(range(MEMBERS))
    for method in methods:
        wanted = [*members, "mean"] if every else members
        if all((name, source, method, member) in have for member in wanted):
            continue
        heads = [RECIPES[method](embeddings, source, member) for member in members]
        for member, head in zip(members, heads, strict=True):
            if (name, source, method, member) not in have:
                note(method, member, head, member)
        if every:
            note(method, "mean", ensemble(heads), 0)
    if every and "omnivat" in methods and (name, source, "distilled", 0) not in have:
        note("distilled", 0, distilled(embeddings, source, 0, MEMBERS), 0)


def main() -> None:
    """Add the missing lines to the records, and pack them for --pack."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, help="a set; without it, the records are only packed")
    parser.add_argument("--name", default="1", help="of the set in the records: the seed it was drawn with")
    parser.add_argument("--sources", default="", help="domains; default: all")
    parser.add_argument("--methods", default=",".join(METHODS), help="of the table")
    parser.add_argument("--members", default="0,1,2,3,4", help="seeds; ensembles need all five")
    parser.add_argument("--out", type=Path, default=OUT, help="the records")
    parser.add_argument("--pack", type=Path, help="also write the records here, compressed (.gz)")
    options = parser.parse_args()
    if options.embeddings:
        pin_thread()
        embeddings = load_embeddings(options.embeddings)
        mend(options.out)
        if not any(one["set"] == options.name for one in lines(options.out, FORMAT)):
            append(options.out, facts(embeddings, options.name))
        for source in listed(options.sources) or embeddings.header.domains:
            methods, members = listed(options.methods), numbers(options.members)
            of_source(embeddings, options.name, source, methods, members, options.out)
    if options.pack:
        options.pack.write_bytes(gzip.compress(options.out.read_bytes(), 9, mtime=0))


if __name__ == "__main__":
    main()
