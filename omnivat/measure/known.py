"""One measurement: what is read right in domains that were not met, by what is known of them.

Known pairs are drawn and left out of the test; results are averaged over draws:

    from omnivat.measure.rungs import labels, pairs, sensors

    measured(head, embeddings)                      # nothing is known
    measured(head, embeddings, pairs(5), draws=10)  # five pairs without labels: a profile
    measured(head, embeddings, labels(3))           # three labelled pairs of each class: taught
    measured(reader, embeddings, sensors(4))        # learned from four domains in place of one

A head, or any method as a `Reader`, is measured alike.
"""

from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from statistics import fmean
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.data.profile import profile_of, profiled
from omnivat.head.checkpoint import Head
from omnivat.head.predict_set import label_map
from omnivat.head.teach import Lesson
from omnivat.kit.errors import DataError, printable
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.seeding import derive_seed
from omnivat.kit.stages import IMAGES
from omnivat.measure.gaps.confusion import confusion, scores
from omnivat.measure.readers import Reader, of_head
from omnivat.measure.rungs import DRAWS, FEW, NOTHING, Known, pairs
from omnivat.measure.shares import record

F1 = ("macro_f1", "macro_f1_union")
Array = NDArray[Any]
Rows = NDArray[np.int64]


def drawn(stream: str, seed: int, domain: str, pool: Array) -> Array:
    """Return a domain's pool in the order in which it becomes known: more contain the fewer."""
    mixed: Array = np.random.default_rng(derive_seed(seed, stream, domain)).permutation(pool)
    return mixed


