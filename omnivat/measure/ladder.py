"""The ladder: what is known about a new sensor, and the accuracy that each step brings.

Every rung is accuracy over unseen domains with something known about them, beside the strict
protocol, in which nothing is. The loaded head's own rungs are computed in seconds; those that need
another training come from the records of `python -m benchmarks.table`, a light head like the
default one.
"""

from collections.abc import Iterator, Mapping, Sequence
from functools import cache
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.head.heads import LADDERS, ladder_file, ladder_key
from omnivat.kit.files import write_json
from omnivat.kit.lines import lines
from omnivat.measure.known import at_home, measured
from omnivat.measure.rungs import RUNGS, Row, known_of
from omnivat.measure.shares import record

FORMAT = "omnivat-ladder-1"
METHOD = "omnivat"  # in the records: the light head, trained as the default one
OTHERS = {"logistic": "logistic regression", "nearest_mean": "nearest class mean"}  # for the rest
# one step: shares of right predictions, mean over unseen domains with a 95 % interval
Rung = dict[str, Any]


def rungs(head: Head, embeddings: Embeddings, *, source: str = "") -> list[Rung]:
    """Return the ladder as plain records: rung, known, accuracy, low, high, source, from.

    source  the domain to climb from; "": the head's. Another one is read from the records

    The rungs of `this head` are computed on the test pairs of `embeddings`; all others are from the
    `records`. Shares lie between 0 and 1. Raises DataError for embeddings of another encoder.
    """
    own = source in ("", head.source) and head.source in embeddings.header.domains
    found = {one["rung"]: one for one in recorded(source or head.source, embeddings.header.domains)}
    if own:
        found |= {one["rung"]: one for one in _of_head(head, embeddings)}
    return [found[row["id"]] for row in RUNGS if row["id"] in found]


def ladder(head: Head, embeddings: Embeddings, *, source: str = "") -> dict[str, Any]:
    """Return `rungs`, and as `sources` the domains that have a ladder, the head's first.

    >>> from omnivat import EXAMPLES, load_embeddings, load_head
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> for rung in ladder(head, pairs)["rungs"]:
    ...     print(rung["known"], rung["accuracy"] > 0.9)
    its own sensor True
    nothing: pictures as they come True
    """
    domains = embeddings.header.domains
    own = [head.source] if head.source in domains else []
    others = [name for name in domains if name != head.source and recorded(name, domains)]
    return {"rungs": rungs(head, embeddings, source=source), "sources": [*own, *others]}


def write_ladder(head: Head, embeddings: Embeddings, place: Path) -> Path:
    """Write the head's ladder next to its set, the file `place`, so that the page need not
    compute it.
    """
    assert head.path is not None, "the ladder of a head that is not saved"
    write_json(
        ladder_file(place), {"of": ladder_key(head.path, place), "ladder": ladder(head, embeddings)}
    )
    return ladder_file(place)


def _of_head(head: Head, embeddings: Embeddings) -> Iterator[Rung]:
    """Yield the rungs that need no training; without a profile, home and away only."""
    plain = measured(head, embeddings)
    for row in RUNGS:
        known = known_of(row)
        if known is None or ((known.pairs or known.labels) and head.profile is None):
            continue
        step = measured(head, embeddings, known) if known.pairs or known.labels else plain
        step = at_home(step) if row.get("home") else step
        if step["accuracy"] is not None:  # a test pair of the source, or of another domain
            yield _rung(row, step, head.source, "this head")


def _rung(row: Row, step: Mapping[str, Any], source: str, origin: str) -> Rung:
    kept = {key: step[key] for key in ("accuracy", "low", "high")}
    return {"rung": row["id"], "known": row["words"], **kept, "source": source, "from": origin}


@cache
def _records() -> tuple[Mapping[str, Any], list[Mapping[str, Any]]]:
    """Return the head line of the shipped records, and the lines that `recorded` reads."""
    found = list(lines(LADDERS, FORMAT))
    return (found[0] if found else {}), [
        one for one in found[1:] if one["method"] in (METHOD, *OTHERS)
    ]


def recorded(source: str, domains: Sequence[str]) -> list[Rung]:
    """Return the recorded rungs of heads trained on `source`; none without records.

    domains  of the set: what was recorded on other domains does not count

    A rung that the light head has not climbed is another method's, whose name `known` then has.
    """
    first, records = _records()
    records = [one for one in records if one["source"] == source]
    if not records or first["domains"] != list(domains):
        return []
    domain = np.array(first["domain"])
    home = first["domains"].index(source)
    truth = letters(first["truth"])
    taught = np.isin(truth, truth[domain == home])  # others are left out, as in `evaluate`
    found = []
    for row in RUNGS:
        name, words = row["id"], row["words"]
        for method in (METHOD, *OTHERS):
            rows = [
                np.where(taught, marks(answers, truth), np.nan)
                for one in records
                if one["method"] == method
                if (answers := one["answers"].get(name))
            ]
            if rows:
                known = words if method == METHOD else f"{words} ({OTHERS[method]})"
                right = np.stack(rows)
                right[:, (domain == home) != (name == "home")] = np.nan
                step = record(right, domain, first["domains"])
                found.append(_rung(row, step, source, "records") | {"known": known})
                break
    return found


def letters(text: str) -> NDArray[np.int64]:
    """Return the class indices of a text of letters; -1 for a dot: "ab." gives 0, 1, -1."""
    codes = np.frombuffer(text.encode("ascii"), np.uint8).astype(np.int64)
    return np.where(codes == ord("."), -1, codes - ord("a"))


def lettered(labels: NDArray[np.int64]) -> str:
    """Return class indices as letters, as `letters` reads them."""
    return "".join("." if index < 0 else chr(ord("a") + index) for index in labels.tolist())


def marks(answers: str, truth: NDArray[np.int64]) -> NDArray[np.float64]:
    """Return (N,) 1 for a right answer, 0 for a wrong one, NaN for none."""
    said = letters(answers)
    return np.where(said < 0, np.nan, said == truth)
