"""A training step of the head with every setting, plain and slow: the oracle of the fast one."""

import torch
from torch.nn.functional import cross_entropy, normalize

from omnivat.head import plain
from omnivat.head.dtg import groups
from omnivat.head.output import TrainingOutput


def training_pass(head, images, lang, labels, *, lang_on, token_on, order=None):
    """Run a batch in training: LANG guides VIS and TAC, Eq. 5 and 6; see
    `OmniVaT.training_pass`.
    """
    settings, own = head.settings, head.mffa
    same = (labels[:, None] == labels[None]).to(head.dtype)  # (B, B)
    means = {}

    def run(name, embedding, guide=None):
        def token(mean):
            means[name] = mean
            of_class = same / same.sum(1, keepdim=True) @ mean  # (B, D)
            return torch.where(token_on[:, None], of_class, own.class_agnostic_tokens([name]))

        return plain.mffa(
            head, name, embedding, order, guide=guide, guided=lang_on, token=token
        ).f_bar

    on, guide = lang_on[:, None], None
    inputs = {name: plain.embedded(head, name, raw) for name, raw in images.items()}  # (B, D)
    text = None if lang is None else run("lang", plain.embedded(head, "lang", lang))
    if text is not None and settings.mffa:
        guide = text * (head.length if settings.guide_length == "embedding" else 1.0)
        if settings.guide != "query":
            inputs = {name: x + guide * on for name, x in inputs.items()}
    query = None if settings.guide == "added" else guide
    found = {name: run(name, x, query) for name, x in inputs.items()}
    root = torch.stack(list(found.values())).sum(0) + (0.0 if text is None else text * on)
    nodes = plain.tree(head, list(found.values()), root)
    mean = 0.0 if nodes is None else nodes.mean(1)
    levels = [root[:, None]]  # (B, n, D) each
    if nodes is not None and settings.edges:
        kind = groups(head.dtg.arrangement, nodes.shape[1])
        kind = [range(1), *kind] if len(kind) == 1 else kind  # NOD leaves out the first
        levels = [nodes[:, group.start : group.stop] for group in kind]
    logits = {name: head.classify(x + mean) for name, x in found.items()}
    named = {} if text is None or not settings.mffa else {"lang": text}
    return TrainingOutput(features={**named, **found}, layers=levels, logits=logits, tokens=means)


def joint_loss(output, labels, *, mma=10.0):
    """Return λ MMA + NOD + cross-entropy of a batch. Eq. 9 to 12."""
    total = torch.stack([cross_entropy(x, labels) for x in output.logits.values()]).mean()
    logs = {name: torch.log_softmax(x, dim=-1) for name, x in output.features.items()}  # (B, D)
    for name in logs.keys() & {"vis", "tac"} if "lang" in logs else ():
        total = total + mma * (logs["lang"].exp() * (logs["lang"] - logs[name])).sum(-1).mean()
    for nodes in output.layers[1:]:  # (B, n, D)
        units = normalize(nodes, dim=-1)
        excess = units @ units.mT - torch.eye(nodes.shape[1], dtype=nodes.dtype)  # (B, n, n)
        total = total + torch.linalg.matrix_norm(excess).mean()
    return total
