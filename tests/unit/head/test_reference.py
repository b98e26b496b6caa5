"""The fast head is the paper's: predictions and every gradient equal those of the reference."""

import torch
from hypothesis import assume, given, settings
from hypothesis import strategies as st

from omnivat.head.head import build_head
from omnivat.head.losses import joint_loss
from omnivat.head.reference import Reference
from omnivat.head.settings import HeadSettings
from omnivat.head.training import training_pass


def both(classes, width, expansion, levels, order, seed):
    """Return the fast head and a reference with its parameters, in double precision."""
    names = tuple(f"class {k}" for k in range(classes))
    fast = build_head(
        HeadSettings(
            classes=names,
            input_width=9,
            lang_width=7,
            width=width,
            project=True,
            expansion=expansion,
            levels=levels,
            standardize=False,
        )
    ).double()
    torch.manual_seed(seed)
    with torch.no_grad():
        for tensor in (*fast.parameters(), fast.mffa.bank):
            tensor.copy_(0.5 * torch.randn(tensor.shape))
        fast.mffa.order.fill_(order)
        fast.mffa.bank_seen.copy_(torch.rand(classes) < 0.7)
    plain = Reference(classes, 9, 7, width, expansion, levels).double()
    plain.load_state_dict(fast.state_dict())
    return fast, plain


SIZES = {
    "classes": st.integers(2, 6),
    "width": st.integers(4, 17),
    "expansion": st.integers(1, 5),
    "levels": st.integers(2, 4),
    "order": st.floats(-2, 2),
    "seed": st.integers(0, 999),
    "names": st.sampled_from([("vis", "tac"), ("vis",), ("tac",)]),
}


@settings(max_examples=15, deadline=None)
@given(**SIZES)
def test_predictions_losses_and_gradients_are_those_of_the_reference(names, seed, **sizes):
    assume(abs(sizes["order"] - round(sizes["order"])) > 1e-6)  # there ReLU has zeros of rounding
    fast, plain = both(seed=seed, **sizes)
    images = {name: torch.randn(6, 9, dtype=torch.float64) for name in names}
    with torch.no_grad():
        quick = fast(images.get("vis"), images.get("tac")).probabilities
    torch.testing.assert_close(quick, plain(images), rtol=0, atol=1e-10)
    lang = torch.randn(6, 7, dtype=torch.float64)
    labels = torch.arange(6) % sizes["classes"]
    on, token_on = torch.rand(6) < 0.5, torch.rand(6) < 0.5
    output = training_pass(fast, images, lang, labels, lang_on=on, token_on=token_on)
    quick, slow = joint_loss(output, labels).total, plain.loss(images, lang, labels, on, token_on)
    torch.testing.assert_close(quick, slow, rtol=1e-9, atol=1e-11)
    quick.backward()
    slow.backward()
    wanted = dict(plain.named_parameters())
    for name, one in fast.named_parameters():
        other = wanted[name]
        if name == "mffa.fratt.key.bias":  # the softmax ignores it: rounding alone
            continue
        if one.grad is not None and other.grad is not None:
            atol = 1e-8 * (1 + float(other.grad.abs().max()))
            torch.testing.assert_close(one.grad, other.grad, rtol=0, atol=atol, msg=name)
        else:
            assert all(grad is None or not grad.any() for grad in (one.grad, other.grad)), name
