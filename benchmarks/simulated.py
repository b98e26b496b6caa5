"""Quality of a simulated set: linear probes on sight, touch and both, and look-alikes.

    python -m benchmarks.simulated [--embeddings FILE] [--matrices]

A probe is logistic regression (C = 1) on unit rows of one domain's training pairs. It predicts that
domain's test pairs and all pairs of the others. Ceramic is left out where either domain lacks it.
Prints tables in Markdown; `docs/simulated.md` has the figures.
"""

import argparse
from collections.abc import Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.stats import t
from sklearn.linear_model import LogisticRegression

from benchmarks._markdown import table
from omnivat.data.domains import paper_name
from omnivat.data.embeddings import Embeddings
from omnivat.data.store import load_embeddings
from omnivat.head.heads import default_embeddings

Array = NDArray[Any]
READINGS = ("VIS", "TAC", "both, concatenated")
SCARCE = "ceramic"  # a class that TacQuad lacks
UNTESTED = -1


def unit(rows: Array) -> Array:
    """Return rows (N, D) of length 1."""
    wide = np.asarray(rows, np.float32)
    return np.asarray(wide / np.linalg.norm(wide, axis=1, keepdims=True))


def predictions(pairs: Embeddings) -> dict[str, Array]:
    """Return reading -> (S, N) classes that the probe of each domain predicts; -1 if untested."""
    vis, tac = unit(pairs.vis), unit(pairs.tac)
    inputs = dict(zip(READINGS, (vis, tac, np.hstack([vis, tac])), strict=True))
    train = np.array(pairs.rows["split"]) == "train"
    count = len(pairs.header.domains)
    scarce = np.array(pairs.header.classes)[pairs.label] == SCARCE
    has = np.isin(np.arange(count), pairs.domain[scarce])
    found = {name: np.full((count, len(pairs)), UNTESTED) for name in READINGS}
    for source in range(count):
        home = pairs.domain == source
        shared = has[source] & has[pairs.domain]  # targets that are tested with all classes
        for every in (True, False) if has[source] else (False,):
            kept = np.full(len(pairs), every) | ~scarce
            here = kept & ~(home & train) & (shared == every)
            for name, rows in inputs.items() if here.any() else ():
                some = home & train & kept
                probe = LogisticRegression(C=1.0, max_iter=3000).fit(rows[some], pairs.label[some])
                found[name][source, here] = probe.predict(rows[here])
    return found


def matrix(said: Array, pairs: Embeddings, chosen: Array) -> Array:
    """Return the accuracy (S, S) from each domain to each, of the chosen pairs; NaN without any."""
    count = len(said)
    shares = np.full((count, count), np.nan)
    for source, target in np.ndindex(count, count):
        rows = (pairs.domain == target) & chosen & (said[source] != UNTESTED)
        if rows.any():
            shares[source, target] = (said[source] == pairs.label)[rows].mean()
    return shares


def by_source(shares: Array, *, home: bool) -> Array:
    """Return a share for each source (S,): in it, or the mean over the other domains."""
    own = np.eye(len(shares), dtype=bool)
    return np.asarray(np.diag(shares) if home else np.nanmean(np.where(own, np.nan, shares), 1))


def groups(pairs: Embeddings) -> dict[str, Array]:
    """Return the rows of the table: words -> a mask of pairs."""
    looks, feels = (np.array(pairs.rows[name]) != "" for name in ("looks_like", "feels_like"))
    found = {
        "all": np.ones(len(pairs), bool),
        "look like another class": looks,
        "feel like another class": feels,
        "imitate no class": ~looks & ~feels,
    }
    return {name: mask for name, mask in found.items() if mask.any()}


def report(said: Mapping[str, Array], pairs: Embeddings) -> str:
    """Return accuracy (%) of every group and reading, and what both images add, as Markdown."""
    rows = []
    tested = said["VIS"] != UNTESTED
    own = pairs.domain[None] == np.arange(len(tested))[:, None]
    for name, mask in groups(pairs).items():
        for home in (True, False):
            number = int((tested & mask & (own == home)).sum())
            shares = [by_source(matrix(said[r], pairs, mask), home=home) for r in READINGS]
            cells = [f"{100 * np.nanmean(share):.1f}" for share in shares]
            cells += [_gain(shares[2], alone) for alone in shares[:2]]
            place = "within a domain" if home else "other domains"
            rows.append([f"{name}, {place}", str(number), *cells])
    return table(["pairs", "number", *READINGS, "over VIS", "over TAC"], rows)


def _gain(both: Array, alone: Array) -> str:
    """Return the mean difference with Student's 95 % interval over sources."""
    less = 100 * (both - alone)
    less = less[np.isfinite(less)]
    half = t.ppf(0.975, len(less) - 1) * less.std(ddof=1) / len(less) ** 0.5
    return f"{less.mean():+.1f} [{less.mean() - half:.1f}, {less.mean() + half:.1f}]"


def same_sensor(pairs: Embeddings) -> dict[str, float]:
    """Return, by domain, the share of test touches whose nearest training touch has their
    domain.
    """
    train, tac = np.array(pairs.rows["split"]) == "train", unit(pairs.tac)
    nearest = pairs.domain[train][(tac[~train] @ tac[train].T).argmax(1)]
    right, domain = nearest == pairs.domain[~train], pairs.domain[~train]
    return {
        name: float(right[domain == place].mean())
        for place, name in enumerate(pairs.header.domains)
    }


def main() -> None:
    """Print every table."""
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--embeddings", type=Path, default=default_embeddings(), help="a set")
    parser.add_argument("--matrices", action="store_true", help="also from each domain to each")
    options = parser.parse_args()
    pairs = load_embeddings(options.embeddings)
    said = predictions(pairs)
    print(report(said, pairs), "\n")
    names = [paper_name(name) for name in pairs.header.domains]
    for reading in READINGS if options.matrices else ():
        shares = 100 * matrix(said[reading], pairs, np.ones(len(pairs), bool))
        rows = [
            [name, *(f"{share:.0f}" for share in row)]
            for name, row in zip(names, shares, strict=True)
        ]
        print(table([f"{reading}: from, to", *names], rows))
    print("\nThe nearest touch is of the same sensor, % of test pairs:")
    print(", ".join(f"{paper_name(n)} {100 * s:.0f}" for n, s in same_sensor(pairs).items()))


if __name__ == "__main__":
    main()
