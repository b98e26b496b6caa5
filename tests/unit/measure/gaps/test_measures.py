"""Known results of each gap measure, and their errors."""

import numpy as np
import pytest
import torch

from omnivat.kit.errors import ShapeError
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS
from omnivat.measure.gaps.calibration import ece
from omnivat.measure.gaps.confusion import accuracy, macro_f1
from omnivat.measure.gaps.domain import floor, halves
from omnivat.measure.gaps.frechet import frechet
from omnivat.measure.gaps.measures import PREDICTION_MEASURES, Facts
from omnivat.measure.gaps.mmd import mmd_rbf
from omnivat.measure.gaps.proxy_a import RIDGE, fits, proxy_a, wrong
from omnivat.measure.gaps.unit import unit


def cloud(seed, count=60, width=5, shift=0.0):
    generator = torch.Generator().manual_seed(seed)
    return torch.randn(count, width, generator=generator, dtype=torch.float64) + shift


@pytest.mark.parametrize("name", list(GAPS))
def test_a_set_is_refused_by_name_with_the_number_of_rows_that_is_enough(name):
    measure = load(GAPS, name, kind="gap")
    with pytest.raises(ShapeError, match="b has 0 rows") as refused:
        measure(cloud(0), cloud(1, count=0))
    enough = int(str(refused.value).split("needs ")[1].split()[0])
    assert measure(cloud(0), cloud(1, count=enough)).isfinite()
    with pytest.raises(ShapeError, match=f"b has {enough - 1} rows"):
        measure(cloud(0), cloud(1, count=enough - 1))


def test_the_floor_of_a_gap_is_that_of_two_halves_of_one_domain():
    every = cloud(0, count=400)
    level = floor(halves({"a": every[:200], "b": every[200:]}), mmd_rbf)
    assert (
        0 < mmd_rbf(every[:200], every[200:]) < level
    )  # halves are smaller, so chance moves them more
    assert mmd_rbf(every[:200], cloud(1, shift=1.0)) > 5 * level
    assert floor(halves({"a": cloud(0, count=2)}), proxy_a) is None


def test_rbf_mmd_equals_the_full_kernel_matrix_at_one_over_the_mean_squared_distance():
    a, b = (unit(rows) for rows in (cloud(0, 20), cloud(1, 30, shift=0.5)))
    every = torch.cat([a, b])
    gamma = 1 / torch.cdist(every, every).square().mean()
    wanted = sum(
        sign * (-gamma * torch.cdist(x, y).square()).exp().mean()
        for sign, x, y in ((1, a, a), (1, b, b), (-2, a, b))
    )
    torch.testing.assert_close(mmd_rbf(3 * a, b), wanted)


@pytest.mark.parametrize("count", [4, 60])
def test_frechet_equals_the_matrix_root_of_the_covariances(count):
    """Fewer rows than columns gives a singular covariance; both roads must agree."""
    from scipy.linalg import sqrtm

    a, b = cloud(0, count), cloud(1, count + 5, shift=0.5)
    ua, ub = (torch.nn.functional.normalize(x) for x in (a, b))
    ca, cb = torch.cov(ua.T), torch.cov(ub.T)
    tiny = 1e-13 * torch.eye(5, dtype=torch.float64)
    root = sqrtm(((ca + tiny) @ (cb + tiny)).numpy()).real.trace()
    means = (ua.mean(0) - ub.mean(0)).square().sum()
    wanted = means + ca.trace() + cb.trace() - 2 * root
    assert frechet(a, b).item() == pytest.approx(wanted.item(), abs=1e-5)


def test_proxy_a_counts_rows_that_the_classifier_has_not_seen():
    """With more columns than rows any labelling can be learnt, but not on unseen rows."""
    a, b = cloud(0, 40, 200), cloud(1, 40, 200)
    assert proxy_a(a, b) < 0.7
    in_full = torch.cat(wrong(unit(a), unit(b), 200)).mean()  # not in the span of the rows
    assert proxy_a(a, b) == pytest.approx(max(0.0, float(2 * (1 - 2 * in_full))), abs=1e-12)


@pytest.mark.parametrize("width", [5, 90])
def test_proxy_a_penalises_by_a_share_of_the_mean_variance(width):
    """Fisher's direction with a ridge of `RIDGE` mean variances, by another solver."""
    sets = [
        (cloud(k, 30 + 10 * k, width, shift=k / 2), torch.arange(30 + 10 * k) % 5) for k in (0, 1)
    ]
    kept = [rows[fold != 2].numpy() for rows, fold in sets]
    spread = sum(np.cov(x.T, bias=True) for x in kept)
    penalty = RIDGE * np.trace(spread) / width
    apart = kept[0].mean(0) - kept[1].mean(0)
    direction, middle = [*fits(*sets, width=width)][2]
    wanted = np.linalg.inv(spread / penalty + np.eye(width)) @ apart
    np.testing.assert_allclose(direction, wanted, rtol=1e-8)
    np.testing.assert_allclose(middle, (kept[0].mean(0) + kept[1].mean(0)) / 2)


def test_scores_and_confusion_are_shares_of_the_pairs_whose_class_the_head_has():
    facts = Facts(
        labels=torch.tensor([0, 0, 0, 0, 1, 2]),
        class_names=("a", "b"),
        domains=torch.tensor([0, 0, 2, 2, 2, 2]),
        domain_names=("x", "none", "y"),
        scored=torch.tensor([True] * 5 + [False]),
    )
    said = {"fused": torch.eye(2)[[0, 0, 0, 1, 1, 1]], "vis": torch.eye(2)[[1, 0, 1, 1, 0, 0]]}

    def found(name):
        return {key: float(value) for key, value in PREDICTION_MEASURES[name](said, facts)}

    assert found("confusion") == {"/a>a": 0.75, "/a>b": 0.25, "/b>a": 0, "/b>b": 1}
    wanted = {"/all": 4 / 5, "/x": 1, "/y": 2 / 3, ":vis/all": 1 / 5}
    assert found("accuracy") == pytest.approx(wanted)


def test_scores_of_no_pairs_are_not_numbers():
    none = torch.zeros(0, dtype=torch.long)
    assert accuracy(none, none).isnan()
    assert macro_f1(none, none).isnan()
    assert ece(torch.zeros(0, 3), none).isnan()


def test_a_confidence_that_rounding_puts_above_one_is_in_the_last_bin():
    assert ece(torch.tensor([[1.000001, 0.0]]), torch.tensor([0])).item() < 1e-5
