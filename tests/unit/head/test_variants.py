"""The settings of the paper's ablations: each has the effect of its name."""

import pytest
import torch

from omnivat.head.head import build_head, parameter_count
from omnivat.head.losses import joint_loss
from omnivat.head.training import training_pass
from omnivat.kit.stages import IMAGES
from tests.builders import head_settings

from .oracle import Slow

CORE = {"input_width": 512, "lang_width": 512, "width": 512}


# ---- counts --------------------------------------------------------------------------------------


STYLE_NUMBERS = 80 * 512  # of PromptStyler's word vectors, which are not part of a head


@pytest.mark.parametrize(
    ("profile", "count", "with_styles"),
    [
        (head_settings(**CORE), 4_466_189, "4.51"),  # projections only where widths differ
        (head_settings(**CORE, project=True, shared_projection=True), 4_991_501, "5.03"),
        (head_settings(**(CORE | {"width": 64})), 169_357, "0.21"),  # the paper's 0.2 million
    ],
    ids=["core", "match", "light"],
)
def test_every_profile_has_the_parameters_that_were_counted(profile, count, with_styles):
    assert parameter_count(profile) == count
    assert f"{(count + STYLE_NUMBERS) / 1e6:.2f}" == with_styles


# ---- every setting against the slow head ---------------------------------------------------------

LABELS = torch.tensor([0, 1, 2, 3, 4, 0, 1])
CHANGES = [
    {},
    {"complex_to_real": "real"},
    {"complex_to_real": "magnitude"},
    {"order_per_modality": True},
    {"class_token": False},
    {"feature_scale": "literal"},
    {"attention_scale": "outside"},
    {"expansion": 9},
    {"levels": 1},
    {"learn_order": False, "order": 3.7},
    {"guide": "added"},
    {"guide": "query"},
    {"guide_length": "unit"},
    {"shared_projection": True},
    {"tree_at_inference": False},
    {"generation": "series"},
    {"generation": "parallel"},
    {"generation": "none"},
    {"generation": "interpolation"},
    {"mffa": False},
]


# θ of another start is another row of numbers, whatever the setting
STARTS = [{"theta": "ones"}, {"theta": "signed"}, *({"theta": "normal"} | one for one in CHANGES)]
EACH = pytest.mark.parametrize("change", STARTS, ids=str)


@EACH
def test_a_prediction_is_that_of_the_slow_head(make_head, make_pairs, change):
    model, given = make_head(**change), dict(zip(IMAGES, make_pairs(7), strict=True))
    for order in (None, 1.0, -1.7):
        p = order if order is None else torch.tensor(order, dtype=torch.float64)
        with torch.no_grad():
            bars, hats, probabilities = Slow(model).predict(given, p)
            folded = model(**given, order=order)
        for output in (folded, model(**given, order=order)):  # with gradients, folded anew
            wanted = zip(IMAGES, bars, hats, strict=True)
            for name, bar, hat in wanted:
                torch.testing.assert_close(output.f_bar[name], bar, rtol=0, atol=1e-12)
                torch.testing.assert_close(output.f_hat[name], hat, rtol=0, atol=1e-12)
            assert (output.probabilities - probabilities).abs().max() < 1e-12


@pytest.mark.parametrize("kind", ["tokens", "real", "magnitude"])
def test_f_is_the_mean_of_the_tokens_of_each_part(make_head, make_pairs, kind):
    model, (vis, tac) = make_head(complex_to_real=kind), make_pairs(7)
    slow = Slow(model)
    with torch.no_grad():
        output = model(vis, tac)
        turned, tokens = slow.tokens("vis", slow.embedded("vis", vis), None)
    parts = 2 if model.settings.complex_to_real == "tokens" else 1
    torch.testing.assert_close(torch.complex(*output.frft["vis"]), turned)
    for part, mean in enumerate(tokens.unflatten(1, (parts, -1)).mean(2).unbind(1)):
        torch.testing.assert_close(output.relu["vis"][part], mean)


def gradients(model, loss):
    model.zero_grad()
    loss.backward()
    # the softmax ignores the bias of keys: its gradient is rounding
    return {n: p.grad for n, p in model.named_parameters() if "key.bias" not in n}


def assert_same_step(model, names=IMAGES, *, lang=True, order=None):
    torch.manual_seed(2)
    images = {name: torch.randn(7, 24, dtype=torch.float64) for name in names}
    text = torch.randn(7, 8, dtype=torch.float64) if lang else None
    masks = {"lang_on": torch.rand(7) < 0.5, "token_on": torch.rand(7) < 0.5}
    output, aligned = training_pass(model, images, text, LABELS, **masks, order=order), LABELS < 3
    loss = joint_loss(output, LABELS, aligned=aligned, mma_weight=3, nod_weight=2).total
    slow = Slow(model).loss(images, text, LABELS, **masks, aligned=aligned, order=order)
    torch.testing.assert_close(loss, slow, rtol=1e-11, atol=1e-12)
    found, wanted = gradients(model, loss), gradients(model, slow)
    for name, grad in wanted.items():
        both = [torch.zeros(1) if g is None else g for g in (found[name], grad)]
        if found[name] is None or grad is None:
            assert not any(g.any() for g in both), name
        else:
            atol = 1e-10 * (1 + float(grad.abs().max()))
            torch.testing.assert_close(*both, rtol=0, atol=atol, msg=name)


@EACH
def test_a_training_step_is_that_of_the_slow_head(make_head, change):
    model = make_head(**change).train()
    assert_same_step(model)
    assert_same_step(model, lang=False)
    assert_same_step(model, ("vis",))


@pytest.mark.parametrize("order", [0.3, [0.3] * 7, [0.1, 0.9, 0.4, 1.7, 0.0, 1.0, -0.2]], ids=str)
def test_a_step_at_orders_of_the_batch_is_that_of_the_slow_head(make_head, order):
    model = make_head(learn_order=False).train()
    assert_same_step(model, order=torch.tensor(order, dtype=torch.float64))


# ---- starts of θ_e and of the tree ---------------------------------------------------------------


def test_theta_starts_as_its_name_says(make_head):
    starts = {name: make_head(theta=name).mffa.theta["vis"] for name in ("ones", "signed")}
    assert starts["ones"].tolist() == [1, 1, 1, 1]
    assert starts["signed"].tolist() == [1, -1, 1, -1]
    spread = build_head(head_settings(**CORE)).mffa.theta["vis"]  # the default
    torch.testing.assert_close(spread, torch.tensor([0.5, 5 / 6, 7 / 6, 1.5]))
    assert make_head(theta="spread", expansion=1).mffa.theta["vis"].tolist() == [1.0]
    normal = make_head(theta="normal").mffa.theta
    assert normal["vis"].tolist() != normal["tac"].tolist()
