"""The settings of the paper's ablations: each has the effect of its name."""

import pytest
import torch

from omnivat.head import plain
from omnivat.head.dtg import DTG, interpolated
from omnivat.head.head import parameter_count
from omnivat.head.losses import nod_loss
from omnivat.head.mffa import FrATT
from omnivat.head.settings import HeadSettings, literal

CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")
CORE = {"classes": CLASSES, "input_width": 512, "lang_width": 512, "width": 512}


# ---- counts --------------------------------------------------------------------------------------


STYLE_NUMBERS = 80 * 512  # of PromptStyler's word vectors, which are not part of a head


@pytest.mark.parametrize(
    ("profile", "count", "with_styles"),
    [
        (HeadSettings(**CORE), 4_466_189, "4.51"),  # projections only where widths differ
        (HeadSettings(**CORE, project=True, shared_projection=True), 4_991_501, "5.03"),
        (literal(HeadSettings(**CORE)), 4_466_189, "4.51"),  # as printed; it does not train
        (HeadSettings(**(CORE | {"width": 64})), 169_357, "0.21"),  # the paper's 0.2 million
    ],
    ids=["core", "match", "literal", "light"],
)
def test_every_profile_has_the_parameters_that_were_counted(profile, count, with_styles):
    assert parameter_count(profile) == count
    assert f"{(count + STYLE_NUMBERS) / 1e6:.2f}" == with_styles


@pytest.mark.parametrize(
    ("change", "fewer"),
    [
        ({"generation": "series"}, 0),
        ({"generation": "parallel"}, 0),
        ({"generation": "interpolation"}, 6 * (512**2 + 512)),
        ({"generation": "none"}, 6 * (512**2 + 512)),
        ({"mffa": False}, 11 * 512**2 + 8 * 512 + 12 + 1),
        ({"order_per_modality": True}, -2),
        ({"learn_order": False}, 1),
        ({"complex_to_real": "hermitian"}, 0),
        ({"complex_to_real": "magnitude"}, 0),
        ({"complex_to_real": "real"}, 0),
    ],
    ids=str,
)
def test_a_setting_changes_the_count_by_its_own_matrices_alone(change, fewer):
    whole = parameter_count(HeadSettings(**CORE))
    assert whole - parameter_count(HeadSettings(**CORE, **change)) == fewer


# ---- generation ----------------------------------------------------------------------------------


@pytest.mark.parametrize("arrangement", ["tree", "series", "parallel"])
@pytest.mark.parametrize("levels", [1, 2, 4])
def test_every_arrangement_folds_into_its_mean(arrangement, levels):
    torch.manual_seed(0)
    tree = DTG(8, levels=levels, arrangement=arrangement).double()
    torch.nn.init.normal_(tree.bias)
    root = torch.randn(5, 8, dtype=torch.float64)
    matrix, offset = tree.fold()
    assert tree.grow(root).nodes.shape == (5, 2**levels - 1, 8)
    torch.testing.assert_close(root @ matrix.T + offset, tree.grow(root).nodes.mean(1))
    assert nod_loss(tree.grow(root).groups).isfinite()


def test_interpolated_points_lie_at_eighths_between_vis_and_tac():
    vis, tac = torch.zeros(1, 2), torch.tensor([[8.0, 16.0]])
    points = interpolated(torch.stack((vis, tac)), 3)[0]
    torch.testing.assert_close(points, torch.arange(1.0, 8.0)[:, None] * torch.tensor([1.0, 2.0]))


def test_interpolation_adds_the_middle_of_vis_and_tac(make_head, make_pairs):
    model, given = make_head(generation="interpolation"), make_pairs(4)
    with torch.no_grad():
        output = model(*given, nodes=True)
        alone = model(given[0], None, nodes=True)
    middle = (output.f_bar["vis"] + output.f_bar["tac"]) / 2
    torch.testing.assert_close(output.f_hat["vis"], output.f_bar["vis"] + middle)
    torch.testing.assert_close(output.nodes.mean(1), middle)
    torch.testing.assert_close(alone.f_hat["vis"], 2 * alone.f_bar["vis"])
    assert output.nodes.shape == (4, 7, 16)


def test_without_generation_features_are_classified_as_they_are(make_head, make_pairs):
    with torch.no_grad():
        output = make_head(generation="none")(*make_pairs(4), nodes=True)
    torch.testing.assert_close(output.f_hat["tac"], output.f_bar["tac"])
    assert output.nodes is None


# ---- DTG without MFFA ----------------------------------------------------------------------------


def test_without_mffa_the_tree_grows_from_the_embeddings_at_any_order(make_head, make_pairs):
    model = make_head(mffa=False, input_width=16, standardize=False)
    vis, tac = make_pairs(4, 16)
    units = [torch.nn.functional.normalize(x, dim=-1) for x in (vis, tac)]
    with torch.no_grad():
        for order in (None, 0.0, 0.6):
            output = model(vis, tac, order=order, nodes=True)
            torch.testing.assert_close(output.f_bar["vis"], units[0])
            mean = model.dtg.grow(units[0] + units[1]).nodes.mean(1)
            torch.testing.assert_close(output.f_hat["tac"], units[1] + mean)
    assert model.order == 0.0


