"""The axes in the types of the reference head are those of its arrays; other axes are refused."""

import importlib
import sys

import pytest
import torch
from jaxtyping import TypeCheckError, install_import_hook

import omnivat.head
from omnivat.head.head import build_head
from omnivat.head.settings import HeadSettings

PLAIN = "omnivat.head.plain"
VIS, TAC = torch.randn(5, 12), torch.randn(5, 12)
ON = torch.tensor([True, False, True, True, False])


@pytest.fixture(scope="module")
def checked():
    """The reference head, imported a second time with every call checked."""
    plain = sys.modules.pop(PLAIN)
    with install_import_hook(PLAIN, "beartype.beartype"):
        found = importlib.import_module(PLAIN)
    sys.modules[PLAIN], omnivat.head.plain = plain, plain
    return found


def head(**change):
    return build_head(
        HeadSettings(classes=("a", "b", "c"), input_width=12, lang_width=10, width=8, **change)
    )


@pytest.mark.parametrize(
    "change",
    [
        {},
        {"complex_to_real": "hermitian"},
        {"complex_to_real": "magnitude", "order_per_modality": True},
        {"complex_to_real": "real", "generation": "none"},
        {"generation": "series", "fusion": "feature"},
        {"generation": "interpolation", "feature_scale": "literal"},
        {"mffa": False},
    ],
)
def test_every_array_of_the_reference_has_the_axes_of_its_type(checked, change):
    model = head(**change)
    for images in ({"vis": VIS, "tac": TAC}, {"tac": TAC}):
        for order in (None, torch.tensor(0.3).double(), torch.rand(5).double()):
            assert checked.predict(model, images, order).probabilities.shape == (5, 3)


def test_axes_in_a_wrong_order_are_refused(checked):
    embedding, parts = torch.randn(5, 8), torch.randn(2, 5, 8)
    assert checked.tokens_of(parts, torch.ones(4), "tokens").shape == (1, 5, 8, 8)
    with pytest.raises(TypeCheckError, match="parts"):
        checked.tokens_of(parts.movedim(0, 1), torch.ones(4), "tokens")
    with pytest.raises(TypeCheckError, match="token"):
        checked.with_class_token(parts[:1, :, None], embedding.T)
    with pytest.raises(TypeCheckError, match="guide"):
        checked.queries_of(parts[:1, :, None], embedding.T, ON)
