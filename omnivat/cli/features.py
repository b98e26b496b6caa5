"""Shared by `gaps` and `project`: the features of a set at one stage and one order."""

import argparse
from collections.abc import Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from omnivat.cli.arguments import HEAD, count, declare, head_and_set, one_of, progress_bar
from omnivat.kit.errors import SettingsError
from omnivat.kit.progress import Step
from omnivat.kit.stages import STAGES

if TYPE_CHECKING:
    from torch import Tensor

    from omnivat.data.store import Embeddings
    from omnivat.head.checkpoint import Head


@dataclass(frozen=True, slots=True, kw_only=True)
class StageFeatures:
    """A set of N pairs and the stage to compute of it; no head and no order at "raw"."""

    embeddings: "Embeddings"
    head: "Head | None"
    order: float | None
    stage: str

    @property
    def about(self) -> str:
        """One line: number of pairs, order, simulated or not."""
        order = "no order" if self.order is None else f"p = {self.order:.4g}"
        simulated = ", simulated data" if self.embeddings.header.simulated else ""
        return f"{len(self.embeddings)} pairs, {order}{simulated}"

    def blocks(self) -> "Iterator[tuple[slice, dict[str, Tensor]]]":
        """Yield unit rows of VIS and TAC, some pairs at a time, with their slice and a bar."""
        from omnivat.maps.sweep.walk import stage_blocks
        from omnivat.measure.gaps.unit import unit

        model, count = self.head.model if self.head else None, len(self.embeddings)
        blocks = stage_blocks(model, self.embeddings, self.order, self.stage)
        with progress_bar(f"features at {self.stage}") as show:
            for rows, found in blocks:
                yield rows, {name: unit(own) for name, own in found.items()}
                show(Step(done=min(rows.stop, count), total=count))

    def points(self) -> "Tensor":
        """Return unit rows (2N, W), VIS then TAC, all in memory."""
        import torch

        from omnivat.kit.devices import current

        count, points = len(self.embeddings), torch.empty(0, 0)
        for rows, found in self.blocks():
            if not len(points):
                points = torch.empty(2 * count, found["vis"].shape[1], device=current())
            for k, name in enumerate(("vis", "tac")):
                points[k * count + rows.start :][: len(found[name])] = found[name].to(points)
        return points


def add_stage(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments that select features."""
    declare(
        parser,
        "embeddings",
        "order",
        "profile",
        "device",
        head=f"{HEAD}; not read at stage raw",
        stage=one_of(
            STAGES, "raw embedding, raw DFrFT, F after ReLU, after FrATT, after DTG", "f_hat"
        ),
        sample=count("use N random pairs, 0: all", 0, default=0, metavar="N"),
    )


def stage_features(options: argparse.Namespace) -> StageFeatures:
    """Load head and set; "raw" needs no head."""
    from omnivat.data.store import load_embeddings

    if options.stage != "raw":
        head, embeddings = head_and_set(options, sample=options.sample)
        order = head.model.order if options.order is None else options.order
        return StageFeatures(embeddings=embeddings, head=head, order=order, stage=options.stage)
    if options.profile:
        raise SettingsError(
            "--profile needs a head, and stage raw uses none; choose another stage."
        )
    embeddings = load_embeddings(options.embeddings).sampled(options.sample)
    return StageFeatures(embeddings=embeddings, head=None, order=None, stage="raw")