def few(embeddings: Embeddings, source: str, *, most: int = FEW) -> Known:
    """Return `most` pairs of each target without labels, or half of the smallest: the rest is
    tested.

    Raises DataError for a target of one pair.
    """
    targets = [name for name in embeddings.header.domains if name != source]
    sizes = {name: size for name in targets if (size := len(embeddings.rows_of(name)))}
    for name, size in sizes.items():
        if size == 1:
            raise DataError(
                f"'{printable(name)}' has one pair, which cannot be both known and tested; add a"
                " second one."
            )
    return pairs(min([most, *(size // 2 for size in sizes.values())]))


@dataclass(frozen=True, slots=True, kw_only=True)
class Part:
    """The pairs of one domain that are left to predict, after the known ones were drawn."""

    domain: str
    reader: Reader  # which predicts them
    embeddings: Embeddings  # moved by the targets' profiles
    rows: Rows  # (n,) of them
    known_pairs: int = 0  # of the domain, drawn and left out


def parts(
    reader: Reader, embeddings: Embeddings, known: Known = NOTHING, *, seed: int = 0
) -> Iterator[Part]:
    """Draw the known pairs of each target; yield the rest of each domain, test pairs alone.

    The source stays as it is. Raises DataError for a reader that cannot use what is known: without
    its source's profile, or with one source where several are wanted.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> from omnivat.measure.rungs import pairs
    >>> head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    >>> [part.known_pairs for part in parts(of_head(head), embeddings, pairs(5))][:3]
    [0, 5, 5]
    """
    whole = embeddings if known.rested is None else known.rested
    names = whole.header.domains
    some = {name: known_rows(whole, known, name, seed) for name in names if name != reader.source}
    some = {name: rows for name, rows in some.items() if len(rows)}
    near = whole
    if some:
        source = reader.profile()
        kinds = tuple(source.channels)
        profiles = {
            name: profile_of(whole, np.sort(rows), domain=name, modalities=kinds)
            for name, rows in some.items()
        }
        near = profiled(whole, profiles, source)
    for name in names:
        rows, its = some.get(name, np.zeros(0, np.int64)), reader
        if known.labels and len(rows):
            its = _able(reader.taught, "be taught")(_lessons(near, rows))
        if known.sensors > 1 and name != reader.source:
            learned, draw = _able(reader.learned, "learn several domains"), known.draw or drawn
            others = [other for other in names if other not in (reader.source, name)]
            chosen = draw("sensors", seed, name, np.array(others))[: known.sensors - 1]
            its = learned(near, (reader.source, *chosen.tolist()))
        left = np.setdiff1d(near.rows_of(name, split="test"), rows)
        yield Part(domain=name, reader=its, embeddings=near, rows=left, known_pairs=len(rows))


def _able(what: Callable[..., Reader] | None, words: str) -> Callable[..., Reader]:
    if what is None:
        raise DataError(f"What is measured cannot {words}; give a `Reader` that can.")
    return what


def known_rows(embeddings: Embeddings, known: Known, name: str, seed: int) -> Rows:
    """Return the rows of a domain that are known, with labels or without."""
    pool, draw = embeddings.rows_of(name, split="train"), known.draw or drawn
    if not known.labels:
        return draw("unlabelled", seed, name, pool)[: known.pairs] if known.pairs else pool[:0]
    mixed = draw("labelled", seed, name, pool[embeddings.labelled[pool]])
    label = embeddings.label[mixed]
    each = [mixed[label == k][: known.labels] for k in np.unique(label)]
    return np.concatenate([pool[:0], *each])


def _lessons(near: Embeddings, rows: Rows) -> list[Lesson]:
    images = {n: torch.from_numpy(np.array(getattr(near, n)[rows], np.float32)) for n in IMAGES}
    return [
        Lesson(
            label=near.header.classes[near.label[row]],
            object=near.rows["object"][row],
            **{name: values[k : k + 1] for name, values in images.items()},
        )
        for k, row in enumerate(rows)
    ]


def measured(
    head: Head | Reader,
    embeddings: Embeddings,
    known: Known = NOTHING,
    *,
    draws: int = DRAWS,
    seed: int = 0,
    order: float | None = None,
    on_step: OnStep = ignore,
) -> dict[str, Any]:
    """Return what is read right in every domain but the source, as a record.

    known  drawn from each target's training pairs, `draws` times with seeds `seed`, `seed` + 1, ...
    order  of a head, in quarter turns; None: the learned one

    If the data have a split, only the test part counts. Pairs of classes that the head lacks are
    left out and counted. The record:

    rung, known          what is known, as a short name and in words
    source, classes      of the head
    accuracy, low, high  mean over targets of the share of test pairs that both images have right,
                         and its 95 % interval: domains and objects are drawn; None without targets
    pairs, draws         tested pairs of targets; the accuracy of each draw
    scores               by reading: accuracy, low, high, macro_f1 and macro_f1_union
    domains              the same of each domain, the source too, with name ("domain"), "is_source",
                         "trained_on" (the test pairs are those that the head learned), "left_out",
                         "objects", "known_pairs", "lamps_from" (touches that gave the lamps of its
                         relief), "confusion" (K, K) by both images in the first draw

    F1 averages the classes present in the domain; the "union" variant also averages classes that
    were only predicted. Raises DataError for embeddings of another encoder.

    >>> from omnivat import default_embeddings, default_head, load_embeddings, load_head
    >>> from omnivat.measure.rungs import labels, pairs
    >>> head, embeddings = load_head(default_head()), load_embeddings(default_embeddings())
    >>> for known in (NOTHING, pairs(20), labels(3)):
    ...     found = measured(head, embeddings, known, draws=1)
    ...     print(found["known"], found["low"] < found["accuracy"] < found["high"])
    nothing: pictures as they come True
    20 pairs without labels True
    3 labelled pairs of each class True
    >>> home, away = found["domains"][:2]
    >>> home["domain"], home["is_source"], away["domain"], away["known_pairs"]
    ('TAG-sim', True, 'OF Real-sim', 15)
    """
    if isinstance(head, Head):
        head.require_embeddings(embeddings if known.rested is None else known.rested)
        head = of_head(head, order=order)
    names = tuple(dict.fromkeys((*head.classes, *embeddings.header.classes)))
    label = label_map(head.classes, embeddings.header.classes)[embeddings.label]
    label = np.where(embeddings.labelled, label, -1)
    lit, seeds = embeddings.header.lit_by, known.seeds(seed, draws)
    nothing = np.full((len(seeds), len(label)), -1, np.int32)
    said = {"fused": nothing.copy()}  # by reading: (draws, N) predicted class; -1: not tested
    domains: dict[str, dict[str, Any]] = {}
    for k, draw_seed in enumerate(seeds):
        for index, part in enumerate(parts(head, embeddings, known, seed=draw_seed)):
            rows = part.rows[label[part.rows] >= 0]
            if k and part.reader is head and not part.known_pairs:  # as in the first draw
                answers = {name: values[0, rows] for name, values in said.items()}
            else:
                answers = part.reader.answers(part.embeddings, rows, names)
            for name, values in answers.items():
                said.setdefault(name, nothing.copy())[k, rows] = values
            domains.setdefault(part.domain, _facts(part, head.source, len(rows)))
            done = int((embeddings.domain <= index).sum())
            on_step(Step(done=done, total=len(embeddings), text=part.domain))
    count = max([len(head.classes), *(1 + int(values.max()) for values in said.values())])
    objects = embeddings.objects

    def shares(rows: Rows) -> dict[str, dict[str, Any]]:
        """Return `record` of each reading that predicted some of the rows."""
        place = embeddings.domain[rows], embeddings.header.domains, objects[rows]
        right = {n: np.where(v < 0, np.nan, v == label)[:, rows] for n, v in said.items()}
        each = {name: record(some, *place) for name, some in right.items()}
        return {name: found for name, found in each.items() if found["pairs"]}

    for index, found in enumerate(domains.values()):
        rows = np.flatnonzero(embeddings.domain == index)
        each = shares(rows)
        found["draws"] = each["fused"]["draws"] if each else []
        found["scores"] = {
            name: _ends(share) | _f1(label[rows], said[name][:, rows])
            for name, share in each.items()
        }
        made = said["fused"][:, rows] >= 0
        found["objects"] = len(np.unique(objects[rows[made.any(0)]]))
        first = rows[made[0]]
        both = torch.from_numpy(label[first]), torch.from_numpy(said["fused"][0, first])
        found["confusion"] = confusion(*both, count).tolist()
    targets = [domain for domain in domains.values() if not domain["is_source"]]
    away = np.array([not domain["is_source"] for domain in domains.values()], bool)[
        embeddings.domain
    ]
    means = shares(np.flatnonzero(away))
    f1 = {
        name: {
            m: fmean(domain["scores"][name][m] for domain in targets if domain["scores"])
            for m in F1
        }
        for name in means
    }
    return {
        "rung": known.name,
        "known": known.words + (f"; lamps from up to {max(lit.values())} touches" if lit else ""),
        "source": head.source,
        "classes": list(names[:count]),
        **_ends(means.get("fused", {})),
        "pairs": sum(domain["pairs"] for domain in targets),
        "draws": means["fused"]["draws"] if means else [],
        "scores": {name: _ends(share) | f1[name] for name, share in means.items()},
        "domains": list(domains.values()),
    }


def scored(head: Head, embeddings: Embeddings, others: Sequence[Head] = ()) -> Head:
    """Return a trained head with its scores on every domain of a set among its metrics.

    others  heads of other seeds: their scores follow in metrics["seeds"]

    Besides "seeds", the metrics get "order", "target_accuracy", "target_macro_f1" (means over
    targets) and "domains" as in `measured`. Raises DataError for embeddings of another encoder.

    >>> from omnivat import EXAMPLES, load_embeddings, load_head
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> metrics = scored(head, pairs, [head]).metrics
    >>> round(metrics["target_accuracy"], 2), len(metrics["domains"]), len(metrics["seeds"])
    (0.98, 4, 2)
    """
    heads = (head, *others)
    found = [measured(head, embeddings) for head in heads]
    seeds = [_summary(head, record) for head, record in zip(heads, found, strict=True)]
    means = {name: value for name, value in seeds[0].items() if name not in ("seed", "domains")}
    epochs = head.metrics.get("epochs", [])
    metrics = {**means, "domains": found[0]["domains"], "epochs": epochs, "seeds": seeds}
    return replace(head, metrics=metrics | {**head.metrics, **metrics})


def _summary(head: Head, found: Mapping[str, Any]) -> dict[str, Any]:
    """Return the scores of one seed: means over targets, and of each domain."""
    return {
        "seed": head.provenance.get("seed"),
        "order": head.model.order,
        "target_accuracy": found["accuracy"],
        "target_macro_f1": found["scores"].get("fused", {}).get("macro_f1"),
        "domains": {r["domain"]: r["scores"]["fused"] for r in found["domains"] if r["scores"]},
    }


def at_home(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record of `measured` with the source in place of the targets; its "accuracy" is
    None without test pairs that the head has not learned.
    """
    home = [
        domain for domain in found["domains"] if domain["is_source"] and not domain["trained_on"]
    ]
    scores = home[0]["scores"] if home else {}
    return {
        **found,
        **_ends(scores.get("fused", {})),
        "pairs": sum(domain["pairs"] for domain in home),
        "draws": home[0]["draws"] if home else [],
        "scores": scores,
        "domains": home,
    }


def _ends(share: Mapping[str, Any]) -> dict[str, float | None]:
    return {name: share.get(name) for name in ("accuracy", "low", "high")}


def _facts(part: Part, source: str, count: int) -> dict[str, Any]:
    """Return the record of a domain with `count` test pairs."""
    split, home = part.embeddings.rows["split"], part.domain == source
    return {
        "domain": part.domain,
        "is_source": home,
        "trained_on": home and not any(split[row] for row in part.rows),
        "pairs": count,
        "left_out": len(part.rows) - count,
        "known_pairs": part.known_pairs,
        "lamps_from": part.embeddings.header.lit_by.get(part.domain, 0),
    }


def _f1(label: Rows, said: Array) -> dict[str, float]:
    """Return F1, the mean over draws (draws, n)."""
    draws = [
        scores(torch.from_numpy(label[made]), torch.from_numpy(row[made]))
        for row in said
        if (made := row >= 0).any()
    ]
    return {m: fmean(draw[m] for draw in draws) for m in F1}
