"""What a gel costs by touch, by how touch is read."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np

from benchmarks.readings import cost, right

GELS = ("TAG-sim", "OF Real-sim")


def test_gels_whose_relief_alone_is_alike_cost_everything_in_colours_and_nothing_by_relief(
    make_embeddings,
):
    random = np.random.default_rng(0)
    some = make_embeddings(domains=GELS, per_class=12)
    label = np.tile(np.arange(len(some.header.classes)), 12)

    def rows(hot):
        return (np.eye(some.width)[hot] + 0.01 * random.random((*hot.shape, some.width))).astype(
            "f4"
        )

    lit = np.broadcast_to(rows(label), (2, 3, len(label), some.width))
    made = SimpleNamespace(
        header=some.header,
        filled=rows(np.stack([label, label + 1], 1)),  # the second gel shows another class
        label=label,
        place=GELS.index,
    )
    bare = replace(some, tac_flip=None, vis_flip=None)
    learning = {
        "colours": replace(bare, tac=rows(some.label + some.domain)),
        "relief": replace(bare, tac=rows(some.label)),
    }
    for reading, (home, away) in {"colours": (100, 0), "relief": (100, 100)}.items():
        found = right(made, learning, dict.fromkeys(GELS, lit), reading, (0, 0))
        own, others, lost = cost(found)
        assert (own, others, *lost) == (home, away, *[home - away] * 3)
