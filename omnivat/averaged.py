"""Predictions averaged over several orders, for a head trained with drawn orders."""

from collections.abc import Sequence

import torch
from torch import Tensor

from omnivat.data.store import Embeddings
from omnivat.errors import SettingsError
from omnivat.evaluate import predicted_probabilities
from omnivat.model.head import OmniVaT
from omnivat.orders import checked_order


def averaged_probabilities(
    model: OmniVaT,
    embeddings: Embeddings,
    orders: Sequence[float],
    *,
    modalities: Sequence[str] = ("vis", "tac"),
) -> dict[str, Tensor]:
    """Return class probabilities (N, K) by reading, each the mean over `orders`.

    orders  quarter turns; the cost grows with their number. A head of one fixed p predicts near
            chance away from it, so averaging serves heads trained with `order_draw`

    Raises SettingsError for no order or one out of range, DataError if there are no pairs.
    """
    if not orders:
        raise SettingsError("There are no orders to average over; give one or more.")
    each = [
        predicted_probabilities(
            model, embeddings, order=checked_order(order), modalities=modalities
        )
        for order in orders
    ]
    return {name: torch.stack([one[name] for one in each]).mean(0) for name in each[0]}
