"""Write heads and encoders as ONNX files, for a page that computes in its visitor's browser.

The head is the fast one as it stands, with folded weights; p is an input of the transform.
"""

from copy import deepcopy
from dataclasses import replace
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from omnivat.encoders.onnx_runtime import translate
from omnivat.head.checkpoint import Head
from omnivat.head.dtg import grow
from omnivat.head.output import READINGS
from omnivat.head.ridge import PENALTY, SHARPNESS
from omnivat.head.teach import FOLDS
from omnivat.head.transform import transform
from omnivat.kit.files import replacing
from omnivat.kit.stages import IMAGES, STAGES

INPUTS = (*IMAGES, "orders")
STAGED = STAGES[1:]  # all but the raw embedding


class PortableHead(nn.Module):
    """A head's predictions of B pairs, each at orders of its own, as a graph of tensors alone.

    vis, tac  (B, input_width) raw embeddings
    orders    (2, B) float64: the order of VIS and of TAC, quarter turns
    return    by name: p_READING, class probabilities (B, K); of each modality, as vis_…, the moduli
              of the transform (B, D), the row for teaching (B, input_width), attention (B, Q, T)
              and F-hat with the other image absent (B, D), and as …_vis STAGED (B, D) or (B, 2D),
              Re before Im; if the head has a tree, of the pair, of VIS alone and of TAC alone
              nodes (B, N, D) and their probabilities (B, N, K), "shares"
    """

    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model: Any = model

    def forward(self, vis: Tensor, tac: Tensor, orders: Tensor) -> dict[str, Tensor]:
        head, raw = self.model, {"vis": vis, "tac": tac}
        embedding = head.embedded(raw)  # (2, B, D)
        parts = transform(embedding, orders)  # (2, 2, B, D)
        out = head.output(IMAGES, parts, embedding, nodes=True, attention=True)
        out = replace(out, maps=head.map_logits(raw), lessons=head.lessons(raw))
        found = {f"p_{name}": out.reading(name) for name in READINGS}
        trees = {"": out.nodes}
        for name in IMAGES:
            found[f"{name}_size"] = torch.linalg.vector_norm(out.frft[name], dim=0)
            found[f"{name}_standing"] = head.standing(name, raw[name])
            for stage in STAGED:
                rows = getattr(out, stage)[name]
                found[f"{stage}_{name}"] = rows.movedim(-2, 0).flatten(1)
            bar = out.f_bar[name]
            tree = grow(head.dtg, head.settings, bar[None], bar)
            trees[f"{name}_"] = tree and tree.nodes
            found[f"{name}_f_hat"] = bar
            if tree and head.settings.tree_at_inference:
                found[f"{name}_f_hat"] = bar + tree.nodes.mean(1)
        found |= {f"{name}_attention": weights for name, weights in out.attention.items()}
        for of, nodes in trees.items():
            if nodes is not None:
                found |= {f"{of}nodes": nodes, f"{of}shares": head.classify(nodes).softmax(-1)}
        return found


