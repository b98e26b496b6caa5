"""What `gaps` and `project` share: the features of a whole set at one stage and one order."""

import argparse
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnivat.cli.arguments import add_embeddings, add_head, add_order
from omnivat.cli.computing import add_device
from omnivat.errors import SettingsError

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.data.store import Embeddings

STAGES = ("raw", "frft", "relu", "f_bar", "f_hat")
LARGE = 50_000  # pairs from which the cost is told first
SECONDS_A_PAIR = 6e-5  # one stage at one order, measured on two cores at width 512
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
    add_head(parser, note="; not read at stage raw")
    add_embeddings(parser)
    parser.add_argument(
        "--stage",
        choices=STAGES,
        default="f_hat",
        help="raw embedding, raw DFrFT, F after ReLU, after FrATT, after DTG (default)",
    )
    add_order(parser)
    add_device(parser)
    parser.add_argument(
        "--sample",
        type=int,
        default=0,
        metavar="N",
        help="use N pairs drawn at random; all of them if left out",
    )


def size_warning(pairs: int, width: int) -> str:
    """Return how much memory and time a large set will take, roughly; "" for a small one.

    Seven copies of single-precision rows are held at most; a stage costs what `docs/scale.md` has.
    """
    if pairs <= LARGE:
        return ""
    memory, minutes = 7 * 2 * 4 * pairs * width / 1e9, pairs * SECONDS_A_PAIR / 60
    return (
        f"{pairs:,} pairs of width {width}: about {memory:.1f} GB and {max(1, minutes):.0f} min or "
        "more; --sample 20000 takes a random part"
    )


def stage_features(options: argparse.Namespace) -> StageFeatures:
    """Load what the options name and compute that one stage; no head is loaded for "raw"."""
    import numpy as np
    import torch

    from omnivat.data.store import load_embeddings
    from omnivat.devices import current

    if options.sample < 0:
        raise SettingsError(f"--sample is {options.sample}; give a number of pairs, or 0 for all.")
    embeddings = load_embeddings(options.embeddings).sampled(options.sample)
    if told := size_warning(len(embeddings), embeddings.width):
        print(told, file=sys.stderr, flush=True)
    device = current()
    if options.stage == "raw":
        rows = {
            name: torch.from_numpy(np.array(getattr(embeddings, name), dtype=np.float32)).to(device)
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
