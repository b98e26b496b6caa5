"""The reference: a training step and the losses of the fast head against it, and its export."""

import numpy as np
import pytest
import torch

from omnivat.head import plain
from omnivat.head.losses import joint_loss
from omnivat.kit.shapes import unit

from . import oracle

LABELS = torch.tensor([0, 1, 2, 3, 4, 0, 1])
VARIANTS = [
    {},
    {"complex_to_real": "real"},
    {"complex_to_real": "magnitude"},
    {"complex_to_real": "hermitian"},
    {"order_per_modality": True},
    {"class_token": False},
    {"feature_scale": "literal"},
    {"attention_scale": "outside"},
    {"expansion": 1},
    {"learn_order": False},
    {"order": 3.7},
    {"guide": "added"},
    {"guide": "query"},
    {"guide_length": "unit"},
    {"generation": "series"},
    {"generation": "parallel"},
    {"generation": "none"},
    {"generation": "interpolation"},
    {"mffa": False},
]


def draw(*shape):
    return torch.randn(shape, dtype=torch.float64)


def step(model, *, by_reference, lang=True, tac=True, order=None):
    """Return the loss, all gradients and the mean tokens of one batch."""
    torch.manual_seed(2)
    given = {"vis": draw(7, 24), "tac": draw(7, 24) if tac else None}
    text = draw(7, 8) if lang else None
    masks = {"lang_on": torch.rand(7) < 0.5, "token_on": torch.rand(7) < 0.5}
    model.zero_grad()
    if by_reference:
        images = {name: x for name, x in given.items() if x is not None}
        output = oracle.training_pass(model, images, text, LABELS, **masks, order=order)
        loss = oracle.joint_loss(output, LABELS)
    else:
        output = model.training_pass(*given.values(), text, LABELS, **masks, order=order)
        parts = {"features": output.features, "layers": output.layers, "logits": output.logits}
        loss = joint_loss(**parts, labels=LABELS).total
    loss.backward()
    grads = {name: p.grad for name, p in model.named_parameters() if "key.bias" not in name}
    return loss.detach(), grads, output.tokens


def assert_same_step(model, **batch):
    (loss, grads, tokens), (wanted_loss, wanted, wanted_tokens) = (
        step(model, by_reference=exact, **batch) for exact in (False, True)
    )
    torch.testing.assert_close(loss, wanted_loss, rtol=1e-11, atol=1e-12)
    for name, grad in wanted.items():
        if grad is not None and grads[name] is not None:
            atol = 1e-10 * (1 + float(grad.abs().max()))
            torch.testing.assert_close(grads[name], grad, rtol=0, atol=atol, msg=name)
        else:
            assert all(g is None or not g.any() for g in (grads[name], grad)), name
    for name, token in tokens.items():
        torch.testing.assert_close(token, wanted_tokens[name])


@pytest.mark.parametrize("theta", ["ones", "signed", "normal"])
@pytest.mark.parametrize("change", VARIANTS, ids=str)
def test_a_training_step_equals_that_of_the_reference(make_head, theta, change):
    model = make_head(theta=theta, **change).train()
    for lang, tac in ((True, True), (False, True), (True, False)):
        assert_same_step(model, lang=lang, tac=tac)


@pytest.mark.parametrize("order", [0.3, [0.3] * 7, [0.1, 0.9, 0.4, 1.7, 0.0, 1.0, -0.2]], ids=str)
def test_a_step_at_orders_of_the_batch_equals_that_of_the_reference(make_head, order):
    model = make_head(learn_order=False).train()
    assert_same_step(model, order=torch.tensor(order, dtype=torch.float64))


def test_the_transform_is_the_printed_sum_over_eigenvectors():
    """Against numpy's FFT at order 1, and by its law p + q."""
    x, one = draw(3, 16), torch.ones((), dtype=torch.float64)
    found = torch.complex(*plain.transform(x, one))
    wanted = torch.from_numpy(np.fft.fft(x.numpy(), norm="ortho"))
    torch.testing.assert_close(found, wanted)
    half = plain.transform(x, one / 2)
    again = [torch.complex(*plain.transform(part, one / 2)) for part in half]
    torch.testing.assert_close(again[0] + 1j * again[1], wanted)


def test_unit_rows_agree_with_finite_differences_and_zero_stays_zero():
    assert torch.autograd.gradcheck(unit, [draw(3, 5).requires_grad_()])
    zero = torch.zeros(2, 4, requires_grad=True)
    unit(zero).sum().backward()
    assert not unit(zero).any()
    assert zero.grad.isfinite().all()
