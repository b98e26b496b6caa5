"""Tree: the nodes that DTG grows from the chosen pair, and what NOD keeps apart."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from app.asking import embedded, refs_from, rounded
from app.components import component
from app.resources import Resources
from app.state import order_from
from omnivat.errors import DataError

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.checkpoint import Head

TITLE = "Tree"


def answer(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tree of one pair, or the mean over a domain's pairs, at one order.

    question  {"vis", "tac": references, or "domain": name; "order": p or None,
              "head": name of a comparison head, the first one if left out}
    return    nodes with their parents (-1 for none), norms and class probabilities; `layers`:
              the cosine matrix of each group of nodes and its NOD loss; `pairs`: how many pairs
              were averaged over

    Raises DataError when nothing is chosen or the head grows no nodes.
    """
    import torch

    order = order_from(question.get("order"))
    head = resources.head_named(question.get("head"))
    pair, labels = _pairs(resources, question, head)
    order = head.model.order if order is None else order
    kind = head.settings.generation
    with torch.inference_mode():
        found = head.model(pair["vis"], pair["tac"], order=order, nodes=True).nodes
        if found is None:
            raise DataError("This head generates no nodes: it was trained without DTG.")
        logits = head.model.classify(found)
        return {
            "classes": list(head.settings.classes),
            "order": order,
            "learned": head.model.order,
            "arrangement": kind,
            "in_use": head.settings.tree_at_inference,
            "source": head.source,
            "pairs": len(found),
            "parents": parents(kind, found.shape[1]),
            "nodes": node_records(found, logits, labels),
            "layers": layer_records(found, groups(kind, found.shape[1])),
        }


def _pairs(
    resources: Resources, question: Mapping[str, Any], head: "Head"
) -> "tuple[dict[str, Tensor | None], Tensor | None]":
    """Return the embeddings asked for, and for a domain the index of each pair's class."""
    domain = question.get("domain")
    if not domain:
        return embedded(resources, refs_from(question)), None
    import torch

    from omnivat.evaluate import label_map

    embeddings = resources.embeddings()
    head.require_embeddings(embeddings)
    some = embeddings.in_domain(str(domain)[:200])
    if not len(some):
        raise DataError(f"The domain '{domain:.80}' has no pairs here.")
    labels = label_map(head.settings.classes, embeddings.header.classes)[some.label]
    chosen: dict[str, Tensor | None] = {
        "vis": torch.from_numpy(some.vis.copy()),
        "tac": torch.from_numpy(some.tac.copy()),
    }
    return chosen, torch.as_tensor(labels)


def parents(arrangement: str, count: int) -> list[int]:
    """Return the node that each of `count` nodes grows from; -1 for none."""
    if arrangement == "tree":
        return [-1, *((node - 1) // 2 for node in range(1, count))]
    if arrangement == "series":
        return list(range(-1, count - 1))
    if arrangement == "parallel":
        return [-1, *([0] * (count - 1))]
    return [-1] * count  # points between VIS and TAC grow from nothing


def groups(arrangement: str, count: int) -> list[range]:
    """Return the groups of nodes that NOD keeps apart: in a tree its layers."""
    if arrangement == "tree":
        levels = (count + 1).bit_length() - 1
        return [range(2**level - 1, 2 ** (level + 1) - 1) for level in range(levels)]
    if arrangement == "parallel":
        return [range(1), range(1, count)]
    return [range(count)]


def node_records(
    nodes: "Tensor", logits: "Tensor", labels: "Tensor | None"
) -> list[dict[str, Any]]:
    """Return what the page shows of each node, means over pairs.

    nodes (B, N, D), logits (B, N, K), labels (B,) or None where classes are not known
    """
    norms, probabilities = nodes.norm(dim=-1).mean(0), logits.softmax(-1)
    means = rounded(probabilities.mean(0).numpy())
    records: list[dict[str, Any]] = [
        {"norm": round(float(norm), 5), "probabilities": p}
        for norm, p in zip(norms, means, strict=True)
    ]
    if labels is not None:
        right = (probabilities.argmax(-1) == labels[:, None]).double().mean(0)
        for record, share in zip(records, right, strict=True):
            record["right"] = round(float(share), 5)
    return records


def layer_records(nodes: "Tensor", groups: Sequence[range]) -> list[dict[str, Any]]:
    """Return each group's cosine matrix and its distance to the identity, which NOD minimises.

    nodes  (B, N, D); matrix and distance are means over the B pairs
    """
    import torch
    from torch.nn.functional import normalize

    records = []
    for group in groups:
        layer = normalize(nodes[:, group.start : group.stop], dim=-1)
        cosines = layer @ layer.mT
        distance = torch.linalg.matrix_norm(cosines - torch.eye(len(group))).mean()
        records.append(
            {
                "nodes": list(group),
                "cosines": rounded(cosines.mean(0).numpy()),
                "nod": round(float(distance), 5),
            }
        )
    return records


def build() -> None:
    """Lay the tab out."""
    component("tree")
