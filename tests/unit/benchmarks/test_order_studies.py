"""The studies of the order: the controls are what they claim, and tables follow from records."""

import numpy as np
import pytest
import torch

from benchmarks.studies._order_matrix import KINDS, heads_with, matrix_of
from benchmarks.studies.order_squares import accuracy, ensembles, summary, table
from benchmarks.studies.order_touch import PERIODS, RATE, finger
from omnivat.head.head import build_head
from omnivat.head.settings import HeadSettings
from omnivat.training.batches import Batch
from omnivat.training.settings import TrainSettings
from omnivat.training.steps import learn, make_optimiser


def head(order=0.3):
    settings = HeadSettings(classes=("a", "b"), input_width=12, lang_width=5, width=8, order=order, learn_order=False)
    return build_head(settings, seed=1)


def stepped(model):
    """Take one step with LANG; return the head's probabilities."""
    random = torch.Generator().manual_seed(0)
    vis, tac = torch.randn(2, 6, 12, generator=random)
    on = torch.tensor([True, False] * 3)
    batch = Batch(
        vis=vis,
        tac=tac,
        lang=torch.randn(6, 5, generator=random),
        labels=torch.tensor([0, 1] * 3),
        lang_on=on,
        token_on=~on,
        order=None,
    )
    learn(model, make_optimiser(model, TrainSettings(lr=1.0)), batch, TrainSettings(lr=1.0))
    return model.eval()(vis, tac).probabilities.detach()


@pytest.mark.parametrize("kind", KINDS)
def test_every_control_is_unitary(kind):
    matrix = matrix_of(kind, 16, 0.3)
    torch.testing.assert_close(matrix @ matrix.mH, torch.eye(16, dtype=torch.complex128))


def test_the_random_group_is_a_group_with_the_period_of_the_transform():
    a, b, both = (matrix_of("group", 16, p, draw=3) for p in (0.3, 0.4, 0.7))
    torch.testing.assert_close(a @ b, both)
    torch.testing.assert_close(matrix_of("group", 16, 4.0, draw=3), matrix_of("identity", 16, 0))
    assert (both - matrix_of("group", 16, 0.7, draw=4)).abs().max() > 0.1


def test_a_head_with_the_matrix_of_its_order_is_the_head_itself():
    with heads_with(matrix_of("order", 8, 0.3)):
        replaced = stepped(head(order=0.9))
    torch.testing.assert_close(replaced, stepped(head(order=0.3)))
    with heads_with(matrix_of("unitary", 8, 0.3)):
        assert (stepped(head(order=0.3)) - replaced).abs().max() > 1e-3


def made_square():
    """Row 1 is right on domain 1; every other head predicts 0."""
    heads = [["0000" if row != 1 else "0101"] * 5 for row in range(5)]
    votes = {name: heads[rows[0]][0] for name, rows, _ in ensembles(5)}
    named = {"head": "ridge", "kind": "order", "width": 64, "noise": 0.0, "source": "A"}
    return named | {"label": "1101", "domain": "0011", "own": 0, "heads": heads, "ensembles": votes}


def test_a_diagonal_has_every_order_and_every_seed_once():
    for name, rows, seeds in ensembles(5):
        if name.startswith("orders ") and "one" not in name:
            assert sorted(rows) == sorted(seeds) == list(range(5))


def test_figures_of_a_square_count_unseen_pairs_alone():
    square = made_square()
    assert accuracy(square, "0101") == 100.0 and accuracy(square, "1100") == 50.0
    found = summary(square)
    assert found["one"] == pytest.approx((4 * 50 + 100) / 5)
    assert found["differ by seed"] == 0.0
    assert found["differ by order"] == pytest.approx(100 * 0.4 * 0.5)  # one row in five, one pair in two
    assert "| ridge | order | 64 | 0 | 5 | 1 | 60.00 |" in table([square])


def peak(rows):
    """Return the frequency (Hz) of the largest magnitude of each row, by a padded spectrum."""
    spectrum = np.abs(np.fft.rfft(rows * np.hanning(rows.shape[1]), 8192))
    return spectrum.argmax(1) * RATE / 8192


def test_a_finger_on_a_grating_has_the_frequency_of_its_speed_over_the_period():
    signals, labels = finger(0.0, 0.0, 0.0, seed=0, count=2)
    np.testing.assert_allclose(peak(signals), 80 / np.array(PERIODS)[labels], rtol=0.03)


def test_the_chirp_rate_of_a_finger_is_its_acceleration_over_the_period():
    signals, labels = finger(1600.0, 0.0, 0.0, seed=0, count=20)
    half = signals.shape[1] // 2
    rise = (peak(signals[:, half:]) - peak(signals[:, :half])) / (half / RATE)
    means = [rise[labels == k].mean() for k in range(len(PERIODS))]
    np.testing.assert_allclose(means, 1600.0 / np.array(PERIODS), rtol=0.15)
