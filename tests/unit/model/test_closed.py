"""Gradients in closed form, against finite differences and against the form as printed."""

import pytest
import torch

from omnivat.fractional import dfrft
from omnivat.lengths import unit
from omnivat.losses.total import joint_loss
from omnivat.model.closed import Pass, closed_features
from omnivat.model.closed.turning import turn_of, turned
from omnivat.model.dtg import parents
from omnivat.model.growing import grown_nodes

KEY_BIAS = "mffa.fratt.key.bias"  # a softmax ignores it: its gradient is zero, or left out


def draw(*shape):
    return torch.randn(shape, dtype=torch.float64)


def one_step(model, printed, lang=True, tac=True, order=None):
    """Return loss, gradients and mean tokens of one batch with LANG and class tokens mixed."""
    torch.manual_seed(2)
    pairs, labels = 7, torch.tensor([0, 1, 2, 3, 4, 0, 1])
    vis, touch, text = draw(pairs, 24), draw(pairs, 24), draw(pairs, 8)
    lang_on, token_on = torch.rand(pairs) < 0.5, torch.rand(pairs) < 0.5
    model.mffa.as_printed = printed
    model.zero_grad()
    output = model.training_pass(
        vis,
        touch if tac else None,
        text if lang else None,
        labels,
        lang_on=lang_on,
        token_on=token_on,
        order=order,
    )
    loss = joint_loss(
        features=output.features, layers=output.layers, logits=output.logits, labels=labels
    ).total
    loss.backward()
    grads = {n: p.grad for n, p in model.named_parameters() if n != KEY_BIAS}
    return loss.detach(), grads, output.tokens


@pytest.mark.parametrize("theta", ["ones", "signed", "normal"])
@pytest.mark.parametrize(
    "change",
    [
        {},
        {"complex_to_real": "real"},
        {"order_per_modality": True},
        {"class_token": False},
        {"feature_scale": "literal"},
        {"attention_scale": "outside"},
        {"expansion": 1},
        {"learn_order": False},
        {"order": 3.7},
    ],
    ids=str,
)
@pytest.mark.parametrize("lang", [True, False], ids=["lang", "no lang"])
@pytest.mark.parametrize("tac", [True, False], ids=["vis and tac", "vis alone"])
def test_a_step_in_closed_form_equals_the_step_as_printed(make_head, theta, change, lang, tac):
    """The oracle expands every token and leaves all gradients to autograd."""
    model = make_head(theta=theta, **change).train()
    (loss, grads, tokens), (wanted_loss, wanted, wanted_tokens) = (
        one_step(model, printed, lang, tac) for printed in (False, True)
    )
    torch.testing.assert_close(loss, wanted_loss, rtol=1e-11, atol=1e-12)
    for name, grad in wanted.items():
        if grad is not None and grads[name] is not None:
            largest = float(grad.abs().max())
            torch.testing.assert_close(
                grads[name], grad, rtol=0, atol=1e-10 * (1 + largest), msg=lambda m, n=name: n + m
            )
        else:
            assert all(g is None or not g.any() for g in (grads[name], grad)), name
    for name, token in wanted_tokens.items():
        torch.testing.assert_close(tokens[name], token)


@pytest.mark.parametrize("lang", [True, False], ids=["lang", "no lang"])
@pytest.mark.parametrize("order", [0.3, [0.3] * 7, [0.1, 0.9, 0.4, 1.7, 0.0, 1.0, -0.2]], ids=str)
def test_a_step_at_given_orders_equals_the_step_as_printed(make_head, lang, order):
    """One order for the batch or one for each row, in place of the learned one."""
    model = make_head(learn_order=False).train()
    given = torch.tensor(order, dtype=torch.float64)
    (loss, grads, _), (wanted_loss, wanted, _) = (
        one_step(model, printed, lang, order=given) for printed in (False, True)
    )
    torch.testing.assert_close(loss, wanted_loss, rtol=1e-11, atol=1e-12)
    for name, grad in wanted.items():
        if grad is not None and grads[name] is not None:
            torch.testing.assert_close(grads[name], grad, rtol=0, atol=1e-9)
    assert not torch.allclose(loss, one_step(model, False, lang)[0])


def test_the_comparison_with_the_printed_form_can_fail(make_head, monkeypatch):
    """With a factor wrong in one gradient, the steps differ."""
    model = make_head().train()
    wanted = one_step(model, True)[1]
    monkeypatch.setattr(
        "omnivat.model.closed.features.theta_back",
        lambda grad, theta, rank, channels: torch.zeros_like(theta),
    )
    assert not torch.allclose(one_step(model, False)[1]["mffa.theta.vis"], wanted["mffa.theta.vis"])


@pytest.mark.slow
@pytest.mark.parametrize("signed", [False, True], ids=["positive θ", "θ of both signs"])
@pytest.mark.parametrize("with_lang", [True, False])
def test_features_agree_with_finite_differences(make_head, signed, with_lang):
    torch.manual_seed(0)
    pairs, width, rows = 3, 8, 2 + with_lang
    weights = [
        w.detach().clone().requires_grad_()
        for w in make_head(width=width).mffa.fratt.closed_weights
    ]
    theta = (torch.rand(rows, 2, dtype=torch.float64) + 0.5) * (
        torch.tensor([1.0, -1.0]) if signed else 1.0
    )
    told = Pass(
        length=2.0,
        unit=True,
        roots=(width**0.5, 1.0),
        channels=2,
        lang_on=torch.tensor([True, False, True]),
        class_mix=torch.rand(pairs, pairs, dtype=torch.float64),
        agnostic=draw(rows, pairs, width),
    )
    inputs = [draw(2, pairs, width), draw(1, pairs, width) if with_lang else None]
    inputs += [torch.tensor(0.4, dtype=torch.float64), theta]
    inputs = [None if x is None else x.requires_grad_() for x in inputs]

    def features(embedding, lang, order, theta, *weights):
        return closed_features(embedding, lang, order, theta, weights, told).features

    assert torch.autograd.gradcheck(features, (*inputs, *weights))


@pytest.mark.parametrize("arrangement", ["tree", "series", "parallel"])
def test_growth_agrees_with_finite_differences(arrangement):
    grown_from = parents(arrangement, 7)[1:]
    inputs = [x.requires_grad_() for x in (draw(2, 4), draw(6, 4, 4), draw(6, 4))]
    assert torch.autograd.gradcheck(lambda *x: grown_nodes(*x, grown_from), inputs)


def test_unit_rows_agree_with_finite_differences_and_zero_stays_zero():
    assert torch.autograd.gradcheck(unit, [draw(3, 5).requires_grad_()])
    zero = torch.zeros(2, 4, requires_grad=True)
    unit(zero).sum().backward()
    assert not unit(zero).any()
    assert zero.grad.isfinite().all()


@pytest.mark.parametrize("order", [0.0, 0.3, 1.0, -7.6])
@pytest.mark.parametrize("width", [5, 16])
def test_the_transform_of_a_batch_is_the_transform(order, width):
    embedding = draw(2, 3, width)
    turn = turn_of(torch.tensor(order, dtype=torch.float64), embedding)
    channels = turned(embedding, turn, 2).channels
    wanted = dfrft(embedding, order)
    torch.testing.assert_close(channels, torch.stack((wanted.real, wanted.imag), dim=2))
