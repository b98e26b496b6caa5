"""Write heads and encoders as ONNX files, for a page that computes in its visitor's browser.

The head is the fast one as it stands, with folded weights; p is an input of the transform.
"""

from collections.abc import Sequence
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
OUTPUTS = (
    *(f"p_{name}" for name in READINGS),
    *(f"{name}_{what}" for name in IMAGES for what in ("size", "standing", "attention")),
)


class _Portable(nn.Module):
    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model: Any = model


class PortableHead(_Portable):
    """A head's prediction of one pair at P orders, as a graph of tensors alone.

    vis, tac  (1, input_width) raw embeddings
    orders    (2, P) float64: the order of VIS and of TAC, quarter turns
    return    OUTPUTS: class probabilities (P, K) of each reading; of each modality the moduli of
              the transform (P, D), the row for teaching (1, input_width) and attention (P, Q, T)
    """

    def forward(self, vis: Tensor, tac: Tensor, orders: Tensor) -> tuple[Tensor, ...]:
        head, raw = self.model, {"vis": vis, "tac": tac}
        embedding = head.embedded(raw)  # (2, 1, D)
        parts = transform(embedding, orders)  # (2, 2, P, D)
        many = embedding.expand(-1, orders.shape[1], -1)
        out = head.output(IMAGES, parts, many, nodes=False, attention=True)
        maps = {n: rows.expand(orders.shape[1], -1) for n, rows in head.map_logits(raw).items()}
        out = replace(out, maps=maps, lessons=head.lessons(raw))
        rest = []
        for name in IMAGES:
            rest += [
                torch.linalg.vector_norm(out.frft[name], dim=0),
                head.standing(name, raw[name]),
            ]
            rest += [out.attention[name] if out.attention else torch.zeros(1)]
        return (*(out.reading(name) for name in READINGS), *rest)


def write_head(file: Path, head: Head) -> None:
    """Write a head as one ONNX file; inputs and outputs are those of `PortableHead`.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    row, orders = torch.ones(1, head.settings.input_width), torch.rand(2, 3, dtype=torch.float64)
    many = torch.export.Dim("stops", min=2, max=4096)
    given = row, row.clone(), orders
    _write(file, head, PortableHead, given, INPUTS, OUTPUTS, (None, None, {1: many}))


def _write(
    file: Path,
    head: Head,
    portable: type[_Portable],
    example: tuple[Tensor, ...],
    inputs: Sequence[str],
    outputs: Sequence[str],
    shapes: tuple[Any, ...],
) -> None:
    model = portable(deepcopy(head.model).float())
    with torch.no_grad():  # folded weights and V become constants of the graph
        model.model(*example[:2])
        model(*example)
    with replacing(file) as whole:
        translate(
            model, example, whole, input_names=inputs, output_names=outputs, dynamic_shapes=shapes
        )


STAGED = STAGES[1:]  # all but the raw embedding


class PortableStages(_Portable):
    """Every stage of B pairs at orders of their own, and the nodes of their trees.

    vis, tac  (B, input_width) raw embeddings
    orders    (B,) float64, quarter turns
    return    STAGED of each modality (B, D) or (B, 2D), Re before Im; then, if the head has a tree,
              of the pair, of VIS alone and of TAC alone: nodes (B, N, D) and their probabilities
              (B, N, K)
    """

    def forward(self, vis: Tensor, tac: Tensor, orders: Tensor) -> tuple[Tensor, ...]:
        head = self.model
        embedding = head.embedded({"vis": vis, "tac": tac})  # (2, B, D)
        parts = transform(embedding, orders)
        out = head.output(IMAGES, parts, embedding, nodes=True, attention=False)
        stages = [getattr(out, stage)[name] for stage in STAGED for name in IMAGES]
        rows = [stage.movedim(-2, 0).flatten(1) for stage in stages]
        alone = [grow(head.dtg, head.settings, bar[None], bar) for bar in out.f_bar.values()]
        trees = [out.nodes, *(tree and tree.nodes for tree in alone)]
        grown = [(nodes, head.classify(nodes).softmax(-1)) for nodes in trees if nodes is not None]
        return (*rows, *(tensor for pair in grown for tensor in pair))


def write_stages(file: Path, head: Head) -> None:
    """Write the stages of a head as one ONNX file: STAGED_vis, STAGED_tac, [vis_|tac_]nodes and
    shares.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    names = [f"{stage}_{name}" for stage in STAGED for name in IMAGES]
    if head.settings.generation != "none":
        names += [f"{of}{what}" for of in ("", "vis_", "tac_") for what in ("nodes", "shares")]
    many, rows = (
        torch.export.Dim("pairs", min=2, max=4096),
        torch.rand(3, head.settings.input_width),
    )
    given = rows, rows.clone(), torch.rand(3, dtype=torch.float64)
    _write(file, head, PortableStages, given, (*IMAGES, "orders"), names, ({0: many},) * 3)


