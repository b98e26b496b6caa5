"""What `gaps` and `project` share: the features of a whole set at one stage and one order."""

import argparse
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from omnivat.heads import default_embeddings, default_head

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.data.store import Embeddings

STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
STILL = ("raw", "frft")  # the same at every order


@dataclass(frozen=True, slots=True, kw_only=True)
class StageFeatures:
    """Rows of VIS and TAC, (N, W) each, and where they come from; order is None at "raw"."""

    embeddings: "Embeddings"
    rows: "dict[str, Tensor]"
    order: float | None

    @property
    def about(self) -> str:
        """One line: how many pairs, at which order, simulated or not."""
        order = "no order" if self.order is None else f"p = {self.order:.4g}"
        simulated = ", simulated data" if self.embeddings.header.simulated else ""
        return f"{len(self.embeddings)} pairs, {order}{simulated}"


def add_stage(parser: argparse.ArgumentParser) -> None:
    """Declare which features are meant."""
    parser.add_argument("--head", type=Path, default=default_head(), help="not read at stage raw")
    parser.add_argument("--embeddings", type=Path, default=default_embeddings())
    parser.add_argument(
        "--stage",
        choices=STAGES,
        default="f_hat",
        help="raw embedding, raw DFrFT, F after ReLU, after FrATT, after DTG (default)",
    )
    parser.add_argument(
        "--order", type=float, help="fractional order p; the learned one if left out"
    )


def stage_features(options: argparse.Namespace) -> StageFeatures:
    """Load what the options name and compute that one stage; no head is loaded for "raw"."""
    import numpy as np
    import torch

    from omnivat.data.store import load_embeddings
    from omnivat.predict import checked_order

    checked_order(options.order)
    embeddings = load_embeddings(options.embeddings)
    if options.stage == "raw":
        rows = {
            name: torch.from_numpy(np.array(getattr(embeddings, name), dtype=np.float32))
            for name in ("vis", "tac")
        }
        return StageFeatures(embeddings=embeddings, rows=rows, order=None)
    from omnivat.checkpoint import load_head
    from omnivat.sweep import walk

    head = load_head(options.head)
    head.require_embeddings(embeddings)
    order = head.model.order if options.order is None else options.order
    found = next(iter(walk(head.model, embeddings, [order], stages=[options.stage], answers=False)))
    return StageFeatures(
        embeddings=embeddings, rows=dict(found.features[options.stage]), order=order
    )
