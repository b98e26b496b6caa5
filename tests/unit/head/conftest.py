"""Heads in which every part matters, and pairs for them."""

import pytest
import torch

from omnivat.head.head import build_head
from tests.builders import head_settings


@pytest.fixture(scope="session")
def make_head():
    """Return a maker of heads with random class tokens, biases and, optionally, signed θ_e."""

    def make(*, theta="ones", dtype=torch.float64, **changes):
        values = {"width": 16, "lang_width": 8, "theta_init": theta} | changes
        model = build_head(head_settings(**values)).to(dtype).eval()
        random = torch.Generator().manual_seed(1)
        with torch.no_grad():
            for name, tensor in model.state_dict().items():
                if name in ("mffa.bank", "dtg.bias"):
                    tensor.copy_(torch.randn(tensor.shape, generator=random))
            if model.settings.mffa:
                model.mffa.bank_seen.fill_(True)
            if model.settings.order_per_modality:
                model.mffa.order.copy_(torch.tensor([0.9, 0.2, 0.7]))
        return model

    return make


@pytest.fixture(scope="session")
def make_pairs():
    """Return a maker of VIS and TAC embeddings (count, width)."""

    def make(count, width=24, dtype=torch.float64, seed=0):
        random = torch.Generator().manual_seed(seed)
        return tuple(
            torch.randn(count, width, generator=random, dtype=torch.float64).to(dtype)
            for _ in ("vis", "tac")
        )

    return make
