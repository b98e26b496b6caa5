"""Sums by class and domain give the gaps and margins that whole sets of features give."""

import pytest
import torch

from omnivat.measure.gaps.centroid import modality_gap
from omnivat.measure.gaps.sums import (
    PAIR,
    Sums,
    cosine_margin,
    cross_domain_margin,
    cross_modal_margin,
    domain_gap,
)
from omnivat.measure.gaps.unit import unit


@pytest.fixture(params=[0, 1])
def features(request):
    generator = torch.Generator().manual_seed(request.param)
    labels = torch.randint(3, (200,), generator=generator)
    domains = torch.randint(2, (200,), generator=generator) * 2  # the middle domain has no pair
    rows = {
        name: torch.randn(200, 7, generator=generator, dtype=torch.float64) + 0.3 * labels[:, None]
        for name in ("vis", "tac")
    }
    return rows, labels, domains


@pytest.mark.parametrize("size", [200, 64, 7])
def test_what_is_added_in_parts_is_the_whole(features, size):
    rows, labels, domains = features
    sums = Sums(3, 3)
    for start in range(0, 200, size):
        part = slice(start, start + size)
        sums.add({name: values[part] for name, values in rows.items()}, labels[part], domains[part])
    vis, tac = rows["vis"], rows["tac"]
    pair = unit(vis) + unit(tac)
    last = domains == 2
    found = {
        "all": (sums.centroid_gap(), modality_gap(vis, tac)),
        "one domain": (sums.centroid_gap(2), modality_gap(vis[last], tac[last])),
        "domains": (sums.domain_gap("tac"), domain_gap(tac, domains)),
        "margin": (sums.margin("vis"), cosine_margin(vis, labels)),
        "margin of pairs": (sums.margin(PAIR), cosine_margin(pair, labels)),
        "across domains": (
            sums.cross_domain_margin(PAIR),
            cross_domain_margin(pair, labels, domains),
        ),
        "across modalities": (sums.cross_modal_margin(), cross_modal_margin(vis, tac, labels)),
    }
    for name, (got, wanted) in found.items():
        torch.testing.assert_close(got, wanted, msg=name)


def test_one_class_in_one_domain_has_no_margin_and_no_domain_gap():
    sums = Sums(1, 1)
    zeros = torch.zeros(4, dtype=torch.long)
    sums.add({"vis": torch.ones(4, 2), "tac": torch.ones(4, 2)}, zeros, zeros)
    assert bool(sums.margin("vis").isnan()) and bool(sums.domain_gap("vis").isnan())
    assert float(sums.centroid_gap()) == 0


def test_many_names_with_few_pairs_hold_only_the_cells_that_have_pairs():
    sums, two = Sums(1000, 1000), torch.tensor([3, 999])
    rows = {"vis": torch.eye(2, 50), "tac": torch.ones(2, 50)}
    sums.add(rows, two, two)
    sums.add(rows, two, torch.tensor([5, 999]))
    assert {cells.shape for cells in sums.cells.values()} == {(3, 50)}
    assert sums.sizes.tolist() == [1, 2, 1]
