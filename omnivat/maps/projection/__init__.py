"""Maps of features in two or three dimensions: one method in each file, listed here by name.

Each entry is project(points (N, D), *, seed=0, dimensions=2) -> (N, dimensions) in the precision of
the points.
"""

PROJECTIONS = {
    "pca": "omnivat.maps.projection.pca:project",
    "umap": "omnivat.maps.projection.torch_umap:project",
    "umap-learn": "omnivat.maps.projection.umap:project",
}
