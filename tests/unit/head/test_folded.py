"""Folded weights: exact, forgotten when a weight changes, alike for a pair alone and in chunks."""

import pytest
import torch

from omnivat.kit.stages import IMAGES

from .oracle import Slow


@torch.no_grad()
def difference(model, given, output):
    """Return the largest difference of F-bar and probabilities from those of the slow head."""
    bars, _, probabilities = Slow(model).predict(dict(zip(IMAGES, given, strict=True)))
    apart = [(output.f_bar[n] - bar).abs().max() for n, bar in zip(IMAGES, bars, strict=True)]
    return max(*apart, (output.probabilities - probabilities).abs().max())


def test_in_single_precision_they_differ_by_less_than_1e_6(make_head, make_pairs):
    changes = {"width": 512, "input_width": 512, "lang_width": 512}
    model = make_head(theta="normal", dtype=torch.float32, **changes)
    given = make_pairs(40, 512, torch.float32)
    with torch.no_grad():
        assert difference(model, given, model(*given)) <= 1e-6


@pytest.mark.parametrize("dtype", [torch.float32, torch.float64])
def test_a_pair_alone_in_a_batch_and_across_chunks_is_predicted_alike(
    make_head, make_pairs, monkeypatch, dtype
):
    monkeypatch.setattr("omnivat.head.head.CHUNK", 16)
    model = make_head(dtype=dtype, width=128, input_width=96, theta="signed")
    vis, tac = make_pairs(37, 96, dtype)
    with torch.inference_mode():
        together = model(vis, tac)
        alone = [model(vis[i : i + 1], tac[i : i + 1]) for i in range(37)]
    assert len(together.probabilities) == 37
    single = torch.cat([output.probabilities for output in alone])
    assert (together.probabilities - single).abs().max() <= 1e-6


def test_chunks_keep_orders_and_nodes_with_their_pairs(make_head, make_pairs, monkeypatch):
    model, given = make_head(), make_pairs(10)
    orders = torch.linspace(0, 1, 10, dtype=torch.float64)
    with torch.no_grad():
        kept = model.coefficients(*given)
        whole = model.from_coefficients(kept, orders, nodes=True)
        monkeypatch.setattr("omnivat.head.head.CHUNK", 3)
        parts = model.from_coefficients(kept, orders, nodes=True)
    torch.testing.assert_close(parts.nodes, whole.nodes)
    torch.testing.assert_close(parts.f_hat, whole.f_hat)
    torch.testing.assert_close(parts.readings, whole.readings)
    assert parts.frft["vis"].shape == (2, 10, 16)


def test_no_pairs_give_empty_answers(make_head):
    with torch.no_grad():
        output = make_head()(torch.zeros(0, 24), torch.zeros(0, 24))
    assert output.probabilities.shape == (0, 5)


@pytest.mark.parametrize(
    "name",
    [
        "mffa.bank",
        "mffa.fratt.value.bias",
        "mffa.theta.vis",
        "dtg.weight",
        "classifier",
        "project_tac.weight",
    ],
)
def test_a_weight_changed_in_place_changes_the_next_prediction(make_head, make_pairs, name):
    """Folded weights must not outlive the original weights."""
    model, given = make_head(), make_pairs(3)
    with torch.no_grad():
        before = model(*given).probabilities
        model.state_dict()[name].mul_(-2)
        after = model(*given)
    assert not torch.allclose(before, after.probabilities)
    assert difference(model, given, after) <= 1e-12


def test_loading_weights_and_changing_precision_forget_what_was_folded(make_head, make_pairs):
    model, other, given = make_head(), make_head(theta="normal"), make_pairs(3)
    with torch.no_grad():
        model(*given)
        model.load_state_dict(other.state_dict())
        torch.testing.assert_close(model(*given).probabilities, other(*given).probabilities)
        single = model.float()(*(x.float() for x in given)).probabilities
    assert single.dtype == torch.float32


@pytest.mark.parametrize("frozen", [False, True])
def test_gradients_reach_p_and_the_embeddings_whatever_was_folded_before(
    make_head, make_pairs, frozen
):
    model = make_head().requires_grad_(not frozen)
    vis, tac = make_pairs(3)
    with torch.inference_mode():
        wanted = model(vis, tac).probabilities
    for _ in range(2):  # the second time, too
        output = model(vis.requires_grad_(), tac)
        output.logits["vis"].sum().backward()
    assert vis.grad.abs().sum() > 0
    moved = [p.grad is not None for p in (model.mffa.order, model.dtg.weight, model.classifier)]
    assert moved == [not frozen] * 3
    with torch.no_grad():
        torch.testing.assert_close(model(vis, tac).probabilities, wanted)


def test_attention_is_that_of_each_token_to_each(make_head, make_pairs):
    model, (vis, tac) = make_head(theta="signed"), make_pairs(4)
    slow, fratt = Slow(model), model.mffa.fratt
    with torch.no_grad():
        tokens = slow.tokens("tac", slow.embedded("tac", tac), None)[1]
        wanted = torch.softmax(fratt.query(tokens) @ fratt.key(tokens).mT / 4, dim=-1)
        torch.testing.assert_close(model(vis, tac, attention=True).attention["tac"], wanted)
        assert not model(vis, tac).attention
    torch.testing.assert_close(model(vis, tac, attention=True).attention["tac"].detach(), wanted)
