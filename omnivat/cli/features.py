"""Shared by `gaps` and `project`: the features of a set at one stage and one order."""

import argparse
import sys
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnivat.cli.arguments import add_embeddings, add_head, add_order
from omnivat.cli.computing import add_device
from omnivat.errors import SettingsError
from omnivat.stages import STAGES

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.checkpoint import Head
    from omnivat.data.store import Embeddings

LARGE = 50_000  # from this many pairs on, the cost is printed first
COPIES = 2  # of the features that are held at once


@dataclass(frozen=True, slots=True, kw_only=True)
class StageFeatures:
    """Unit points (2N, W), VIS then TAC, and their origin; no order at "raw"."""

    embeddings: "Embeddings"
    points: "Tensor"
    order: float | None

    @property
    def rows(self) -> "dict[str, Tensor]":
        """Rows of VIS and TAC, (N, W) each."""
        vis, tac = self.points.chunk(2)
        return {"vis": vis, "tac": tac}

    @property
    def about(self) -> str:
        """One line: number of pairs, order, simulated or not."""
        order = "no order" if self.order is None else f"p = {self.order:.4g}"
        simulated = ", simulated data" if self.embeddings.header.simulated else ""
        return f"{len(self.embeddings)} pairs, {order}{simulated}"


def add_stage(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that select features."""
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
        help="use N random pairs; default: all",
    )


def size_warning(pairs: int, width: int) -> str:
    """Return the approximate memory for a large set; "" for a small one.

    Features of a stage are held once, and as much again while they are measured; the two stages of
    the transform are twice as wide, for Re and Im.
    """
    if pairs <= LARGE:
        return ""
    memory = COPIES * 2 * 4 * pairs * width / 1e9
    return (
        f"{pairs:,} pairs of width {width}: about {memory:.1f} GB and some minutes (docs/scale.md has "
        "the times of one machine); --sample 20000 takes a random part"
    )


def stage_features(options: argparse.Namespace, *, by_domain: bool = False) -> StageFeatures:
    """Load head and set and compute one stage; "raw" needs no head.

    by_domain  put the points in the order of their domains, so that a domain's lie together
    """
    import numpy as np
    import torch

    from omnivat.data.store import load_embeddings

    if options.sample < 0:
        raise SettingsError(f"--sample is {options.sample}; give a number of pairs, or 0 for all.")
    embeddings = load_embeddings(options.embeddings).sampled(options.sample)
    if warning := size_warning(len(embeddings), embeddings.width):
        print(warning, file=sys.stderr, flush=True)
    place = np.arange(len(embeddings))
    if by_domain:
        place[np.argsort(embeddings.domain, kind="stable")] = np.arange(len(embeddings))
    head, order = None, None
    if options.stage != "raw":
        from omnivat.checkpoint import load_head

        head = load_head(options.head)
        head.require_embeddings(embeddings)
        order = head.model.order if options.order is None else options.order
    points = _points(head, embeddings, order, options.stage, torch.from_numpy(place))
    return StageFeatures(embeddings=embeddings, points=points, order=order)


def _points(
    head: "Head | None",
    embeddings: "Embeddings",
    order: float | None,
    stage: str,
    place: "Tensor",
) -> "Tensor":
    """Return unit rows (2N, W): VIS, then TAC, in the given order."""
    import torch

    from omnivat.devices import current
    from omnivat.gaps.unit import unit
    from omnivat.sweep.walk import stage_blocks

    count, points = len(embeddings), torch.empty(0, 0)
    for rows, found in stage_blocks(head.model if head else None, embeddings, order, stage):
        for k, name in enumerate(("vis", "tac")):
            if not len(points):
                points = torch.empty(2 * count, found[name].shape[1], device=current())
            points[k * count + place[rows]] = unit(found[name]).to(points)
    return points
