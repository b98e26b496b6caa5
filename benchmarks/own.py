"""What the head for one's own pictures makes of real pairs that no choice has seen.

    python -m benchmarks.own EMBEDDINGS

EMBEDDINGS are those of ObjectFolder Real (`omnivat fetch objectfolder-real`, `omnivat embed`). The
profile is of all its pairs, without labels. Right readings and familiar pictures go into the
record, and the former beside the head, where the page reads them. Odd pictures and the rules of
familiarity in the record are those of 80a5f62.
"""

import argparse
from pathlib import Path
from typing import Any

import numpy as np
import torch

from benchmarks._machine import machine
from omnivat.data.profile import profile_of
from omnivat.data.store import Embeddings, load_embeddings
from omnivat.head import teach
from omnivat.head.calibration import UNLIKE
from omnivat.head.checkpoint import Head, load_head
from omnivat.head.heads import own_head
from omnivat.head.predict_set import label_map, predicted_probabilities
from omnivat.head.teach import Lesson
from omnivat.kit.files import write_json
from omnivat.kit.schema import read_object
from omnivat.kit.stages import IMAGES

OUT = Path("docs/benchmarks/own.json")
READINGS = ("fused", *IMAGES)


def main() -> None:
    """Read the real pairs; write both records."""
    parser = argparse.ArgumentParser(prog="benchmarks.own", description=__doc__)
    parser.add_argument("embeddings", type=Path)
    data, head = load_embeddings(parser.parse_args().embeddings), load_head(own_head())
    real = read(head, data)
    record = {"real": real, "taught": taught(head, data), "familiar": familiar(head, data)}
    write_json(OUT, read_object(OUT) | {"machine": machine(), **record})
    metrics = own_head() / "metrics.json"
    write_json(metrics, read_object(metrics) | {"real": real})


def read(head: Head, data: Embeddings) -> dict[str, Any]:
    """Return the pairs that each reading has right, as they come and with the profile of all."""
    truth = label_map(head.settings.classes, data.header.classes)[data.label]
    near = head.profiled(data, [profile_of(data, domain=data.header.domains[0])])
    record: dict[str, Any] = {"pairs": len(data), "always": int(np.bincount(truth).max())}
    for how, some in (("as they come", data), ("profile", near)):
        shares = predicted_probabilities(head.model, some)
        record[how] = {n: int((shares[n].argmax(-1).numpy() == truth).sum()) for n in READINGS}
    return record


def taught(head: Head, data: Embeddings) -> dict[str, int]:
    """Return the pairs that are right by heads taught without their fold, and without their object
    alone.
    """
    near = head.profiled(data, [profile_of(data, domain=data.header.domains[0])])
    vis, tac = (torch.from_numpy(np.array(getattr(near, name), np.float32)) for name in IMAGES)
    lessons = [
        Lesson(
            label=data.header.classes[label],
            vis=vis[row : row + 1],
            tac=tac[row : row + 1],
            object=data.rows["object"][row],
        )
        for row, label in enumerate(data.label)
    ]
    alone = 0
    for k, lesson in enumerate(lessons):
        other = teach.taught(head, [*lessons[:k], *lessons[k + 1 :]])
        best = int(other.model(lesson.vis, lesson.tac).probabilities.argmax())
        alone += other.settings.classes[best] == lesson.label
    return {"folds": teach.judged(head, lessons).after, "objects": alone}


def familiar(head: Head, data: Embeddings) -> dict[str, int]:
    """Return the pictures of each modality that are called familiar; a profile plays no part."""
    assert head.familiarity
    vis, tac = (torch.from_numpy(np.array(getattr(data, name), np.float32)) for name in IMAGES)
    looks = head.familiarity.look(vis, tac)
    return {name: sum(look[name]["quantile"] >= UNLIKE for look in looks) for name in IMAGES}


if __name__ == "__main__":
    main()
