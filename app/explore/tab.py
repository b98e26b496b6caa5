"""Explore: the whole set on a map that follows p."""

from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.shared.map_place import kept_features
from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of, order_from
from app.shared.tables import tables
from omnivat.data.packing import packed
from omnivat.head.heads import kept_ladder
from omnivat.kit.errors import DataError
from omnivat.kit.stages import STOPS
from omnivat.measure.rungs import NOTHING, RUNGS, known_of

if TYPE_CHECKING:
    import numpy as np

    Array = np.ndarray[Any, Any]

TITLE = "Explore"
NEIGHBOURS = 6
TOLD = ("rung", "known", "source", "accuracy", "low", "high", "pairs", "draws")
STEPS = 10_000  # of a share or a cosine: four digits


def neighbours(resources: Resources, question: Question) -> Reply:
    """Return the points nearest to one point by cosine, in full width, not on the map.

    question  {"point": 0..2N-1 (VIS first, then TAC), "stage": …, "order": p}
    return    {"neighbours": [{"point", "cosine"}, …]}; the point's own pair may be among them
    """
    from omnivat.maps.sweep import STAGES

    embeddings = resources.embeddings()
    stage, point = one_of("stage", question.get("stage"), STAGES), question.get("point")
    if type(point) is not int or not 0 <= point < 2 * len(embeddings):
        raise DataError(f"No point has the number {point!r:.20}; choose one on the map.")
    order = order_from(question.get("order"))
    return {"neighbours": nearest(kept_features(resources, stage, order), point)}


def nearest(features: "Array", point: int) -> list[Reply]:
    """Return the NEIGHBOURS rows of `features` (2N, D), of unit length, with the largest cosine
    to another one.
    """
    import numpy as np

    cosines = features @ features[point]
    cosines[point] = -np.inf
    best = np.argsort(-cosines, kind="stable")[: min(NEIGHBOURS, len(cosines) - 1)]
    return [{"point": int(i), "cosine": round(float(cosines[i]), 4)} for i in best]


def unseen(resources: Resources) -> Reply:
    """Return the record of `omnivat.measure.unseen` for the first head: its accuracy in unseen
    domains.

    The values of each pair are packed as base64: JSON numbers would need five times as many bytes.
    """
    from omnivat.measure.unseen import unseen_summary

    def made() -> Reply:
        found = unseen_summary(resources.head(), resources.embeddings())
        known, width = found["pairs"], "u1" if len(found["classes"]) <= 256 else "u2"
        pairs = {
            "counts": packed(known["counts"], "u1"),
            "answers": {name: packed(labels, width) for name, labels in known["answers"].items()},
            "confidence": packed(known["confidence"], "u2", STEPS),
            "cosine": packed(known["cosine"], "i2", STEPS),
        }
        return {**found, "pairs": pairs}

    return resources.results.once("unseen", made)


def ladder(resources: Resources) -> Reply:
    """Return the ladder of the head, as `omnivat.measure.ladder` has it: that in the file next to
    the set, if it has every rung.
    """

    def climbed() -> Reply:
        from omnivat.measure.ladder import ladder

        where, rungs = resources.where, {row["id"] for row in RUNGS if known_of(row)}
        kept = None if resources.drawn() else kept_ladder(where.head, where.embeddings)
        if kept and {row["rung"] for row in kept["rungs"]} >= rungs:
            return kept
        return ladder(resources.head(), resources.embeddings())

    return resources.results.once("ladder", climbed)


def known(resources: Resources, question: Question) -> Reply:
    """Return what the head reads right at home, or in other domains by what is known of them.

    question  {"known": the id of a rung that has a bar}
    return    the record of `omnivat.measure.known.measured`, with "domains" as shares by name

    Pairs without labels are at most half of the smallest domain.
    Raises DataError with the reason if that cannot be measured on this set.
    """
    from omnivat.measure.known import at_home, few, measured

    rows = {row["id"]: row for row in RUNGS if "bar" in row}
    what = one_of("known", question.get("known"), rows)
    head, embeddings = resources.head(), resources.embeddings()
    step, home = known_of(rows[what]) or NOTHING, rows[what].get("home", False)
    if step.pairs:
        step = few(embeddings, head.source, most=step.pairs)

    def made() -> Reply:
        record = measured(head, embeddings, step)
        record = at_home(record) if home else record
        if record["accuracy"] is None:
            where = f"of '{head.source}', which needs a split" if home else "of any other domain"
            some = ", ".join(head.settings.classes[:5])
            more = " …" * (len(head.settings.classes) > 5)
            raise DataError(
                f"No test pair {where} is of a class that the head learned: {some}{more}."
            )
        shares = {
            domain["domain"]: domain["scores"]["fused"]["accuracy"]
            for domain in record["domains"]
            if domain["scores"] and (home or not domain["is_source"])
        }
        return {**{name: record[name] for name in TOLD}, "domains": shares}

    return resources.results.once(f"known {what}", made)


def pairs(resources: Resources) -> dict[str, list[str]]:
    """Return the name of each pair, the classes it imitates, and the columns that colour points,
    in the order of the set.
    """
    rows = resources.embeddings().rows
    names = [Path(file).stem.removesuffix("_vis") for file in rows["vis"]]
    columns = [row["column"] for row in tables()["colours"] if row.get("column") in rows]
    return {"name": names} | {name: rows[name] for name in ("looks_like", "feels_like", *columns)}


def mechanism(resources: Resources) -> Reply:
    """Return the toy for the transform and the ReLU, which is the same for every set."""
    from omnivat.fractional.toy import toy

    return resources.results.once("toy", lambda: toy(STOPS))
