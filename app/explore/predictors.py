"""What predicts the set: the loaded heads, and a method that is fitted on the source."""

import json
from collections.abc import Sequence
from typing import TYPE_CHECKING, Any

from app.shared.resources import Resources
from app.shared.state import Question, Reply, one_of
from app.shared.tables import tables

if TYPE_CHECKING:
    import numpy as np

    from omnivat.data.store import Embeddings

    Array = np.ndarray[Any, Any]

METHODS = {row["id"]: row["title"] for row in tables()["methods"]}  # fast to fit


def heads(resources: Resources) -> list[Reply]:
    """Return name, structure and source of each head, from settings.json; nothing heavy is
    loaded.
    """
    found = []
    for name, folder in resources.folders.items():
        try:
            record = json.loads((folder / "settings.json").read_text(encoding="utf-8"))
            settings, provenance = record["head"], record["provenance"]
            facts = {
                **{fact: settings[fact] for fact in ("generation", "mffa")},
                "source": str(provenance.get("source", "")),
            }
        except (OSError, ValueError, KeyError, TypeError):
            facts = {"problem": f"'{folder.name}' is not a head; load another one."}
        found.append({"name": name, "folder": folder.name, **facts})
    return found


def predictions(resources: Resources, question: Question) -> Reply:
    """Return the predictions of a comparison method, fitted on the head's source, for every pair.

    question  {"method": a name of METHODS}
    return    label, prediction (N,) as indices into `classes`, confidence (N,) 0 to 255, and
              `accuracy`, as `scores_of` has it

    Raises DataError for another method, or a set without the head's source domain.
    """
    method = one_of("method", question.get("method"), METHODS)
    return resources.results.once(method, lambda: _fitted(resources, method))


def _fitted(resources: Resources, method: str) -> Reply:
    import torch

    from omnivat.data.arrays import copied
    from omnivat.kit.tables import load
    from omnivat.study.baselines import BASELINES
    from omnivat.study.protocol.fitting import source_arrays
    from omnivat.study.protocol.settings import task as task_of

    embeddings, source = resources.embeddings(), resources.head().source
    task = task_of(embeddings, source)
    fitted = load(BASELINES, method, kind="baseline")(source_arrays(task, None, 0))
    vis, tac = (torch.from_numpy(copied(a)) for a in (embeddings.vis, embeddings.tac))
    with torch.inference_mode():
        confidence, predicted = fitted.predict(vis, tac)["fused"].max(1)
    return {
        "label": METHODS[method],
        "classes": list(task.classes),
        "prediction": predicted.tolist(),
        "confidence": (255 * confidence).round().int().tolist(),
        "accuracy": scores_of(embeddings, task.classes, source, predicted.numpy()),
    }


def scores_of(
    embeddings: "Embeddings", classes: Sequence[str], source: str, predicted: "Array"
) -> dict[str, float | None]:
    """Return the accuracy of predictions (N,) in each domain, and "unseen", the mean over unseen
    domains.

    Pairs of other classes than `classes` are left out, and training pairs from "unseen". None if no
    pair remains.
    """
    import numpy as np

    from omnivat.head.predict_set import label_map
    from omnivat.measure.shares import counted, mean_over_domains, record

    label = label_map(list(classes), embeddings.header.classes)[embeddings.label]
    known, names = label >= 0, embeddings.header.domains
    right = np.where(known, predicted == label, np.nan)
    unseen = mean_over_domains(right, embeddings, source, known & counted(embeddings, source))
    shares = record(right[None], embeddings.domain, names)["domains"]
    return {"unseen": unseen, **dict.fromkeys(names), **shares}
