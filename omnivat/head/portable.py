"""Write heads and encoders as ONNX files, for a page that computes in its visitor's browser.

The head is `plain.py`, exported as it stands: the transform is two real products with cos
and sin of k·p, and p is an input.
"""

from collections.abc import Sequence
from copy import deepcopy
from pathlib import Path
from typing import Any

import torch
from torch import Tensor, nn

from omnivat.encoders.onnx_runtime import translate
from omnivat.head import plain
from omnivat.head.checkpoint import Head
from omnivat.head.output import READINGS, HeadOutput
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
        head = self.model
        raw = {"vis": vis, "tac": tac}
        found = {
            name: plain.mffa(head, name, plain.embedded(head, name, raw[name]), orders[row])
            for row, name in enumerate(IMAGES)
        }
        bars = [one.f_bar.expand(orders.shape[1], -1) for one in found.values()]  # (P, D) each
        hats = [bar + self._mean(bars) for bar in bars]
        alone = [bar + self._mean([bar]) for bar in bars]
        maps = {
            name: rows.expand(orders.shape[1], -1) for name, rows in head.map_logits(raw).items()
        }
        out = HeadOutput(
            logits=dict(zip(IMAGES, map(head.classify, hats), strict=True)),
            alone=dict(zip(IMAGES, map(head.classify, alone), strict=True)),
            pair=head.classify(torch.stack(hats).sum(0)),
            frft={},
            relu={},
            f_bar={},
            f_hat={},
            maps=maps,
            lessons=head.lessons(raw),
            fusion=head.settings.fusion,
            calibration=head.calibration,
        )
        rest = []
        for name, one in found.items():
            rest += [torch.linalg.vector_norm(one.parts, dim=0), head.standing(name, raw[name])]
            rest += [torch.zeros(1) if one.weights is None else one.weights]
        return (*(out.reading(name) for name in READINGS), *rest)

    def _mean(self, bars: list[Tensor]) -> Tensor | float:
        nodes = plain.tree(self.model, bars, torch.stack(bars).sum(0))
        return nodes.mean(1) if nodes is not None and self.model.settings.tree_at_inference else 0.0


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
    model = deepcopy(head.model).float()
    # a constant of the graph
    plain.eigenbasis(head.settings.width, model.dtype, torch.device("cpu"))
    with replacing(file) as whole:
        translate(
            portable(model),
            example,
            whole,
            input_names=inputs,
            output_names=outputs,
            dynamic_shapes=shapes,
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
        out = plain.predict(head, {"vis": vis, "tac": tac}, orders)
        bars = {name: one.f_bar for name, one in out.features.items()}
        stages = {
            "frft": {name: one.parts for name, one in out.features.items()},
            "relu": {name: one.relu for name, one in out.features.items()},
            "f_bar": bars,
            "f_hat": out.f_hat,
        }
        rows = [stages[s][name].movedim(-2, 0).flatten(1) for s in STAGED for name in IMAGES]
        trees = [out.nodes, *(plain.tree(head, [bars[n]], bars[n]) for n in IMAGES)]
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
