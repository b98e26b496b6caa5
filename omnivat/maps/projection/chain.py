"""The earlier place of three functions of `omnivat.maps.projection.torch_umap`, for one version."""

from omnivat.maps.projection.torch_umap import aligned as aligned
from omnivat.maps.projection.torch_umap import chain as chain
from omnivat.maps.projection.torch_umap import following as following