def test_without_mffa_training_adds_lang_to_the_root_and_aligns_nothing(make_head, make_pairs):
    model = make_head(mffa=False, input_width=16, standardize=False)
    lang, labels = torch.randn(3, 8, dtype=torch.float64), torch.tensor([0, 1, 2])
    on = torch.tensor([True, True, False])
    output = model.training_pass(*make_pairs(3, 16), lang, labels, lang_on=on)
    text = torch.nn.functional.normalize(model.project_lang(lang), dim=-1)
    wanted = output.features["vis"] + output.features["tac"] + text * on[:, None]
    torch.testing.assert_close(output.layers[0][:, 0], wanted)
    assert set(output.features) == {"vis", "tac"}


# ---- complex to real -----------------------------------------------------------------------------


def test_hermitian_attention_is_that_of_complex_numbers():
    torch.manual_seed(0)
    fratt = FrATT(6).double()
    queries, tokens = (torch.randn(2, 2, n, 6, dtype=torch.float64) for n in (3, 4))

    def layer(module, parts):
        whole = torch.complex(*parts)
        return whole @ module.weight.T.to(whole.dtype) + module.bias

    asked, keys, values = (
        layer(module, parts)
        for module, parts in ((fratt.query, queries), (fratt.key, tokens), (fratt.value, tokens))
    )
    weights = torch.softmax((asked @ keys.mH).real / 6**0.5, dim=-1)
    mixed = (weights.to(values.dtype) @ values).mean(1)
    feature, found = plain.attention(fratt, queries, tokens)
    torch.testing.assert_close(found, weights)
    torch.testing.assert_close(feature, fratt.ffn(mixed.abs()))


@pytest.mark.parametrize("kind", ["tokens", "hermitian", "magnitude", "real"])
def test_answers_move_continuously_with_the_order_whatever_becomes_real(
    make_head, make_pairs, kind
):
    model, given = make_head(theta="normal", complex_to_real=kind), make_pairs(6)
    with torch.no_grad():
        for order in (0.0, 0.5, 1.0):
            here, beside = (model(*given, order=order + d).probabilities for d in (0.0, 1e-6))
            assert (here - beside).abs().max() < 1e-4
        apart = model(*given, order=0.0).probabilities - model(*given, order=0.5).probabilities
    assert apart.abs().max() > 1e-3


# ---- orders --------------------------------------------------------------------------------------


def test_an_order_a_modality_turns_each_by_its_own(make_head, make_pairs):
    model, given = make_head(order_per_modality=True), make_pairs(4)
    with torch.no_grad():
        model.mffa.order.copy_(torch.tensor([0.9, 0.2, 0.7]))
        own = model(*given)
        vis, tac = (model(*given, order=p) for p in (0.2, 0.7))
    torch.testing.assert_close(own.f_bar["vis"], vis.f_bar["vis"])
    torch.testing.assert_close(own.f_bar["tac"], tac.f_bar["tac"])
    assert model.orders == pytest.approx({"lang": 0.9, "vis": 0.2, "tac": 0.7})
    assert model.order == pytest.approx(0.45)


# ---- settings ------------------------------------------------------------------------------------


# ---- starts of θ_e and of the tree ---------------------------------------------------------------


@pytest.mark.parametrize("init", ["orthogonal", "default", "identity"])
def test_a_tree_starts_as_its_name_says(init):
    """Orthogonal keeps lengths, identity keeps nodes almost equal, torch's default shrinks them."""
    torch.manual_seed(0)
    nodes = DTG(64, init=init).double().grow(torch.randn(20, 64, dtype=torch.float64)).nodes
    shares = (nodes[:, 1:].norm(dim=-1) / nodes[:, :1].norm(dim=-1)).mean(0)
    likeness = torch.nn.functional.cosine_similarity(nodes[:, 1:], nodes[:, :1], dim=-1)
    if init == "orthogonal":
        torch.testing.assert_close(shares, torch.ones_like(shares))
    elif init == "identity":
        assert likeness.min() > 0.95
    else:
        assert shares[:2].max() < 0.7
        assert shares[2:].max() < 0.45
    if init != "identity":
        assert likeness.mean().abs() < 0.1


def test_theta_starts_as_its_name_says(make_head):
    starts = {name: make_head(theta=name).mffa.theta["vis"] for name in ("ones", "signed")}
    assert starts["ones"].tolist() == [1, 1, 1, 1]
    assert starts["signed"].tolist() == [1, -1, 1, -1]
    normal = make_head(theta="normal").mffa.theta
    assert normal["vis"].tolist() != normal["tac"].tolist()
