"""The head: stages, counts, folding, and independence of predictions."""

import pytest
import torch

from omnivat.head.head import CHUNK, build_head
from omnivat.kit.errors import DataError, SettingsError, ShapeError
from tests.builders import head_settings


@pytest.fixture
def head(make_head):
    return make_head(theta="normal")


@pytest.mark.parametrize(
    ("vis", "tac", "error", "sentence"),
    [
        (None, None, DataError, r"Neither VIS nor TAC was given; give one of them or both\."),
        ((2, 7), None, ShapeError, r"vis has shape \(2, 7\); this head needs \(B, 24\)"),
        ((2, 24), (3, 24), ShapeError, "different numbers of pairs"),
    ],
)
def test_images_that_make_no_pairs_for_this_head_are_refused(head, vis, tac, error, sentence):
    with pytest.raises(error, match=sentence):
        head(*(shape and torch.zeros(shape) for shape in (vis, tac)))


def test_numbers_beyond_the_precision_of_the_head_are_refused(head):
    rows = torch.ones(2, head.settings.input_width, dtype=torch.float64)
    with pytest.raises(DataError, match="vis has inf in row 1, column 0, expected finite numbers"):
        head.float()(rows * torch.tensor([[1.0], [1e39]], dtype=torch.float64), rows)


def test_one_order_a_pair_equals_one_pass_an_order_and_one_alone_serves_all(head, make_pairs):
    pairs = make_pairs(CHUNK + 3)
    orders = torch.linspace(-1, 1, CHUNK + 3, dtype=torch.float64)
    with torch.no_grad():
        kept = head.coefficients(*pairs)
        rows = head.from_coefficients(kept, orders).probabilities
        for row in (0, 1, CHUNK, CHUNK + 2):
            some, order = slice(row, row + 1), float(orders[row])
            alone = head(*(x[some] for x in pairs), order=order).probabilities
            torch.testing.assert_close(rows[some], alone)
            torch.testing.assert_close(
                head.from_coefficients(kept[some], order).probabilities, alone
            )
        same = [
            head(*pairs, order=order).probabilities for order in (orders[3:4], float(orders[3]))
        ]
    torch.testing.assert_close(*same)


@pytest.mark.parametrize("factor", [1e-30, 1e30])
def test_the_size_of_embeddings_does_not_matter_even_where_squares_overflow(factor, make_pairs):
    """Nor where they vanish: 1e30 squared is infinite in single precision."""
    model = build_head(head_settings(input_width=16, width=16, standardize=False)).eval()
    vis, tac = (x[:, :16].float() for x in make_pairs(3))
    with torch.no_grad():
        plain, scaled = model(vis, tac), model(factor * vis, factor * tac)
    assert (plain.probabilities - scaled.probabilities).abs().max() < 1e-6


@pytest.mark.parametrize(
    ("change", "sentence"),
    [({"classes": ("wood",)}, "two or more different names"), ({"width": 1}, "width is 1")],
)
def test_impossible_settings_are_refused_with_a_sentence(change, sentence):
    with pytest.raises(SettingsError, match=sentence):
        head_settings(**change)
    assert head_settings(width=2).width == 2
