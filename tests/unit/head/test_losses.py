"""The losses against closed forms written out in full."""

import math

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from omnivat.head.losses import joint_loss, mma_loss, nod_loss
from omnivat.head.output import TrainingOutput
from omnivat.kit.errors import ShapeError


def test_mma_is_kl_from_lang_and_not_towards_it():
    lang = torch.tensor([[math.log(0.9), math.log(0.1)]], dtype=torch.float64)
    other = torch.tensor([[math.log(0.5), math.log(0.5)]], dtype=torch.float64)
    forward = 0.9 * math.log(0.9 / 0.5) + 0.1 * math.log(0.1 / 0.5)
    backward = 0.5 * math.log(0.5 / 0.9) + 0.5 * math.log(0.5 / 0.1)
    assert abs(forward - backward) > 0.1
    assert mma_loss(lang, other, lang).item() == pytest.approx(forward, abs=1e-12)
    assert mma_loss(lang, lang, other).item() == pytest.approx(forward, abs=1e-12)
    assert mma_loss(lang, other, other).item() == pytest.approx(2 * forward, abs=1e-12)


def test_mma_is_zero_where_the_three_agree_and_a_mean_over_the_batch():
    feature = torch.randn(5, 7, dtype=torch.float64)
    assert mma_loss(feature, feature, feature).item() == pytest.approx(0, abs=1e-12)
    lang, vis, tac = (torch.randn(2, 7, dtype=torch.float64) for _ in range(3))
    rows = [mma_loss(lang[i : i + 1], vis[i : i + 1], tac[i : i + 1]) for i in range(2)]
    torch.testing.assert_close(mma_loss(lang, vis, tac), torch.stack(rows).mean())


def test_mma_refuses_features_of_differing_shape():
    with pytest.raises(
        ShapeError, match=r"vis has shape \(2, 3\), expected \(B, D\) with B=2, D=4"
    ):
        mma_loss(torch.zeros(2, 4), torch.zeros(2, 3), torch.zeros(2, 4))


def test_mma_has_no_term_for_a_modality_that_is_not_there():
    lang, vis, tac = (torch.randn(2, 7, dtype=torch.float64) for _ in range(3))
    torch.testing.assert_close(
        mma_loss(lang, vis=vis) + mma_loss(lang, tac=tac), mma_loss(lang, vis, tac)
    )


def test_nod_is_the_frobenius_norm_of_cosines_off_the_diagonal():
    nodes = torch.tensor([[[1.0, 0.0], [1.0, 1.0]]], dtype=torch.float64)
    wanted = math.sqrt(2 * 0.5)  # two entries cos 45° = sqrt(1/2)
    assert nod_loss([nodes[:, :1], nodes]).item() == pytest.approx(wanted)


def test_nod_is_zero_for_orthogonal_nodes_of_any_length():
    nodes = torch.tensor([[[3.0, 0, 0, 0], [0, 0.1, 0, 0], [0, 0, 7, 0], [0, 0, 0, -2]]])
    assert nod_loss([nodes[:, :1], nodes[:, :2], nodes]).item() == pytest.approx(0)


def test_nod_sums_levels_and_leaves_out_the_root():
    nodes = torch.randn(3, 4, 6, dtype=torch.float64)
    root, second, third = nodes[:, :1], nodes[:, :2], nodes
    both = nod_loss([root, second, third])
    torch.testing.assert_close(both, nod_loss([root, second]) + nod_loss([root, third]))
    assert nod_loss([root]).item() == 0


@given(seed=st.integers(0, 10_000), scale=st.sampled_from([1e-20, 1e-6, 1.0, 1e6]))
def test_nod_gradients_are_finite_in_single_precision(seed, scale):
    """Written as sqrt(sum(x²)) with the root in, a third of such gradients is NaN."""
    random = torch.Generator().manual_seed(seed)
    root = (scale * torch.randn(2, 1, 8, generator=random)).requires_grad_()
    children = torch.cat([root, root, -root, torch.zeros_like(root)], dim=1)
    nod_loss([root, children[:, :2], children]).backward()
    assert root.grad.isfinite().all()


def test_nod_gradient_agrees_with_finite_differences():
    nodes = torch.randn(2, 4, 5, dtype=torch.float64, requires_grad=True)
    assert torch.autograd.gradcheck(lambda x: nod_loss([x[:, :1], x[:, :2], x]), [nodes])


def test_joint_loss_weighs_its_parts():
    torch.manual_seed(0)
    features = {name: torch.randn(4, 6) for name in ("lang", "vis", "tac")}
    layers = [torch.randn(4, n, 6) for n in (1, 2)]
    logits = {name: torch.randn(4, 5) for name in ("vis", "tac")}
    labels = torch.tensor([0, 1, 2, 3])
    output = TrainingOutput(features=features, layers=layers, logits=logits, tokens={})
    parts = joint_loss(output, labels, mma_weight=3, nod_weight=2)
    torch.testing.assert_close(parts.total, 3 * parts.mma + 2 * parts.nod + parts.cross_entropy)
    ce = sum(torch.nn.functional.cross_entropy(x, labels) for x in logits.values()) / 2
    torch.testing.assert_close(parts.cross_entropy, ce)
    del features["lang"]
    assert joint_loss(output, labels).mma.item() == 0
