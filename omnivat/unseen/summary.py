"""Results of a head in unseen domains in one record: accuracy, intervals, confusion, retrieval."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.checkpoint import Head
from omnivat.data.arrays import walked
from omnivat.data.embeddings import Embeddings
from omnivat.evaluate import CHUNK, label_map, predicted_probabilities
from omnivat.gaps.unit import unit
from omnivat.unseen.masks import counted, of_domains, wilson

Rows = NDArray[np.floating[Any]]
BLOCK = 1024  # photos compared at once; bounds the memory
MOST = 2000  # photos of a domain; a larger one is thinned evenly


def judged(keep: NDArray[np.bool_], domain: NDArray[Any], most: int = MOST) -> NDArray[np.int64]:
    """Return the rows for retrieval: at most `most` for each domain, evenly spaced, ascending."""
    chosen = []
    for name in np.unique(domain):
        own = np.flatnonzero(keep & (domain == name))
        if len(own) > most:
            own = own[np.linspace(0, len(own) - 1, most).round().astype(np.int64)]
        chosen.append(own)
    return np.sort(np.concatenate(chosen)) if chosen else np.zeros(0, dtype=np.int64)


def nearest_touch(vis: Rows, tac: Rows, domain: NDArray[Any], rows: NDArray[np.int64]) -> NDArray[np.int64]:
    """Return for each of `rows` the row of the touch with the largest cosine in its domain.

    vis     (len(rows), W), photos of `rows`; tac  (N, W); all of any length. A photo's own touch
            may be the nearest
    domain  (N,)
    """
    found = np.zeros(len(rows), dtype=np.int64)
    for name in np.unique(domain[rows]):
        among = np.flatnonzero(domain == name)
        touches = _unit(tac[among])
        places = np.flatnonzero(domain[rows] == name)
        for start in range(0, len(places), BLOCK):
            part = places[start : start + BLOCK]
            found[part] = among[np.argmax(_unit(vis[part]) @ touches.T, axis=1)]
    return found


def _unit(rows: Rows) -> Rows:
    unit: Rows = rows / np.maximum(np.linalg.norm(rows, axis=1, keepdims=True), 1e-12)
    return unit


READINGS = ("fused", "vis", "tac")
Array = NDArray[Any]


@dataclass(frozen=True, slots=True, kw_only=True)
class _Facts:
    """The data of the record, by pair."""

    source: str
    domains: tuple[str, ...]
    domain: Array  # (N,)
    label: Array  # (N,) index among the head's classes, or -1
    counts: Array  # (N,) bool: test pairs of the head's classes

    def members(self) -> list[tuple[str, Array]]:
        """Return each domain, and all unseen ones together, with a mask (N,) of test pairs."""
        found = [(name, self.counts & (self.domain == i)) for i, name in enumerate(self.domains)]
        own = self.domains.index(self.source) if self.source in self.domains else -1
        return [*found, ("unseen", self.counts & (self.domain != own))]

    def unseen(self) -> list[Array]:
        """Return the mask of each unseen domain with pairs."""
        return [mask for name, mask in self.members()[:-1] if name != self.source and mask.any()]


def unseen_summary(head: Head, embeddings: Embeddings) -> dict[str, Any]:
    """Return the page's record; docs/page.md describes its keys.

    Every share is computed on test pairs, at exactly the learned order. `readings` are "fused" (both images), "vis" and
    "tac" (one image, the other one absent). "pairs" has values of each pair as arrays (N,).

    Raises DataError if the embeddings have another encoder or no pairs.
    """
    head.require_embeddings(embeddings)
    classes = head.settings.classes
    label = label_map(classes, embeddings.header.classes)[embeddings.label]
    facts = _Facts(
        source=head.source,
        domains=embeddings.header.domains,
        domain=np.asarray(embeddings.domain),
        label=label,
        counts=counted(embeddings, head.source) & (label >= 0),
    )
    found = predicted_probabilities(head.model, embeddings)
    probabilities = {name: found[name].double().cpu().numpy() for name in READINGS}
    predicted = {name: values.argmax(1) for name, values in probabilities.items()}
    shares = {f"answers/{name}": (values == label) * 1.0 for name, values in predicted.items()}
    rows = judged(facts.counts, facts.domain)
    vis, tac, cosine = _alone(head, embeddings, rows)
    nearest = nearest_touch(vis, tac, facts.domain, rows)
    shares["retrieval"] = np.full(len(label), np.nan)  # 1 if a photo's nearest touch has its class; NaN if not tested
    shares["retrieval"][rows] = label[nearest] == label[rows]
    return {
        "source": head.source,
        "order": head.model.order,
        "classes": list(classes),
        "chance": 1 / len(classes),
        "domains": _by_domain(facts, shares),
        "unseen": {name: _over_domains(facts, right) for name, right in shares.items()},
        "look_alikes": _look_alikes(facts, shares, embeddings.rows.get("looks_like", [])),
        "confusion": {name: _confusions(facts, values, len(classes)) for name, values in predicted.items()},
        "pairs": {
            "counts": facts.counts,
            "answers": predicted,
            "confidence": probabilities["fused"].max(1),
            "cosine": cosine,
        },
    }


def _by_domain(facts: _Facts, shares: Mapping[str, Array]) -> list[dict[str, Any]]:
    return [
        {
            "name": name,
            "is_source": name == facts.source,
            "pairs": int(mask.sum()),
            **{key: _share(right[mask]) for key, right in shares.items()},
        }
        for name, mask in facts.members()[:-1]
    ]


def _share(right: Array) -> dict[str, float] | None:
    """Return a share with its interval, or None without pairs. NaN values are skipped."""
    right = right[~np.isnan(right)]
    if not len(right):
        return None
    low, high = wilson(int(right.sum()), len(right))
    return {"share": float(right.mean()), "low": low, "high": high}


def _over_domains(facts: _Facts, right: Array) -> dict[str, float] | None:
    """Return the mean over unseen domains with its interval, or None without any."""
    known = ~np.isnan(right)
    counts = [(int(right[m & known].sum()), int((m & known).sum())) for m in facts.unseen()]
    if not counts:
        return None
    low, high = of_domains(counts)
    return {"share": float(np.mean([r / n for r, n in counts])), "low": low, "high": high}


def _look_alikes(facts: _Facts, shares: Mapping[str, Array], looks_like: Sequence[str]) -> dict[str, Any] | None:
    """Return the shares of unseen pairs that look like another class, or None without any."""
    alike = np.array([bool(name) for name in looks_like] or [False] * len(facts.domain))
    mask = alike & facts.members()[-1][1]
    if not mask.any():
        return None
    return {"pairs": int(mask.sum()), **{key: _share(right[mask]) for key, right in shares.items()}}


def _confusions(facts: _Facts, predicted: Array, classes: int) -> dict[str, list[list[int]]]:
    """Return counts (K, K), true class by predicted class, of each domain and all unseen ones."""
    found = {}
    for name, mask in facts.members():
        cells = facts.label[mask] * classes + predicted[mask]
        found[name] = np.bincount(cells, minlength=classes**2).reshape(classes, classes).tolist()
    return found


@torch.inference_mode()
def _alone(head: Head, embeddings: Embeddings, rows: NDArray[np.int64]) -> tuple[Array, Array, Array]:
    """Return unit F-hat of some photos and of each touch, each seen alone, and cosines (N,) of pairs.

    rows  ascending: photos whose F-hat is kept
    """
    vis: list[torch.Tensor] = []
    tac, cosines = torch.empty(0), torch.empty(len(embeddings))
    columns = (walked(rows, size=CHUNK) for rows in (embeddings.vis, embeddings.tac))
    device, start = head.model.classifier.device, 0
    for photos, touches in zip(*columns, strict=True):
        seen = head.model(torch.from_numpy(photos).to(device), None).f_hat["vis"]
        felt = head.model(None, torch.from_numpy(touches).to(device)).f_hat["tac"]
        seen, felt = unit(seen).cpu(), unit(felt).cpu()
        if not len(tac):
            tac = torch.empty(len(embeddings), felt.shape[1])
        end = start + len(seen)
        tac[start:end], cosines[start:end] = felt, (seen * felt).sum(1)
        first, last = np.searchsorted(rows, (start, end))
        vis.append(seen[torch.from_numpy(rows[first:last] - start)])
        start = end
    return torch.cat(vis).numpy(), tac.numpy(), cosines.numpy()
