"""What can be measured: a head, linear maps, or any method that learned one domain, as one kind."""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np
from numpy.typing import NDArray
from torch import Tensor

from omnivat.data.embeddings import Embeddings, Header
from omnivat.data.profile import Profile
from omnivat.head import teach
from omnivat.head.checkpoint import Head
from omnivat.head.linear_maps import FittedMaps
from omnivat.head.predict_set import inputs_of, label_map, predicted, predicted_probabilities
from omnivat.head.teach import Lesson

Rows = NDArray[np.int64]


@dataclass(frozen=True, slots=True, kw_only=True)
class Reader:
    """What is measured: a head, linear maps, or any method that learned one domain.

    classes     that it tells apart
    source      the domain that it learned; "": none of the set
    predict     a set, rows=(n,) of its pairs -> class probabilities (n, K) by reading; "fused" is
                of all images
    profile     returns the profile of its training pairs, onto which a target is moved
    taught      labelled pairs -> a reader that they taught
    learned     a set and names of domains -> a reader that learned their training pairs
    """

    classes: tuple[str, ...]
    source: str
    predict: Callable[..., Mapping[str, Tensor]]
    profile: Callable[[], Profile]
    taught: Callable[[Sequence[Lesson]], "Reader"] | None = None
    learned: Callable[[Embeddings, Sequence[str]], "Reader"] | None = None

    def answers(
        self, embeddings: Embeddings, rows: Rows, classes: Sequence[str]
    ) -> dict[str, Rows]:
        """Return the predicted class (n,) of some pairs among `classes`, by reading."""
        place = label_map(classes, self.classes)
        shares = self.predict(embeddings, rows=rows) if len(rows) else {}
        return {name: place[values.argmax(-1).numpy()] for name, values in shares.items()}


def of_head(head: Head, *, order: float | None = None) -> Reader:
    """Return a head as it reads at an order, in quarter turns; None: the learned one."""
    return Reader(
        classes=head.settings.classes,
        source=head.source,
        predict=partial(
            predicted_probabilities, head.model, order=order, modalities=inputs_of(head)
        ),
        profile=lambda: head.source_profile,
        taught=lambda lessons: of_head(teach.taught(head, lessons), order=order),
    )


def of_maps(
    fitted: FittedMaps, header: Header, *, source: str, classes: tuple[str, ...] = ()
) -> Reader:
    """Return linear maps that learned pairs of a set. classes  of the maps; (): all of the set"""
    profile = Profile(channels=dict(fitted.profile), key=header.key, domain=source)
    return Reader(
        classes=classes or header.classes,
        source=source,
        predict=partial(predicted, fitted, modalities=tuple(profile.channels)),
        profile=lambda: profile,
    )
