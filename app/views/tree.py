"""Tree: the nodes that DTG grows from the chosen pair, and what NOD keeps apart."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.components import component
from app.resources import Resources
from app.state import order_from
from app.asking import embedded, refs_from, rounded

if TYPE_CHECKING:
    from torch import Tensor

TITLE = "Tree"


def answer(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tree of one pair at one order.

    question  {"vis": reference or None, "tac": reference or None, "order": p or None}
    return    nodes in heap order (parent of i is (i-1)//2): norm, probabilities, cosine to each
              class direction; `layers`: the cosine matrix of each level and its NOD loss
    """
    import torch

    refs = refs_from(question)
    order = order_from(question.get("order"))
    pair = embedded(resources, refs)
    head = resources.head()
    order = head.model.order if order is None else order
    with torch.inference_mode():
        out = head.model(pair["vis"], pair["tac"], order=order, nodes=True)
        nodes = out.nodes[0]
        logits = head.model.classify(nodes)
        return {
            "classes": list(head.settings.classes),
            "order": order,
            "levels": head.settings.levels,
            "nodes": node_records(nodes, logits),
            "layers": layer_records(nodes, head.settings.levels),
            "f_bar_norms": {name: round(float(f.norm()), 5) for name, f in out.f_bar.items()},
            "in_use": head.settings.tree_at_inference,
        }


def node_records(nodes: "Tensor", logits: "Tensor") -> list[dict[str, Any]]:
    """Return what the page shows of each node: nodes (N, D), logits (N, K)."""
    probabilities = rounded(logits.softmax(-1).numpy())
    return [
        {"norm": round(float(node.norm()), 5), "probabilities": p}
        for node, p in zip(nodes, probabilities, strict=True)
    ]


def layer_records(nodes: "Tensor", levels: int) -> list[dict[str, Any]]:
    """Return each level's cosine matrix and its distance to the identity, which NOD minimises.

    nodes  (2^levels - 1, D) in heap order: level r holds the 2^r nodes from 2^r - 1
    """
    import torch
    from torch.nn.functional import normalize

    records = []
    for level in range(levels):
        layer = normalize(nodes[2**level - 1 : 2 ** (level + 1) - 1], dim=-1)
        cosines = layer @ layer.T
        distance = float(torch.linalg.norm(cosines - torch.eye(len(cosines))))
        records.append({"cosines": rounded(cosines.numpy()), "nod": round(distance, 5)})
    return records


def build() -> None:
    """Lay the tab out."""
    component("tree")
