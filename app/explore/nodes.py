"""The nodes that DTG grows from a pair, and their cosines."""

from app.shared.pair_input import pair_request, rounded, thinned
from app.shared.resources import Resources
from app.shared.state import Question, Reply
from omnivat.kit.errors import DataError

# pairs that count; a larger set is thinned evenly, with an error of about a point
MOST_PAIRS = 5000


def tree(resources: Resources, question: Question) -> Reply:
    """Return the tree of one pair at one order.

    question  {"vis", "tac": references; "order": p or None; "head": name of a comparison head, the
              first one if left out}
    return    nodes with their parents (-1 for none), norms and class probabilities; `layers`: the
              cosine matrix of each group of nodes

    Raises DataError if nothing is chosen or the head has no nodes.
    """
    import torch

    from omnivat.maps.nodes import tree_facts

    named = pair_request(resources, question)
    head, pair = named.head, named.pair
    order = head.model.order if named.order is None else named.order
    with torch.inference_mode():
        nodes = head.model(pair["vis"], pair["tac"], order=order, nodes=True).nodes
        if nodes is None:
            raise DataError("This head generates no nodes: it was trained without DTG.")
        facts = tree_facts(head.model, nodes)
    norms = [round(length, 5) for length in facts.lengths.tolist()]
    return {
        "classes": list(head.settings.classes),
        "order": order,
        "learned": head.model.order,
        "arrangement": head.settings.generation,
        "in_use": head.settings.tree_at_inference,
        "parents": facts.parents,
        "nodes": [
            {"norm": norm, "probabilities": row}
            for norm, row in zip(norms, rounded(facts.probabilities.numpy()), strict=True)
        ],
        "layers": [
            {"nodes": list(group), "cosines": rounded(cosines.numpy())}
            for group, cosines in facts.levels
        ],
    }


def votes(resources: Resources, question: Question) -> Reply:
    """Return the class that each node of the tree predicts most often over the set, at the
    learned p.

    question  {"head": name of the head, the first one if left out}
    return    {"votes": [{"class", "share"}, …], "pairs": number of pairs}; a share is in [0, 1]
    """
    from omnivat.maps.nodes import node_votes

    name = question.get("head") or ""
    head, embeddings = resources.head_named(name), resources.embeddings()

    def counted() -> Reply:
        some = embeddings.select(thinned(len(embeddings), MOST_PAIRS))
        votes = [
            {"class": label, "share": round(share, 4)} for label, share in node_votes(head, some)
        ]
        return {"votes": votes, "pairs": len(some)}

    return resources.results.once(f"votes {name}", counted)
