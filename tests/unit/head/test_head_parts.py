"""Unit rows and lessons, each by itself."""

import torch

from omnivat.kit.shapes import unit


def draw(*shape):
    return torch.randn(shape, dtype=torch.float64)


def test_unit_rows_agree_with_finite_differences_and_zero_stays_zero():
    assert torch.autograd.gradcheck(unit, [draw(3, 5).requires_grad_()])
    zero = torch.zeros(2, 4, requires_grad=True)
    unit(zero).sum().backward()
    assert not unit(zero).any()
    assert zero.grad.isfinite().all()


def test_one_image_counts_twice_in_a_taught_head(make_head, make_pairs):
    """Scores of both images are the mean of those of one alone."""
    model, (vis, tac) = make_head(taught=(5,)), make_pairs(4)
    random = torch.Generator().manual_seed(3)
    model.taught_rows.copy_(torch.randn(model.taught_rows.shape, generator=random))
    model.taught_bias.copy_(torch.randn(model.taught_bias.shape, generator=random))
    scores = model.lessons({"vis": vis, "tac": tac}).scores
    torch.testing.assert_close(scores["vis"] + scores["tac"], 2 * scores["fused"])
    wanted = 2 * model.standing("vis", vis) @ model.taught_rows[0, 0].T + model.taught_bias[0]
    torch.testing.assert_close(scores["vis"][:, 0], wanted)
    alone = model.lessons({"vis": vis}).scores
    torch.testing.assert_close(alone["fused"], scores["vis"])
