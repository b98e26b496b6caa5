"""UMAP by umap-learn, as a reference: slow to start, so it loads on first use."""

import torch
from torch import Tensor

from omnivat.kit.tables import need
from omnivat.maps.projection import pca
from omnivat.maps.projection.torch_umap import NEIGHBOURS


def project(points: Tensor, *, seed: int = 0, dimensions: int = 2) -> Tensor:
    """Return umap-learn's map of points (N, D) -> (N, dimensions), with its defaults and one
    thread.

    The same seed gives the same map. The first call in a process compiles for 10 s or more;
    `omnivat.maps.projection.torch_umap` gives maps of the same trustworthiness without compiling.
    Raises MissingPackageError if umap-learn is not installed.
    """
    if len(points) < dimensions + 2:
        return pca.project(points, dimensions=dimensions)
    umap = need("umap", purpose="the umap-learn projection", install="umap-learn")
    k = min(NEIGHBOURS, len(points) - 1)
    model = umap.UMAP(n_neighbors=k, n_components=dimensions, random_state=seed % 2**32, n_jobs=1)
    flat = model.fit_transform(points.detach().cpu().numpy())
    return torch.as_tensor(flat, dtype=points.dtype, device=points.device)
