"""Measures of how far sets of features lie apart: one measure a file, listed here by name.

`GAPS` compares two sets, (N, D) and (M, D); `MARGINS` and `SCORES` also need labels or answers.
Nothing is imported before `omnivat.tables.load` asks for it.
"""

GAPS = {
    "centroid": "omnivat.gaps.centroid:centroid_gap",
    "mmd_linear": "omnivat.gaps.mmd:mmd_linear",
    "mmd_rbf": "omnivat.gaps.mmd:mmd_rbf",
    "frechet": "omnivat.gaps.frechet:frechet",
    "proxy_a": "omnivat.gaps.proxy_a:proxy_a",
}

MARGINS = {
    "within": "omnivat.gaps.cosine_margin:cosine_margin",
    "cross_domain": "omnivat.gaps.cosine_margin:cross_domain_margin",
    "cross_modal": "omnivat.gaps.cosine_margin:cross_modal_margin",
}

SCORES = {
    "accuracy": "omnivat.gaps.confusion:accuracy",
    "macro_f1": "omnivat.gaps.confusion:macro_f1",
    "ece": "omnivat.gaps.calibration:ece",
}
