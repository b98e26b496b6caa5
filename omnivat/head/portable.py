"""Write heads as ONNX files, for a page that computes in its visitor's browser.

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
              of the transform (B, D), attention (B, Q, T) and F-hat with the other image absent
              (B, D), and as …_vis STAGED (B, D) or (B, 2D), Re before Im; if the head has a tree,
              of the pair, of VIS alone and of TAC alone nodes (B, N, D) and their probabilities
              (B, N, K), "shares"
    """

    def __init__(self, model: nn.Module) -> None:
        super().__init__()
        self.model: Any = model

    def forward(self, vis: Tensor, tac: Tensor, orders: Tensor) -> dict[str, Tensor]:
        """Return the outputs by name (see the class) for embeddings (B, W) and orders (2, B)."""
        head, raw = self.model, {"vis": vis, "tac": tac}
        embedding = head.embedded(raw)  # (2, B, D)
        parts = transform(embedding, orders)  # (2, 2, B, D)
        out = head.output(IMAGES, parts, embedding, nodes=True, attention=True)
        out = replace(out, maps=head.map_logits(raw), lessons=head.lessons(raw))
        found = {f"p_{name}": out.reading(name) for name in READINGS}
        trees = {"": out.nodes}
        for name in IMAGES:
            found[f"{name}_size"] = torch.linalg.vector_norm(out.frft[name], dim=0)
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
