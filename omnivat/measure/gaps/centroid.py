"""Distance between the mean directions of two sets of features."""

from jaxtyping import Float
from torch import Tensor

from omnivat.kit.shapes import features, require_shapes, unit


def centroid_gap(a: Float[Tensor, "N D"], b: Float[Tensor, "M D"]) -> Float[Tensor, ""]:
    """Return the distance, 0 to 2, between the mean directions of two sets, paired or not.

    Rows are scaled to unit length first. A unitary map of both sets does not change the gap.
    Raises ShapeError for an empty set or differing widths.

    >>> import torch
    >>> photos, touches = torch.tensor([[1.0, 0.0], [2.0, 0.0]]), torch.tensor([[0.0, 3.0]])
    >>> centroid_gap(photos, touches), centroid_gap(photos, photos)
    (tensor(1.4142), tensor(0.))
    """
    a, b = features(a=a, b=b)
    gap: Tensor = (unit(a).mean(0) - unit(b).mean(0)).norm()
    return gap


def modality_gap(vis: Float[Tensor, "B D"], tac: Float[Tensor, "B D"]) -> Float[Tensor, ""]:
    """Return the distance, 0 to 2, between the mean directions of two modalities of the same
    objects.

    Raises ShapeError if the two differ in shape.
    Source: Liang et al., "Mind the gap", NeurIPS 2022 (the distance of centroids).

    >>> import torch
    >>> touches = torch.tensor([[0.0, 1.0], [0.0, 5.0]])
    >>> modality_gap(-touches, touches)
    tensor(2.)
    """
    vis, tac = features(vis=vis, tac=tac)
    require_shapes(vis=(vis, "B D"), tac=(tac, "B D"))
    return centroid_gap(vis, tac)
