"""The curve of accuracy on unseen domains, one value for each stop."""

from collections.abc import Mapping

from torch import Tensor

from omnivat.data.embeddings import Embeddings
from omnivat.evaluate import label_map
from omnivat.unseen.masks import counted, mean_over_domains

NAMES = {"fused": "accuracy/unseen", "vis": "accuracy:vis/unseen", "tac": "accuracy:tac/unseen"}


class UnseenAccuracy:
    """Mean accuracy over unseen domains, by curve name.

    `omnivat.unseen.counted` chooses the pairs; training pairs never count.
    """

    def __init__(self, embeddings: Embeddings, classes: tuple[str, ...], source: str) -> None:
        self._embeddings, self._source = embeddings, source
        self._label = label_map(classes, embeddings.header.classes)[embeddings.label]
        self._keep = counted(embeddings, source) & (self._label >= 0)

    def at(self, probabilities: Mapping[str, Tensor]) -> dict[str, float | None]:
        """Return curve name -> value at one order; empty if the source is not in the set.

        probabilities  reading -> (N, K) over the head's classes
        """
        if self._source not in self._embeddings.header.domains:
            return {}
        return {
            curve: mean_over_domains(
                probabilities[reading].argmax(1).cpu().numpy() == self._label,
                self._embeddings,
                self._source,
                self._keep,
            )
            for reading, curve in NAMES.items()
            if reading in probabilities
        }
