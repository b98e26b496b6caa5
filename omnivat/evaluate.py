"""How well a head does on sets of embeddings: accuracy and macro-F1 for each domain."""

from collections.abc import Iterator, Sequence
from typing import Any

import numpy as np
import torch
from torch import Tensor

from omnivat.checkpoint import Head
from omnivat.data.store import Embeddings
from omnivat.errors import DataError
from omnivat.gaps.confusion import accuracy, confusion, macro_f1
from omnivat.model.head import OmniVaT

CHUNK = 512  # pairs a forward pass: memory stays bounded for any set


def predicted_probabilities(
    model: OmniVaT,
    embeddings: Embeddings,
    *,
    order: float | None = None,
    modalities: Sequence[str] = ("vis", "tac"),
) -> dict[str, Tensor]:
    """Return class probabilities (N, K): "fused", and each modality on its own.

    order       quarter turns; the learned one where None
    modalities  what the head is given: "vis", "tac" or both

    Raises DataError where there are no pairs.
    """
    batches = list(_batches(model, embeddings, order, modalities))
    if not batches:
        raise DataError("There are no pairs to predict.")
    return {name: torch.cat([batch[name] for batch in batches]) for name in batches[0]}


@torch.inference_mode()
def _batches(
    model: OmniVaT, embeddings: Embeddings, order: float | None, modalities: Sequence[str]
) -> Iterator[dict[str, Tensor]]:
    for start in range(0, len(embeddings), CHUNK):
        rows = slice(start, start + CHUNK)
        given = {
            name: torch.from_numpy(np.array(getattr(embeddings, name)[rows]))
            if name in modalities
            else None
            for name in ("vis", "tac")
        }
        output = model(given["vis"], given["tac"], order=order)
        yield {"fused": output.probabilities, **output.modality_probabilities}


def label_map(head_classes: Sequence[str], data_classes: Sequence[str]) -> np.ndarray[Any, Any]:
    """Return, for each class of the data, its index in the head, or -1 where the head lacks it."""
    return np.array([head_classes.index(c) if c in head_classes else -1 for c in data_classes])


def trained_modalities(head: Head) -> tuple[str, ...]:
    """Return what the head learned from, and is asked with unless told otherwise."""
    return tuple(head.provenance.get("train", {}).get("modalities", "vis+tac").split("+"))


def evaluate(
    head: Head,
    embeddings: Embeddings,
    *,
    order: float | None = None,
    modalities: Sequence[str] | None = None,
) -> list[dict[str, Any]]:
    """Return one record for each domain: counts, ACC and macro-F1, fused and by modality.

    order       quarter turns; the learned one where None
    modalities  what the head is given: "vis", "tac" or both; those it was trained with where None

    Where the data state a split only its test part counts; of a source without one, "trained_on"
    says that it is asked about what it learned from. Pairs of classes that the head has not learned
    are left out and counted. F1 averages the classes present in the domain; the
    "union" variant also averages classes that were only answered.

    Raises DataError when the embeddings are of another encoder.
    """
    head.require_embeddings(embeddings)
    given = trained_modalities(head) if modalities is None else tuple(modalities)
    return [
        _evaluate_domain(head, embeddings.in_domain(name, split="test"), name, order, given)
        for name in embeddings.header.domains
    ]


def _evaluate_domain(
    head: Head,
    pairs: Embeddings,
    domain: str,
    order: float | None,
    modalities: Sequence[str],
) -> dict[str, Any]:
    classes = head.settings.classes
    labels = label_map(classes, pairs.header.classes)[pairs.label]
    known = labels >= 0
    record: dict[str, Any] = {
        "domain": domain,
        "is_source": domain == head.source,
        "trained_on": domain == head.source and not any(pairs.rows["split"]),
        "order": head.model.order if order is None else order,
        "pairs": int(known.sum()),
        "left_out": int((~known).sum()),
    }
    if not known.any():
        return record | {"scores": {}}
    truth = torch.from_numpy(labels[known])
    probabilities = predicted_probabilities(
        head.model, pairs.select(known), order=order, modalities=modalities
    )
    answers = {name: values.argmax(-1) for name, values in probabilities.items()}
    record["scores"] = {name: _scores(truth, answer) for name, answer in answers.items()}
    record["classes"] = list(classes)
    record["confusion"] = confusion(truth, answers["fused"], len(classes)).tolist()
    return record


def _scores(truth: Tensor, answers: Tensor) -> dict[str, float]:
    return {
        "accuracy": float(accuracy(truth, answers)),
        "macro_f1": float(macro_f1(truth, answers)),
        "macro_f1_union": float(macro_f1(truth, answers, average="union")),
    }


def target_mean(records: Sequence[dict[str, Any]], score: str = "accuracy") -> float:
    """Return the unweighted mean of a fused score over the domains that are not the source."""
    values = [r["scores"]["fused"][score] for r in records if not r["is_source"] and r["scores"]]
    return sum(values) / len(values) if values else float("nan")
