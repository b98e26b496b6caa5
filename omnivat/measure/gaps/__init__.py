"""Measures of distance between sets of features: one measure in each file, listed here by name.

Each entry of `GAPS` compares two sets of unit rows, (N, D) and (M, D), and returns a scalar. A new
gap needs only an entry here: `omnivat gaps`, `omnivat sweep` and the page read this table.
`omnivat.kit.tables.load` imports a measure on first use.
"""

GAPS = {
    "centroid": "omnivat.measure.gaps.centroid:centroid_gap",
    "mmd_linear": "omnivat.measure.gaps.mmd:mmd_linear",
    "mmd_rbf": "omnivat.measure.gaps.mmd:mmd_rbf",
    "frechet": "omnivat.measure.gaps.frechet:frechet",
    "proxy_a": "omnivat.measure.gaps.proxy_a:proxy_a",
}
NAMES = {
    "centroid": "distance of centroids",
    "mmd_linear": "MMD, linear kernel (biased)",
    "mmd_rbf": "MMD, Gaussian kernel (biased)",
    "frechet": "Fréchet distance",
    "proxy_a": "Proxy-A distance",
}
