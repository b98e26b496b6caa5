"""Make figures/*.svg: a small still picture of every kind of figure. Look at each before it is
committed.

Run from the repository's root: python -m tests.golden.make_figures
"""

from dataclasses import replace
from pathlib import Path

import numpy as np

from omnivat import figures
from omnivat.maps.frames.records import FrameSet, quantised

FOLDER = Path(__file__).with_name("figures")


def frames():
    """Three pairs of two domains at five orders, with some stages of every curve."""
    rows = np.arange(12.0).reshape(6, 2)
    last = [0.9, 0.7, 0.35, 0.5, 0.8]
    return FrameSet(
        orders=(0.0, 0.25, 0.5, 0.75, 1.0),
        domains=("TAG", "HCT"),
        classes=("wood", "steel", "glass", "felt"),
        domain=np.array([0, 0, 1], np.uint8),
        label=np.array([0, 1, 2], np.uint8),
        prediction=np.array([[0, 1, 0], [0, 1, 1], [0, 1, 2], [3, 1, 2], [0, 0, 2]], np.uint8),
        confidence=np.full((5, 3), 120, np.uint8),
        maps={
            "pca/raw": quantised([rows], (0,), (None,)),
            "pca/f_hat": quantised([rows, rows**2], (0, 4), (None, None)),
        },
        curves={
            "modality_gap/raw": [1.2] * 5,
            "modality_gap/f_hat": last,
            "domain_gap/relu": [0.2, 0.3, None, 0.4, 0.3],
            "domain_gap/f_hat": [v / 3 for v in last],
            "margin/f_bar": [0.02, 0.03, 0.05, 0.04, 0.01],
            "margin/f_hat": [0.05, 0.06, None, 0.07, 0.02],
            "accuracy/unseen": [0.4, 0.5, 0.65, 0.6, 0.3],
        },
        head={"kind": "moved", "learned_order": 0.35, "fits": [0.3, 0.6], "source": "TAG"},
        embeddings={"simulated": True},
    )


def retrained():
    """The same frames with a head for each order, of several trainings, without a domain gap."""
    known = frames()
    curves = {k: v for k, v in known.curves.items() if not k.startswith("domain_gap")}
    shares = [0.45, 0.5, 0.6, 0.55, 0.5]
    for end, by in (("mean", 0.0), ("low", -0.1), ("high", 0.05)):
        curves[f"seeds:accuracy/unseen/{end}"] = [share + by for share in shares]
    return replace(known, curves=curves, head={"kind": "retrained"}, embeddings={})


def share(value):
    return {"share": value, "low": value - 0.08, "high": value + 0.05}


def apart(a, b):
    return {"Digit": {"Digit": 0.0, "GelSight": a}, "GelSight": {"Digit": b, "GelSight": 0.0}}


FIGURES = {
    "lines": lambda: figures.lines(
        {
            f"series {k} & its <long> name, of 7": (
                range(5),
                [3 * k, None, 3 * k + 1, 3 * k - 2, 3 * k],
                [0.5, 0.5, float("nan"), 0.0, 0.75],
            )
            for k in range(7)
        },
        title="Seven series <&>",
        across="step & time",
        up="loss",
        ticks=[f"a long name of place {k}" for k in range(5)],
        caption="A caption of many words that takes more than one line. " * 3,
    ),
    "map": lambda: figures.map_figure(
        [[1, 2], [3, 5], [2, 9], [4, 4], [1.5, 3], [3.5, 5], [2.5, 8], [4, 5]],
        [0, 1, 2, 0],
        ["wood", "<steel>", "glass"],
        title="Four pairs",
        caption="The axes have no unit",
    ),
    "curves": lambda: figures.gap_curves(frames()),
    "retrained": lambda: figures.gap_curves(retrained(), order=0.7, name="a name of its own"),
    "staircase": lambda: figures.staircase(retrained()),
    "domains": lambda: figures.strangers(
        {
            "domains": [
                {"name": "TAG", "is_source": True, "pairs": 40, "answers/fused": share(0.9)},
                {"name": "HCT", "answers/fused": share(0.5), "answers/tac": share(0.3)},
            ],
            "unseen": {
                "answers/fused": share(0.55),
                "answers/vis": {"share": 0.4},
                "answers/tac": share(0.25),
            },
            "chance": 0.2,
            "source": "TAG",
        }
    ),
    "differences": lambda: figures.dots(
        [
            {"row": "with", "value": -0.5, "low": -1.0, "high": 0.2},
            {"row": "without", "value": 1.5, "low": 1.25, "high": 2.0},
        ],
        title="A row of dots below and above nothing",
        across="difference",
        level=1.0,
    ),
    "gaps": lambda: figures.gap_tables(
        {
            "measure": "centroid",
            "stage": "raw",
            "pairs": 8,
            "simulated": True,
            "modality_gap": {"all": 0.5},
            "floor": {"vis": 0.1, "tac": None},
            "domain_gap": {"vis": apart(0.4, 0.1), "tac": apart(0.3, 0.2)},
        }
    ),
    "ladder": lambda: figures.ladder(
        [
            {"method": method, "known": known, "n": n, "accuracy": accuracy}
            | ({"low": accuracy - 0.1, "high": accuracy + 0.05} if n else {})
            for method, accuracies in (("ERM", (0.5, 0.6)), ("linear <maps>", (0.45, 0.7)))
            for (known, n), accuracy in zip(
                (("nothing", 0), ("a profile", 20)), accuracies, strict=True
            )
        ]
    ),
}


if __name__ == "__main__":
    for name, build in FIGURES.items():
        figures.write(FOLDER / f"{name}.svg", build())
