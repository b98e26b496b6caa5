"""Distance between the mean directions of two sets of features."""

from torch import Tensor

from omnivat.gaps.unit import require_rows, unit
from omnivat.shapes import require_shapes


def centroid_gap(a: Tensor, b: Tensor) -> Tensor:
    """Distance between the mean directions of two sets.

    a       (N, D) features, any length
    b       (M, D) features; the two sets need not be paired
    return  () in [0, 2]; 0 when the mean directions are the same point

    Rows are scaled to unit length first. A unitary map of both sets does not change the gap.
    Cost O((N + M) D).
    Raises ShapeError for an empty set or differing widths.
    """
    require_shapes(a=(a, "N D"), b=(b, "M D"))
    require_rows(1, a=a, b=b)
    gap: Tensor = (unit(a).mean(0) - unit(b).mean(0)).norm()
    return gap


def modality_gap(vis: Tensor, tac: Tensor) -> Tensor:
    """Distance between the mean directions of two modalities.

    vis     (B, D) visual embeddings, any length
    tac     (B, D) tactile embeddings of the same objects
    return  () in [0, 2]; 0 when the mean directions are the same point

    Raises ShapeError if the two differ in shape.
    Source: Liang et al., "Mind the gap", NeurIPS 2022 (the distance of centroids).
    """
    require_shapes(vis=(vis, "B D"), tac=(tac, "B D"))
    return centroid_gap(vis, tac)
