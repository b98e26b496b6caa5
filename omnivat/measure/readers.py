"""What can be measured: a head, linear maps, or any method that learned one domain, as one kind."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
import torch
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.profile import Profile
from omnivat.head import teach
from omnivat.head.checkpoint import Head
from omnivat.head.linear_maps import FittedMaps
from omnivat.head.teach import Lesson
from omnivat.kit.stages import IMAGES
from omnivat.measure.predictions import inputs_of, label_map, predicted

Rows = NDArray[np.int64]
Raw = Mapping[str, Tensor]  # embeddings (n, W) by modality


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """What is measured: a head, linear maps, or any method that learned one domain.

    classes     that it tells apart
    source      the domain that it learned; "": none of the set
    readings    raw embeddings -> class probabilities (n, K) by reading; "fused" is of all images
    profile     returns the profile of its training pairs, onto which a target is moved
    taught      labelled pairs -> a reader that they taught
    learned     a set and names of domains -> a reader that learned their training pairs
    modalities  the images that it is given, on `device`
    """

    classes: tuple[str, ...]
    source: str
    readings: Callable[[Raw], Mapping[str, Tensor]]
    profile: Callable[[], Profile]
    taught: Callable[[Sequence[Lesson]], "Reader"] | None = None
    learned: Callable[[Embeddings, Sequence[str]], "Reader"] | None = None
    modalities: tuple[str, ...] = IMAGES
    device: torch.device | None = None

    def probabilities(self, embeddings: Embeddings, rows: Rows) -> dict[str, Tensor]:
        """Return class probabilities (n, K) of some pairs by reading."""
        return predicted(
            self.readings, embeddings, modalities=self.modalities, rows=rows, device=self.device
        )

    def answers(
        self, embeddings: Embeddings, rows: Rows, classes: Sequence[str]
    ) -> dict[str, Rows]:
        """Return the predicted class (n,) of some pairs among `classes`, by reading."""
        place = label_map(classes, self.classes)
        shares = self.probabilities(embeddings, rows) if len(rows) else {}
        return {name: place[values.argmax(-1).numpy()] for name, values in shares.items()}


def of_head(head: Head, *, order: float | None = None) -> Reader:
    """Return a head as it reads at an order, in quarter turns; None: the learned one."""
    return Reader(
        classes=head.settings.classes,
        source=head.source,
        readings=lambda raw: head.model(raw.get("vis"), raw.get("tac"), order=order).readings,
        profile=lambda: head.source_profile,
        taught=lambda lessons: of_head(teach.taught(head, lessons), order=order),
        modalities=inputs_of(head),
        device=head.model.classifier.device,
    )


def of_maps(
    fitted: FittedMaps, header: Header, *, source: str, classes: tuple[str, ...] = ()
) -> Reader:
    """Return linear maps that learned pairs of a set. classes  of the maps; (): all of the set"""
    profile = Profile(channels=dict(fitted.profile), key=header.key, domain=source)
    return Reader(
        classes=classes or header.classes,
        source=source,
        readings=fitted,
        profile=lambda: profile,
        modalities=tuple(profile.channels),
    )
