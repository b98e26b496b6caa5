"""Results of a head in unseen domains: test pairs, 95 % intervals of shares, confusion and
retrieval in one record.
"""

from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import torch
from numpy.typing import NDArray

from omnivat.data.embeddings import Embeddings
from omnivat.head.checkpoint import Head
from omnivat.head.predict_set import blocks, label_map, predicted_probabilities
from omnivat.measure.gaps.confusion import confusion
from omnivat.measure.gaps.unit import unit
from omnivat.measure.known import measured
from omnivat.measure.readers import of_head
from omnivat.measure.shares import counted, record, shown

READINGS = ("fused", "vis", "tac")
UNSEEN = "unseen"  # the name of all unseen domains together
Array = NDArray[Any]
Mask = NDArray[np.bool_]
BLOCK = 1024  # photos compared at once; bounds the memory
MOST = 2000  # photos of a domain; a larger one is thinned evenly


def retrieval_rows(keep: NDArray[np.bool_], domain: NDArray[Any]) -> NDArray[np.int64]:
    """Return the rows among which retrieval is measured: at most MOST of each domain, evenly spaced
    and ascending.

    keep    (N,) True for test pairs
    domain  (N,) index of the domain
    """
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


def bars(found: Mapping[str, Any]) -> dict[str, Any]:
    """Return a record of `measured` as `omnivat.figures.strangers` takes it: shares by domain, and
    "unseen", their mean over targets.

    The source has no share where its test pairs are those that the head learned.
    """

    def shares(of: Mapping[str, Any]) -> dict[str, Any]:
        return {f"answers/{name}": shown(value) for name, value in of.items() if name in READINGS}

    none = dict.fromkeys(f"answers/{name}" for name in READINGS)
    return {
        "source": found["source"],
        "chance": 1 / len(found["classes"]),
        "domains": [
            {
                "name": domain["domain"],
                "is_source": domain["is_source"],
                "pairs": 0 if domain["trained_on"] else domain["pairs"],
                **none,
                **({} if domain["trained_on"] else shares(domain["scores"])),
            }
            for domain in found["domains"]
        ],
        "unseen": none | shares(found["scores"]),
    }


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
    probabilities = predicted_probabilities(head.model, embeddings)
    reader = replace(
        of_head(head), predict=lambda _, rows: {n: p[rows] for n, p in probabilities.items()}
    )
    found = measured(reader, embeddings)
    classes, domain = found["classes"], embeddings.domain
    label = label_map(classes, embeddings.header.classes)[embeddings.label]
    counts = counted(embeddings, head.source) & (label >= 0)
    unseen = counts & (np.array(embeddings.header.domains)[domain] != head.source)
    # unseen pairs that look like another class
    alike = np.array([bool(name) for name in embeddings.rows["looks_like"]], bool) & unseen
    answers = {name: probabilities[name].argmax(1).numpy() for name in READINGS}
    rows = retrieval_rows(counts, domain)
    vis, tac, cosine = _alone(head, embeddings, rows)
    retrieved = np.full(len(label), np.nan)  # of photos that are not tested
    retrieved[rows] = label[nearest_touch(vis, tac, domain, rows)] == label[rows]

    def share(right: Array, mask: Mask, domain: Array = domain) -> dict[str, Any] | None:
        """Return the share of right values (N,) among a mask; NaN values are skipped."""
        values = np.where(mask, right, np.nan)[None]
        return shown(record(values, domain, embeddings.header.domains, embeddings.objects))

    summary, one_domain = bars(found), np.zeros_like(domain)
    for index, entry in enumerate(summary["domains"]):
        entry["retrieval"] = share(retrieved, domain == index)
    summary["unseen"]["retrieval"] = share(retrieved, unseen)
    masks = {name: counts & (domain == k) for k, name in enumerate(embeddings.header.domains)}
    masks[UNSEEN] = unseen

    def table(said: Array, mask: Mask) -> Any:
        some = torch.from_numpy(label[mask]), torch.from_numpy(said[mask])
        return confusion(*some, len(classes)).tolist()

    return summary | {
        "order": head.model.order,
        "classes": classes,
        "look_alikes": {
            "pairs": int(alike.sum()),
            **{
                f"answers/{name}": share(said == label, alike, one_domain)
                for name, said in answers.items()
            },
            "retrieval": share(retrieved, alike, one_domain),
        }
        if alike.any()
        else None,
        "confusion": {
            name: {place: table(said, mask) for place, mask in masks.items()}
            for name, said in answers.items()
        },
        "pairs": {
            "counts": counts,
            "answers": answers,
            "confidence": probabilities["fused"].max(1).values.double().numpy(),
            "cosine": cosine,
        },
    }


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
