"""What the losses refuse, and gradients where nodes coincide or vanish."""

import pytest
import torch
from hypothesis import given
from hypothesis import strategies as st

from omnivat.head.losses import mma_loss, nod_loss
from omnivat.kit.errors import ShapeError


def test_mma_refuses_features_of_differing_shape():
    with pytest.raises(
        ShapeError, match=r"vis has shape \(2, 3\), expected \(B, D\) with B=2, D=4"
    ):
        mma_loss(torch.zeros(2, 4), torch.zeros(2, 3), torch.zeros(2, 4))


@given(seed=st.integers(0, 10_000), scale=st.sampled_from([1e-20, 1e-6, 1.0, 1e6]))
def test_nod_gradients_are_finite_in_single_precision(seed, scale):
    """Written as sqrt(sum(x²)) with the root in, a third of such gradients is NaN."""
    random = torch.Generator().manual_seed(seed)
    root = (scale * torch.randn(2, 1, 8, generator=random)).requires_grad_()
    children = torch.cat([root, root, -root, torch.zeros_like(root)], dim=1)
    nod_loss([root, children[:, :2], children]).backward()
    assert root.grad.isfinite().all()
