"""Tree, tokens, attention and class means, each by itself."""

import pytest
import torch

from omnivat.head import plain
from omnivat.head.dtg import DTG, parents
from omnivat.head.mffa import FrATT
from omnivat.head.training import class_means


@pytest.mark.parametrize("levels", [1, 2, 3, 4, 5])
@pytest.mark.parametrize("init", ["orthogonal", "default", "identity"])
def test_folding_errs_below_1e_6_in_single_precision(levels, init):
    torch.manual_seed(0)
    tree = DTG(64, levels=levels, init=init)
    root = torch.nn.functional.normalize(torch.randn(32, 64), dim=-1)
    matrix, offset = tree.fold()
    error = (root @ matrix.T + offset - tree.grow(root).nodes.mean(1)).abs().max()
    assert error <= 1e-6


def test_tokens_are_the_transform_of_the_expanded_embedding():
    """θ_e commutes with the transform: transforming once and scaling is Eq. 3 exactly."""
    from omnivat.fractional import dfrft

    embedding = torch.randn(3, 16, dtype=torch.float64)
    theta = torch.tensor([1.0, -2.0, 0.5], dtype=torch.float64)
    first = dfrft(theta[:, None] * embedding[:, None], 0.3)
    wanted = torch.cat([torch.relu(first.real), torch.relu(first.imag)], dim=1)
    once = dfrft(embedding, 0.3)
    tokens = plain.tokens_of(torch.stack([once.real, once.imag]), theta, "tokens")
    torch.testing.assert_close(tokens[0], wanted)


def test_attention_equals_the_printed_order_of_operations():
    """Values of all tokens, then the mean over queries (Eq. 4)."""
    torch.manual_seed(0)
    fratt = FrATT(8).double()
    queries, tokens = (torch.randn(2, n, 8, dtype=torch.float64) for n in (3, 5))
    weights = torch.softmax(fratt.query(queries) @ fratt.key(tokens).mT / 8**0.5, dim=-1)
    wanted = fratt.ffn((weights @ fratt.value(tokens)).mean(1))
    feature, shares = plain.attention(fratt, queries[None], tokens[None])
    torch.testing.assert_close(feature, wanted)
    torch.testing.assert_close(shares.sum(-1), torch.ones(2, 3, dtype=torch.float64))


def test_literal_attention_divides_after_the_softmax():
    torch.manual_seed(0)
    fratt = FrATT(8, scale="outside").double()
    tokens = torch.randn(2, 5, 8, dtype=torch.float64)
    weights = torch.softmax(fratt.query(tokens) @ fratt.key(tokens).mT, dim=-1) / 8**0.5
    value = tokens @ fratt.value.weight.T * 1.0
    bias = fratt.value.bias / 8**0.5
    wanted = fratt.ffn((weights @ value).mean(1) + bias)
    torch.testing.assert_close(plain.attention(fratt, tokens[None], tokens[None])[0], wanted)


def test_class_means_are_those_of_the_batch():
    values = torch.tensor([[1.0], [3.0], [10.0]])
    means = class_means(values, torch.tensor([0, 0, 1]))
    torch.testing.assert_close(means, torch.tensor([[2.0], [2.0], [10.0]]))


def test_one_image_counts_twice_in_a_taught_head(make_head, make_pairs):
    """With one row for each class, the logits of both images are the mean of those of one alone."""
    model, (vis, tac) = make_head(taught=5), make_pairs(4)
    random = torch.Generator().manual_seed(3)
    model.taught_rows.copy_(torch.randn(model.taught_rows.shape, generator=random))
    model.taught_bias.copy_(torch.randn(5, generator=random))
    model.taught_class.copy_(torch.tensor([2, 0, 1, 4, 3]))
    found = model.taught_logits({"vis": vis, "tac": tac})
    torch.testing.assert_close(found["vis"] + found["tac"], 2 * found["fused"])
    own = model.standing("vis", vis) @ model.taught_rows[0].T
    torch.testing.assert_close(found["vis"][:, 2], 2 * own[:, 0] + model.taught_bias[0])
    alone = model.taught_logits({"vis": vis})
    torch.testing.assert_close(alone["fused"], found["vis"])


@pytest.mark.parametrize(
    ("arrangement", "wanted"),
    [
        ("tree", [-1, 0, 0, 1]),
        ("series", [-1, 0, 1, 2]),
        ("parallel", [-1, 0, 0, 0]),
        ("none", [-1, -1, -1, -1]),
    ],
)
def test_every_node_but_a_root_has_a_parent_before_it(arrangement, wanted):
    assert parents(arrangement, 4) == wanted
