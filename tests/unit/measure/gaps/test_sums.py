"""Sums by class and domain give the gaps and margins that whole sets of features give."""

import pytest
import torch

from omnivat.measure.gaps.centroid import modality_gap
from omnivat.measure.gaps.sums import PAIR, Sums, cosine_margin, sums_of
from omnivat.measure.gaps.unit import unit


@pytest.fixture
def features():
    generator = torch.Generator().manual_seed(0)
    labels = torch.randint(3, (200,), generator=generator)
    domains = torch.randint(2, (200,), generator=generator) * 2  # the middle domain has no pair
    rows = {
        name: torch.randn(200, 7, generator=generator, dtype=torch.float64) + 0.3 * labels[:, None]
        for name in ("vis", "tac")
    }
    return rows, labels, domains


def test_what_is_added_in_parts_is_the_whole(features):
    rows, labels, domains = features
    sums = Sums(labels, domains)
    for start in range(0, 200, 64):
        part = slice(start, start + 64)
        sums.add({name: values[part] for name, values in rows.items()}, part)
    whole, last = sums_of(labels, domains, **rows), domains == 2
    for one, wanted in ((sums, whole), (whole, sums)):
        torch.testing.assert_close(one.centroid_gap(), modality_gap(rows["vis"], rows["tac"]))
        gap = modality_gap(rows["vis"][last], rows["tac"][last])
        torch.testing.assert_close(one.centroid_gap(2), gap)
        torch.testing.assert_close(one.cross_modal_margin(), wanted.cross_modal_margin())
        for name in ("vis", "tac", PAIR):
            for measure in (Sums.margin, Sums.cross_domain_margin, Sums.domain_gap):
                torch.testing.assert_close(measure(one, name), measure(wanted, name))
    pair = unit(rows["vis"]) + unit(rows["tac"])
    torch.testing.assert_close(sums.margin(PAIR), cosine_margin(pair, labels))


def test_one_class_in_one_domain_has_no_margin_and_no_domain_gap():
    zeros = torch.zeros(4, dtype=torch.long)
    sums = sums_of(zeros, zeros, vis=torch.ones(4, 2), tac=torch.ones(4, 2))
    assert bool(sums.margin("vis").isnan()) and bool(sums.domain_gap("vis").isnan())
    assert float(sums.centroid_gap()) == 0


def test_many_names_with_few_pairs_hold_only_the_cells_that_have_pairs():
    labels, domains = torch.tensor([3, 999, 3, 999]), torch.tensor([3, 999, 5, 999])
    sums = sums_of(labels, domains, vis=torch.eye(4, 50), tac=torch.ones(4, 50))
    assert {cells.shape for cells in sums.cells.values()} == {(3, 50)}
    assert sums.sizes.tolist() == [1, 1, 2]
