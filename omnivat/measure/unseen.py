"""Results of a head in unseen domains: test pairs, 95 % intervals of shares, confusion and
retrieval in one record.
"""

from collections.abc import Sequence
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.measure.gaps.confusion import confusion
from omnivat.measure.gaps.unit import unit
from omnivat.measure.predictions import blocks, label_map, predicted_probabilities

READINGS = ("fused", "vis", "tac")
UNSEEN = "unseen"  # the name of all unseen domains together
Array = NDArray[Any]
BLOCK = 1024  # photos compared at once; bounds the memory
MOST = 2000  # photos of a domain; a larger one is thinned evenly
Mask = NDArray[np.bool_]
Z = 1.959963984540054  # normal quantile of a two-sided 95 % interval
DRAWS = 2000


def wilson(right: float, total: int) -> tuple[float, float]:
    """Return the 95 % interval of a share, after Wilson (1927); it stays within 0 and 1.

    >>> low, high = wilson(60, 100)
    >>> round(low, 3), round(high, 3)
    (0.502, 0.691)
    """
    share, square = right / total, Z * Z / total
    middle = (share + square / 2) / (1 + square)
    half = Z * np.sqrt(share * (1 - share) / total + square / (4 * total)) / (1 + square)
    return float(max(0.0, middle - half)), float(min(1.0, middle + half))


