"""The head: stages, counts, folding, and independence of predictions."""

import pytest
import torch

from omnivat.head.head import CHUNK, build_head
from omnivat.kit.errors import DataError, SettingsError, ShapeError
from tests.builders import head_settings


@pytest.fixture
def head(make_head):
    return make_head(theta="normal")


@pytest.fixture
def pairs(make_pairs):
    return make_pairs


def test_no_modality_at_all_is_refused(head):
    with pytest.raises(
        DataError, match=r"Neither VIS nor TAC was given; give one of them or both\."
    ):
        head(None, None)


def test_embeddings_of_another_width_are_refused(head):
    with pytest.raises(ShapeError, match=r"vis has shape \(2, 7\); this head needs \(B, 24\)"):
        head(torch.zeros(2, 7), None)


def test_unequal_numbers_of_vis_and_tac_are_refused(head):
    with pytest.raises(ShapeError, match="different numbers of pairs"):
        head(torch.zeros(2, 24), torch.zeros(3, 24))


def test_coefficients_give_the_output_of_a_full_pass_at_any_order(head, pairs):
    vis, tac = pairs(6)
    with torch.no_grad():
        kept = head.coefficients(vis, tac)
        for order in (0, 0.25, 1, 1.7, 2, 3, -0.4):
            full = head(vis, tac, order=order).probabilities
            torch.testing.assert_close(head.from_coefficients(kept, order).probabilities, full)
        part = head.from_coefficients(kept[2:4], 0.3).probabilities
        torch.testing.assert_close(part, head(vis[2:4], tac[2:4], order=0.3).probabilities)


def test_one_order_a_pair_equals_one_pass_an_order(head, pairs):
    vis, tac = pairs(3)
    orders = torch.tensor([0.1, 0.5, 0.9], dtype=torch.float64)
    with torch.no_grad():
        kept = head.coefficients(vis, tac)
        rows = head.from_coefficients(kept, orders).probabilities
        for row, order in enumerate(orders.tolist()):
            alone = head.from_coefficients(kept[row : row + 1], order).probabilities
            torch.testing.assert_close(rows[row : row + 1], alone)


def test_a_tensor_of_one_order_serves_any_number_of_pairs(head, pairs):
    vis, tac = pairs(CHUNK + 3)
    order = torch.tensor([0.1], dtype=torch.float64)
    with torch.no_grad():
        torch.testing.assert_close(
            head(vis, tac, order=order).probabilities, head(vis, tac, order=0.1).probabilities
        )


@pytest.mark.parametrize("value", [0.0, 1e-30, 1e30])
def test_zero_tiny_and_huge_embeddings_give_finite_probabilities(head, value):
    row = torch.full((1, 24), value, dtype=torch.float64)
    with torch.no_grad():
        probabilities = head(row, row).probabilities
    assert probabilities.isfinite().all()
    torch.testing.assert_close(probabilities.sum(), torch.tensor(1.0, dtype=torch.float64))


@pytest.mark.parametrize("factor", [1e-30, 1e30])
def test_the_size_of_embeddings_does_not_matter_even_where_squares_overflow(factor, pairs):
    """Nor where they vanish: 1e30 squared is infinite in single precision."""
    model = build_head(head_settings(input_width=16, width=16, standardize=False)).eval()
    vis, tac = (x[:, :16].float() for x in pairs(3))
    with torch.no_grad():
        plain, scaled = model(vis, tac), model(factor * vis, factor * tac)
    assert (plain.probabilities - scaled.probabilities).abs().max() < 1e-6


def test_classes_start_as_random_vectors_of_about_length_one():
    lengths = build_head(head_settings(width=256), seed=0).classifier.detach().norm(dim=1)
    assert 0.8 < float(lengths.min()) < float(lengths.max()) < 1.2


def test_same_seed_gives_the_same_weights_and_leaves_global_randomness_alone():
    torch.manual_seed(7)
    expected = torch.rand(1)
    torch.manual_seed(7)
    first, second, other = (build_head(head_settings(), seed=s) for s in (3, 3, 4))
    assert torch.equal(torch.rand(1), expected)
    assert all(
        torch.equal(a, b) for a, b in zip(first.parameters(), second.parameters(), strict=True)
    )
    assert not torch.equal(first.classifier, other.classifier)


@pytest.mark.parametrize(
    ("change", "sentence"),
    [
        ({"classes": ("wood",)}, "two or more different names"),
        ({"order": float("nan")}, "a number of quarter turns from -4 to 4"),
        ({"width": 1}, "width is 1"),
    ],
)
def test_impossible_settings_are_refused_with_a_sentence(change, sentence):
    with pytest.raises(SettingsError, match=sentence):
        head_settings(**change)
    assert head_settings(width=2).width == 2
