"""Tree: the nodes that DTG grows from the chosen pair, and their cosines."""

from collections.abc import Mapping
from typing import TYPE_CHECKING, Any

from app.pair_input import embedded, refs_from, rounded
from app.resources import Resources
from app.state import order_from
from app.training_plan import thinned
from omnivat.kit.errors import DataError

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.head.checkpoint import Head
    from omnivat.maps.nodes import TreeFacts

TITLE = "Tree"
MOST_PAIRS = 5000  # pairs that count; a larger set is thinned evenly, with an error of about a point


def tree(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return the tree of one pair, or the mean over a domain's pairs, at one order.

    question  {"vis", "tac": references, or "domain": name; "order": p or None,
              "head": name of a comparison head, the first one if left out}
    return    nodes with their parents (-1 for none), norms, class probabilities and, for a domain, the share
              that is `right`; `layers`: the cosine matrix of each group of nodes, and its distance from the
              identity, which NOD minimises; `pairs`: the number of averaged pairs

    Raises DataError if nothing is chosen or the head has no nodes.
    """
    import torch

    from omnivat.maps.nodes import tree_facts

    order = order_from(question.get("order"))
    head = resources.head_named(question.get("head"))
    pair, labels = _pairs(resources, question, head)
    order = head.model.order if order is None else order
    with torch.inference_mode():
        found = head.model(pair["vis"], pair["tac"], order=order, nodes=True).nodes
        if found is None:
            raise DataError("This head generates no nodes: it was trained without DTG.")
        facts = tree_facts(head.model, found, labels)
    return {
        "classes": list(head.settings.classes),
        "order": order,
        "learned": head.model.order,
        "arrangement": head.settings.generation,
        "in_use": head.settings.tree_at_inference,
        "source": head.source,
        "pairs": len(found),
        "parents": facts.parents,
        "nodes": node_records(facts),
        "layers": [
            {"nodes": list(level.nodes), "cosines": rounded(level.cosines.numpy()), "nod": round(level.nod, 5)}
            for level in facts.levels
        ],
    }


def votes(resources: Resources, question: Mapping[str, Any]) -> dict[str, Any]:
    """Return each node's most frequent class over the set, at the learned p.

    return  {"votes": [{"class", "share"}, …], "pairs": number of pairs}
    """
    from omnivat.maps.nodes import node_votes

    name = question.get("head") or ""
    head, embeddings = resources.head_named(name), resources.embeddings()

    def counted() -> dict[str, Any]:
        few = len(embeddings) <= MOST_PAIRS
        some = embeddings if few else embeddings.select(thinned(len(embeddings), MOST_PAIRS))
        votes = [{"class": one.label, "share": round(one.share, 4)} for one in node_votes(head, some)]
        return {"votes": votes, "pairs": len(some)}

    return resources.results.once(f"votes {name}", counted)


def _pairs(
    resources: Resources, question: Mapping[str, Any], head: "Head"
) -> "tuple[dict[str, Tensor | None], Tensor | None]":
    """Return the requested embeddings and, for a domain, the class index of each pair."""
    domain = question.get("domain")
    if not domain:
        return embedded(resources, refs_from(question), question), None
    import torch

    from omnivat.measure.evaluate import label_map

    embeddings = resources.embeddings()
    head.require_embeddings(embeddings)
    some = embeddings.in_domain(str(domain)[:200])
    if not len(some):
        raise DataError(f"The domain '{domain:.80}' has no pairs here.")
    labels = label_map(head.settings.classes, embeddings.header.classes)[some.label]
    return {n: torch.from_numpy(getattr(some, n).copy()) for n in ("vis", "tac")}, torch.as_tensor(labels)


def node_records(facts: "TreeFacts") -> list[dict[str, Any]]:
    """Return the page's data for each node."""
    columns: dict[str, list[Any]] = {
        "norm": [round(length, 5) for length in facts.lengths.tolist()],
        "probabilities": rounded(facts.probabilities.numpy()),
    }
    if facts.right is not None:
        columns["right"] = [round(share, 5) if share == share else None for share in facts.right.tolist()]
    return [dict(zip(columns, values, strict=True)) for values in zip(*columns.values(), strict=True)]