def of_domains(counts: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Return the 95 % interval of the mean share over domains: (right, total) of each.

    Bootstrap: domains are drawn with replacement, then pairs within each. The interval therefore
    covers other domains of this kind, not only other pairs of these domains.
    """
    right, total = (np.array(part, dtype=np.int64) for part in zip(*counts, strict=True))
    random = np.random.default_rng(0)
    drawn = random.integers(len(total), size=(DRAWS, len(total)))
    shares = random.binomial(total[drawn], right[drawn] / total[drawn]) / total[drawn]
    low, high = np.quantile(shares.mean(axis=1), [0.025, 0.975])
    return float(low), float(high)


def interval(counts: Sequence[tuple[int, int]]) -> tuple[float, float]:
    """Return the 95 % interval of the mean share over domains: `wilson` for one, else
    `of_domains`.
    """
    return of_domains(counts) if len(counts) > 1 else wilson(*counts[0])


def share_of(counts: Sequence[tuple[int, int]]) -> dict[str, float] | None:
    """Return the mean over domains of (right, total), and its interval; None without domains."""
    if not counts:
        return None
    low, high = interval(counts)
    return {"share": float(np.mean([r / n for r, n in counts])), "low": low, "high": high}


def counted(embeddings: Embeddings, source: str) -> Mask:
    """Return a mask (N,) of the test pairs of a head trained on `source`.

    If a domain has a split, its test part counts; otherwise all its pairs do. A source without a
    split has no test pairs, because the head may have been trained on all of them.
    """
    split = np.array(embeddings.rows["split"], dtype=object)
    keep = np.zeros(len(embeddings), dtype=bool)
    for index, name in enumerate(embeddings.header.domains):
        own = embeddings.domain == index
        stated = any(split[own])
        keep |= own & (split == "test") if stated else own & (name != source)
    return keep


def mean_over_domains(
    right: NDArray[Any], embeddings: Embeddings, source: str, keep: Mask
) -> float | None:
    """Return the mean over unseen domains of each domain's share of `right` (N,) among `keep`.

    None if the source is not among the domains or no unseen domain has a test pair.
    """
    if source not in embeddings.header.domains:
        return None
    shares = [
        right[own].mean()
        for index, name in enumerate(embeddings.header.domains)
        if name != source and (own := keep & (embeddings.domain == index)).any()
    ]
    return float(np.mean(shares)) if shares else None


def judged(keep: NDArray[np.bool_], domain: NDArray[Any]) -> NDArray[np.int64]:
    """Return the rows for retrieval: at most MOST for each domain, evenly spaced, ascending."""
    chosen = []
    for index in np.unique(domain):
        own = np.flatnonzero(keep & (domain == index))
        even = np.linspace(0, len(own) - 1, min(len(own), MOST)).round().astype(np.int64)
        chosen.append(own[even])
    return np.sort(np.concatenate(chosen))


def nearest_touch(
    vis: Array, tac: Array, domain: NDArray[Any], rows: NDArray[np.int64]
) -> NDArray[np.int64]:
    """Return for each of `rows` the row of the touch with the largest cosine in its domain.

    vis     (len(rows), W), photos of `rows`; tac  (N, W); all of any length. A photo's own touch
            may be the nearest
    domain  (N,)
    """
    found = np.zeros(len(rows), dtype=np.int64)
    for name in np.unique(domain[rows]):
        among = np.flatnonzero(domain == name)
        touches = unit(torch.from_numpy(tac[among]))
        places = np.flatnonzero(domain[rows] == name)
        for part in np.split(places, range(BLOCK, len(places), BLOCK)):
            cosines = unit(torch.from_numpy(vis[part])) @ touches.T
            found[part] = among[cosines.argmax(1).numpy()]
    return found


def unseen_summary(head: Head, embeddings: Embeddings) -> dict[str, Any]:
    """Return the page's record of unseen domains.

    Every share is computed on test pairs, at exactly the learned order. `readings` are "fused"
    (both images), "vis" and "tac" (one image, the other one absent). "pairs" has values of each
    pair as arrays (N,).
    Raises DataError if the embeddings have another encoder or no pairs.

    >>> from omnivat import EXAMPLES, load_embeddings, load_head
    >>> head = load_head(EXAMPLES / "chirps" / "head")
    >>> pairs = load_embeddings(EXAMPLES / "chirps" / "chirps.safetensors")
    >>> summary = unseen_summary(head, pairs)  # `figures.strangers` draws it
    >>> summary["source"], summary["unseen"]["answers/fused"]["share"] > 0.9
    ('Chirps A-sim', True)
    """
    head.require_embeddings(embeddings)
    classes, domain = head.settings.classes, np.asarray(embeddings.domain)
    label = label_map(classes, embeddings.header.classes)[embeddings.label]
    counts = counted(embeddings, head.source) & (label >= 0)
    members = {name: counts & (domain == i) for i, name in enumerate(embeddings.header.domains)}
    away = [mask for name, mask in members.items() if name != head.source]
    unseen = np.any([np.zeros_like(counts), *away], axis=0)
    found = predicted_probabilities(head.model, embeddings)
    probabilities = {name: found[name].double().cpu().numpy() for name in READINGS}
    predicted = {name: values.argmax(1) for name, values in probabilities.items()}
    shares = {f"answers/{name}": (values == label) * 1.0 for name, values in predicted.items()}
    rows = judged(counts, domain)
    vis, tac, cosine = _alone(head, embeddings, rows)
    shares["retrieval"] = np.full(len(label), np.nan)  # of photos that are not tested
    shares["retrieval"][rows] = label[nearest_touch(vis, tac, domain, rows)] == label[rows]
    # unseen pairs that look like another class
    alike = np.array([bool(name) for name in embeddings.rows["looks_like"]], bool) & unseen

    def confusions(values: Array) -> dict[str, list[list[int]]]:
        """Return counts (K, K), true class by predicted class, of each domain and all unseen."""
        truth, guess = torch.from_numpy(label), torch.from_numpy(values)
        masks = {name: torch.from_numpy(m) for name, m in (members | {UNSEEN: unseen}).items()}
        return {n: confusion(truth[m], guess[m], len(classes)).tolist() for n, m in masks.items()}

    return {
        "source": head.source,
        "order": head.model.order,
        "classes": list(classes),
        "chance": 1 / len(classes),
        "domains": [
            {
                "name": name,
                "is_source": name == head.source,
                "pairs": int(mask.sum()),
                **{key: _over(right, mask) for key, right in shares.items()},
            }
            for name, mask in members.items()
        ],
        "unseen": {name: _over(right, *away) for name, right in shares.items()},
        "look_alikes": {
            "pairs": int(alike.sum()),
            **{key: _over(right, alike) for key, right in shares.items()},
        }
        if alike.any()
        else None,
        "confusion": {name: confusions(values) for name, values in predicted.items()},
        "pairs": {
            "counts": counts,
            "answers": predicted,
            "confidence": probabilities["fused"].max(1),
            "cosine": cosine,
        },
    }


def _over(right: Array, *masks: Mask) -> dict[str, float] | None:
    """Return `share_of` the pairs of each mask. NaN values are skipped."""
    parts = [right[mask & ~np.isnan(right)] for mask in masks]
    return share_of([(int(part.sum()), len(part)) for part in parts if len(part)])


@torch.inference_mode()
def _alone(
    head: Head, embeddings: Embeddings, rows: NDArray[np.int64]
) -> tuple[Array, Array, Array]:
    """Return unit F-hat of some photos and of each touch, each seen alone, and cosines (N,) of
    pairs.

    rows  ascending: photos whose F-hat is kept
    """
    vis: list[torch.Tensor] = []
    tac, cosines = torch.empty(0), torch.empty(len(embeddings))
    for place, given in blocks(embeddings, head.model.classifier.device):
        seen = unit(head.model(given["vis"], None).f_hat["vis"]).cpu()
        felt = unit(head.model(None, given["tac"]).f_hat["tac"]).cpu()
        if not len(tac):
            tac = torch.empty(len(embeddings), felt.shape[1])
        tac[place], cosines[place] = felt, (seen * felt).sum(1)
        first, last = np.searchsorted(rows, (place.start, place.stop))
        vis.append(seen[torch.from_numpy(rows[first:last] - place.start)])
    return torch.cat(vis).numpy(), tac.numpy(), cosines.numpy()
