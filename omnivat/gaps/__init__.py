"""Measures of how far sets of features lie apart: one measure a file, listed here by name.

Each entry of `GAPS` compares two sets of unit rows, (N, D) and (M, D), and returns a scalar. An entry
here is all that a new gap needs: `omnivat gaps`, `omnivat sweep` and the page list it from here.
`omnivat.tables.load` imports a measure on first use.
"""

GAPS = {
    "centroid": "omnivat.gaps.centroid:centroid_gap",
    "mmd_linear": "omnivat.gaps.mmd:mmd_linear",
    "mmd_rbf": "omnivat.gaps.mmd:mmd_rbf",
    "frechet": "omnivat.gaps.frechet:frechet",
    "proxy_a": "omnivat.gaps.proxy_a:proxy_a",
}