TAUGHT = ("map", "bias", "factor", "share", "after")


class PortableLessons(nn.Module):
    """What lessons teach a head, each an object of its own: `omnivat.head.ridge` and the folds of
    `omnivat.head.teach` as a graph. The inverse is found by Newton's iteration.

    rows    (L, V) float64;  labels  (L,) int64;  before  (L, K) float64: the head's prediction
    return  TAUGHT: W (K, V), b (K,) and t of the taught head, all times their sharpness; t; the
            class (L,) of each lesson by what the other folds teach
    """

    def forward(self, rows: Tensor, labels: Tensor, before: Tensor) -> tuple[Tensor, ...]:
        alike = labels[:, None] == labels
        counts, places = alike.sum(1), alike.int().tril(-1).sum(1)
        fold = places * counts.max().clamp(max=FOLDS) // counts
        parts = torch.arange(FOLDS)[:, None] != fold
        teach = torch.cat((torch.ones_like(parts[:1]), parts)).double()  # (1 + FOLDS, L)
        products = rows @ rows.T + 1
        rest = torch.diag_embed(1 + (PENALTY - 1) * teach)  # a lesson that does not teach has 1
        inverse = inverted(products * teach[:, :, None] * teach[:, None] + rest)
        targets = (labels[:, None] == torch.arange(before.shape[1])).double()
        solved = inverse @ (torch.stack((targets, before))[:, None] * teach[..., None])
        errors = solved / inverse.diagonal(dim1=-2, dim2=-1)[..., None]
        size = errors[1].square().sum((1, 2))
        one = size / teach.sum(1)
        share = (((errors[0] * errors[1]).sum((1, 2)) + one) / (size + one)).clamp(0, 1)
        weights = solved[0] - share[:, None, None] * solved[1]  # (1 + FOLDS, L, K)
        scores = share[:, None, None] * before + products @ weights
        after = scores.argmax(-1)[1:].gather(0, fold[None])[0]
        apart = targets - errors[0, 0] + share[0] * errors[1, 0]
        factor = sharpness_of(apart, targets)
        taught = factor * weights[0]
        return taught.T @ rows, taught.sum(0), factor * share[0], share[0], after


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


def write_lessons(file: Path) -> None:
    """Write teaching as one ONNX file: inputs rows, labels and before, outputs TAUGHT.

    Raises MissingPackageError if a package of ONNX is not installed.
    """
    lessons, classes, width = (torch.export.Dim(name) for name in ("lessons", "classes", "width"))
    example = torch.rand(6, 8).double(), torch.arange(6) % 3, torch.rand(6, 4).double()
    with replacing(file) as whole:
        translate(
            PortableLessons(),
            example,
            whole,
            input_names=("rows", "labels", "before"),
            output_names=TAUGHT,
            dynamic_shapes=({0: lessons, 1: width}, {0: lessons}, {0: lessons, 1: classes}),
        )