def write_head(file: Path, head: Head) -> None:
    """Write a head as one ONNX file; inputs and outputs are those of `PortableHead`.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    model = PortableHead(deepcopy(head.model).float())
    rows = torch.rand(2, 3, head.settings.input_width)
    example = *rows, torch.rand(2, 3, dtype=torch.float64)
    with torch.no_grad():  # folded weights and V become constants of the graph
        model.model(*example[:2])
        names = list(model(*example))
    many = torch.export.Dim("pairs", min=2, max=4096)
    with replacing(file) as whole:
        translate(
            model,
            example,
            whole,
            input_names=INPUTS,
            output_names=names,
            dynamic_shapes=({0: many}, {0: many}, {1: many}),
        )


def lessons(
    fused: Tensor,
    vis: Tensor,
    tac: Tensor,
    vis_rows: Tensor,
    tac_rows: Tensor,
    there: Tensor,
    targets: Tensor,
) -> tuple[Tensor, ...]:
    """Return what L lessons teach a head, each an object of its own: `omnivat.head.teach` as a
    graph of tensors.

    fused, vis, tac     (L, known) the head's predictions from both images and from one alone
    vis_rows, tac_rows  (L, W) standardised images; those of a missing one do not count
    there               (L, 2) which images a lesson has
    targets             (L, K) one-hot labels
    return              W (K, 2 W), b (K,) and t of the taught head, all times their sharpness; t;
                        the class (L,) of each lesson by the head as it is, and by what the other
                        folds teach
    """
    image = torch.where(there[:, :1] > 0, vis, tac)
    shown = torch.where(there.prod(1, keepdim=True) > 0, fused, image).double()
    # a class that the head lacks has probability 0
    known, wanted = (torch.arange(x.shape[1]) for x in (shown, targets))
    before = shown @ (known[:, None] == wanted).double()
    rows = torch.cat((vis_rows * there[:, :1], tac_rows * there[:, 1:]), dim=1)
    return solved(rows.double(), targets.double(), before)


def solved(rows: Tensor, targets: Tensor, before: Tensor) -> tuple[Tensor, ...]:
    """Return `lessons` of rows (L, V) and the head's predictions (L, K): `omnivat.head.ridge` and
    the folds of `omnivat.head.teach`. The inverse is found by Newton's iteration.
    """
    labels = targets.argmax(1)
    alike = labels[:, None] == labels
    counts, places = alike.sum(1), alike.int().tril(-1).sum(1)
    fold = places * counts.max().clamp(max=FOLDS) // counts
    parts = torch.arange(FOLDS)[:, None] != fold
    teach = torch.cat((torch.ones_like(parts[:1]), parts)).double()  # (1 + FOLDS, L)
    products = rows @ rows.T + 1
    rest = torch.diag_embed(1 + (PENALTY - 1) * teach)  # a lesson that does not teach has 1
    inverse = inverted(products * teach[:, :, None] * teach[:, None] + rest)
    solutions = inverse @ (torch.stack((targets, before))[:, None] * teach[..., None])
    errors = solutions / inverse.diagonal(dim1=-2, dim2=-1)[..., None]
    size = errors[1].square().sum((1, 2))
    one = size / teach.sum(1)
    share = (((errors[0] * errors[1]).sum((1, 2)) + one) / (size + one)).clamp(0, 1)
    weights = solutions[0] - share[:, None, None] * solutions[1]  # (1 + FOLDS, L, K)
    scores = share[:, None, None] * before + products @ weights
    after = scores.argmax(-1)[1:].gather(0, fold[None])[0]
    apart = targets - errors[0, 0] + share[0] * errors[1, 0]
    factor = sharpness_of(apart, targets)
    taught = factor * weights[0]
    maps = (taught.T @ rows).float(), taught.sum(0).float(), (factor * share[0]).float()
    return *maps, share[0], before.argmax(1), after


def inverted(matrices: Tensor) -> Tensor:
    """Return the inverses of positive definite matrices (B, L, L)."""
    unit = torch.eye(matrices.shape[-1], dtype=matrices.dtype)
    inverse = unit / matrices.abs().sum(-1).amax(-1)[:, None, None]
    for _ in range(24):  # the error is squared each time: enough for conditions up to 1e5
        inverse = 2 * inverse - inverse @ matrices @ inverse
    return inverse


def sharpness_of(scores: Tensor, targets: Tensor) -> Tensor:
    """Return `omnivat.head.ridge.sharpness` of scores (L, K), labels one-hot."""
    low: Tensor | float
    high: Tensor | float
    (low, high), own = SHARPNESS, (targets * scores).sum(1)
    for _ in range(10):  # the slope of the loss rises with the factor
        factors = low + (high - low) * torch.arange(17).double() / 16
        mean = ((factors[:, None, None] * scores).softmax(-1) * scores).sum(-1)  # (17, L)
        slopes = (mean - own).sum(1) + (mean - scores.mean(1)).mean(1)
        above = (slopes < 0).sum().clamp(1, 16)
        low, high = factors[above - 1], factors[above]
    return torch.as_tensor(high)
