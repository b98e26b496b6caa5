"""The earlier place of three functions of `omnivat.projection.torch_umap`, for one version."""

from omnivat.projection.torch_umap import aligned as aligned
from omnivat.projection.torch_umap import chain as chain
from omnivat.projection.torch_umap import following as following
