"""Laws of the gap measures: symmetry, zero for equal sets, what they ignore, slow oracles."""

from itertools import product
from math import log
from statistics import mean

import pytest
import torch
from hypothesis import given, settings
from hypothesis import strategies as st

from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS
from omnivat.measure.gaps.calibration import BINS, aurc, ece, nll
from omnivat.measure.gaps.confusion import macro_f1
from omnivat.measure.gaps.domain import pairwise_gaps
from omnivat.measure.gaps.sums import sums_of

seeds = st.integers(0, 2**31)
counts = st.integers(6, 14)
widths = st.integers(2, 9)
lengths = st.sampled_from([1e-150, 1e-3, 7.0, 1e150])
gaps = pytest.mark.parametrize("name", list(GAPS))
few = settings(max_examples=15, deadline=None)


def sets(seed, count, width):
    """Two sets of different sizes, float64."""
    generator = torch.Generator().manual_seed(seed)
    a = torch.randn(count, width, generator=generator, dtype=torch.float64)
    b = torch.randn(count + 3, width, generator=generator, dtype=torch.float64) + 0.3
    return a, b


def labelled(seed, count):
    generator = torch.Generator().manual_seed(seed)
    return torch.randint(0, 3, (count,), generator=generator), torch.randint(
        0, 3, (count,), generator=generator
    )


@gaps
@few
@given(seed=seeds, count=counts, width=widths, length=lengths)
def test_a_gap_is_symmetric_zero_to_itself_and_ignores_lengths_and_rotations(
    name, seed, count, width, length
):
    """A unitary DFrFT therefore leaves every one of them where it was, at any order."""
    a, b = sets(seed, count, width)
    turn = torch.linalg.qr(sets(seed + 1, width, width)[0]).Q
    measure = load(GAPS, name, kind="gap")
    found = measure(a, b)
    torch.testing.assert_close(found, measure(b, a), rtol=1e-9, atol=1e-12)
    assert measure(a, a).item() == pytest.approx(0, abs=1e-12)
    torch.testing.assert_close(measure(a * length, b), found, rtol=1e-7, atol=1e-10)
    torch.testing.assert_close(measure(a @ turn, b @ turn), found, rtol=1e-7, atol=1e-10)


def slow_margin(rows, others, labels, other_labels, counted):
    """The margin by looking at every pair."""
    kinds = {True: [], False: []}
    for i, j in product(range(len(rows)), range(len(others))):
        if counted(i, j):
            cosine = torch.nn.functional.cosine_similarity(rows[i], others[j], dim=0)
            kinds[bool(labels[i] == other_labels[j])].append(cosine)
    return torch.stack(kinds[True]).mean() - torch.stack(kinds[False]).mean()


@few
@given(seed=seeds, count=st.integers(10, 20), width=widths)
def test_margins_equal_those_of_every_pair_counted_one_by_one(seed, count, width):
    rows, _ = sets(seed, count, width)
    tac, _ = sets(seed + 1, count, width)
    labels, domains = labelled(seed, count)
    labels[:4], domains[:4] = torch.tensor([0, 0, 1, 1]), torch.tensor([0, 1, 0, 1])
    sums = sums_of(labels, domains, vis=rows, tac=tac)
    torch.testing.assert_close(
        sums.margin("vis"), slow_margin(rows, rows, labels, labels, lambda i, j: i < j)
    )
    torch.testing.assert_close(
        sums.cross_domain_margin("vis"),
        slow_margin(rows, rows, labels, labels, lambda i, j: i < j and domains[i] != domains[j]),
    )
    torch.testing.assert_close(
        sums.cross_modal_margin(), slow_margin(rows, tac, labels, labels, lambda i, j: i != j)
    )


@few
@given(seed=seeds, count=counts, width=widths)
def test_the_domain_gap_is_the_mean_over_every_two_domains(seed, count, width):
    rows, _ = sets(seed, count, width)
    _, domains = labelled(seed, count)
    domains[:2] = torch.tensor([0, 2])
    named = {str(d): rows[domains == d] for d in domains.unique().tolist()}
    every = pairwise_gaps(named, load(GAPS, "centroid", kind="gap"))
    found = sums_of(torch.zeros_like(domains), domains, vis=rows).domain_gap("vis")
    torch.testing.assert_close(found, torch.stack([*every.values()]).mean())


@few
@given(seed=seeds, count=st.integers(1, 14))  # of few pairs a class is in neither
def test_macro_f1_agrees_with_scikit_learn(seed, count):
    from sklearn.metrics import f1_score

    truth, answers = labelled(seed, count)
    union = f1_score(truth, answers, average="macro", zero_division=0)
    present = f1_score(
        truth, answers, labels=truth.unique().tolist(), average="macro", zero_division=0
    )
    assert macro_f1(truth, answers, union=True).item() == pytest.approx(union)
    assert macro_f1(truth, answers).item() == pytest.approx(present)


@few
@given(seed=seeds, count=st.integers(1, 60))
def test_calibration_measures_are_those_of_a_walk_over_bins_ranks_and_pairs(seed, count):
    generator = torch.Generator().manual_seed(seed)
    shares = torch.rand(count, 4, generator=generator, dtype=torch.float64) ** 3
    shares, (labels, _) = shares / shares.sum(1, keepdim=True), labelled(seed, count)
    rows = zip(shares.tolist(), labels.tolist(), strict=True)
    pairs = [(max(row), row.index(max(row)) == k, row[k]) for row, k in rows]
    gains = [(BINS * sure, right - sure) for sure, right, _ in pairs]
    bins = [sum(gain for place, gain in gains if b < place <= b + 1) for b in range(BINS)]
    assert float(ece(shares, labels)) == pytest.approx(sum(map(abs, bins)) / count)
    wrong = [not right for _, right, _ in sorted(pairs, reverse=True)]
    risks = [mean(wrong[:n]) for n in range(1, count + 1)]
    assert float(aurc(shares, labels)) == pytest.approx(mean(risks))
    assert float(nll(shares, labels)) == pytest.approx(-mean(log(share) for *_, share in pairs))
