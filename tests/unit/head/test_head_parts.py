"""Tree, tokens, attention and class means, each by itself."""

import pytest
import torch

from omnivat.head import plain
from omnivat.head.dtg import DTG
from omnivat.head.mffa import FrATT


@pytest.mark.parametrize("levels", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("init", ["orthogonal", "default", "identity"])
def test_folding_errs_below_1e_6_in_single_precision(levels, init):
    torch.manual_seed(0)
    tree = DTG(64, levels=levels, init=init)
    root = torch.nn.functional.normalize(torch.randn(32, 64), dim=-1)
    matrix, offset = tree.fold()
    error = (root @ matrix.T + offset - tree.grow(root).nodes.mean(1)).abs().max()
    assert error <= 1e-6


def test_literal_attention_divides_after_the_softmax():
    torch.manual_seed(0)
    fratt = FrATT(8, scale="outside").double()
    tokens = torch.randn(2, 5, 8, dtype=torch.float64)
    weights = torch.softmax(fratt.query(tokens) @ fratt.key(tokens).mT, dim=-1) / 8**0.5
    value = tokens @ fratt.value.weight.T * 1.0
    bias = fratt.value.bias / 8**0.5
    wanted = fratt.ffn((weights @ value).mean(1) + bias)
    torch.testing.assert_close(plain.attention(fratt, tokens[None], tokens[None])[0], wanted)


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
