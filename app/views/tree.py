"""Tree: the nodes that DTG grows from the chosen pair, and what NOD keeps apart."""

from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any

from app.asking import embedded, refs_from, rounded
from app.components import component
from app.resources import Resources
from app.state import order_from

if TYPE_CHECKING:
    from torch import Tensor

TITLE = "Tree"


def answer(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tree of one pair at one order.

    question  {"vis": reference or None, "tac": reference or None, "order": p or None}
    return    nodes with their parents (-1 for none), norms and class probabilities; `layers`:
              the cosine matrix of each group of nodes and its NOD loss
    """
    import torch

    refs = refs_from(question)
    order = order_from(question.get("order"))
    pair = embedded(resources, refs)
    head = resources.head()
    order = head.model.order if order is None else order
    with torch.inference_mode():
        nodes = head.model(pair["vis"], pair["tac"], order=order, nodes=True).nodes[0]
        logits = head.model.classify(nodes)
        return {
            "classes": list(head.settings.classes),
            "order": order,
            "learned": head.model.order,
            "arrangement": head.settings.generation,
            "in_use": head.settings.tree_at_inference,
            "parents": parents(head.settings.generation, len(nodes)),
            "nodes": node_records(nodes, logits),
            "layers": layer_records(nodes, groups(head.settings.generation, len(nodes))),
        }


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


def node_records(nodes: "Tensor", logits: "Tensor") -> list[dict[str, Any]]:
    """Return what the page shows of each node: nodes (N, D), logits (N, K)."""
    probabilities = rounded(logits.softmax(-1).numpy())
    return [
        {"norm": round(float(node.norm()), 5), "probabilities": p}
        for node, p in zip(nodes, probabilities, strict=True)
    ]


def layer_records(nodes: "Tensor", groups: Sequence[range]) -> list[dict[str, Any]]:
    """Return each group's cosine matrix and its distance to the identity, which NOD minimises.

    nodes  (N, D)
    """
    import torch
    from torch.nn.functional import normalize

    records = []
    for group in groups:
        layer = normalize(nodes[group.start : group.stop], dim=-1)
        cosines = layer @ layer.T
        distance = float(torch.linalg.norm(cosines - torch.eye(len(cosines))))
        records.append(
            {
                "nodes": list(group),
                "cosines": rounded(cosines.numpy()),
                "nod": round(distance, 5),
            }
        )
    return records


def build() -> None:
    """Lay the tab out."""
    component("tree")
