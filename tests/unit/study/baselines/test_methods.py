"""Every method learns a small source, repeats itself, and says when it cannot run."""

from dataclasses import replace
from functools import cache

import pytest
import torch

from omnivat.encoders.lang.clip_prompts import ClipPrompts
from omnivat.head import linear_maps as maps
from omnivat.kit.errors import DataError
from omnivat.kit.tables import load
from omnivat.study.baselines import BASELINES, LABELS, contrastive, robust_vish, spg
from omnivat.study.baselines.contract import Source
from omnivat.study.baselines.contrastive import contrastive_loss, supcon_loss
from omnivat.study.baselines.descent import rate
from omnivat.study.baselines.text import SCALE, arcface, scaled_cosines
from tests.builders import CLASSES

BY_TEXT = ("zero_shot", "promptstyler", "spg")
OF_CLIP = (*BY_TEXT, "sitr_supcon")  # test_live has those that learn inside a CLIP
QUICK = tuple(name for name in BASELINES if name not in (*OF_CLIP, "mmrl", "ldc", "robust_vish"))
SLOW = [pytest.param(name, marks=pytest.mark.slow) for name in OF_CLIP]
ALL = [*QUICK, *SLOW]
MATERIALS, WIDTH = ("wood", "steel", "glass"), 24


def fit(name, source):
    return load(BASELINES, name, kind="baseline")(source)


@pytest.fixture(scope="module")
def source(make_embeddings):
    return as_source(make_embeddings(domains=("TAG-sim",)))


def as_source(pairs, **changes):
    values = {
        name: torch.from_numpy(getattr(pairs, name))
        for name in ("vis", "tac", "vis_flip", "tac_flip")
    }
    values |= {
        "labels": torch.from_numpy(pairs.label),
        "objects": tuple(pairs.rows["object"]),
        "classes": CLASSES,
        "lang": torch.randn(5, 6, 7, generator=torch.Generator().manual_seed(0)),
    }
    return Source(**(values | changes))


@pytest.fixture(scope="module")
def tower(clips):
    """A small random text tower that takes prompts spelt by letters."""
    import transformers

    whole = clips.small_model()
    config = whole.config.text_config
    config.projection_dim, config.max_position_embeddings = WIDTH, 32
    torch.manual_seed(0)
    network = transformers.CLIPTextModelWithProjection(config)
    return ClipPrompts(network, clips.tokenizer())


@pytest.fixture(scope="module")
def clip_source(tower):
    """Thirty pairs whose classes lie where the tower has their names."""
    random = torch.Generator().manual_seed(0)
    with torch.no_grad():
        plain = tower.embed_contexts(tower.words("a photo of a")[None], MATERIALS)[0]
    plain = torch.nn.functional.normalize(plain - plain.mean(0), dim=-1) * 3
    labels = torch.arange(3).repeat_interleave(10)

    def drawn(spread, *shape):
        return spread * torch.randn(*shape, generator=random)

    return Source(
        vis=plain[labels] + drawn(0.3, 30, WIDTH),
        tac=plain[labels] + drawn(0.3, 30, WIDTH),
        labels=labels,
        objects=tuple(f"{label}/{i % 5}" for i, label in enumerate(labels.tolist())),
        classes=MATERIALS,
        lang=plain[:, None] + drawn(0.1, 3, 6, WIDTH),
        lang_of_images=True,
        plain=plain,
        logit_scale=20.0,
        prompts=lambda: tower,
    )


@pytest.fixture(scope="module", autouse=True)
def short():
    """Fewer steps than published: enough for thirty pairs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(maps, "STEPS", 60)
        patch.setattr(robust_vish, "HOW", replace(robust_vish.HOW, epochs=1))
        for name in ("PROMPT_EPOCHS", "GAN_EPOCHS"):
            patch.setattr(spg, name, 8)
        yield


@pytest.fixture(scope="module")
def learned(request):
    """Return name -> fitted method, its source, and what it takes of it; each is fitted once."""

    @cache
    def of(name):
        source = request.getfixturevalue("clip_source" if name in OF_CLIP else "source")
        fitted = fit(name, source)
        return fitted, source, (source.vis, source.tac)

    return of


@pytest.fixture
def brief(monkeypatch):
    """Hardly any step: what is learned does not matter."""
    monkeypatch.setattr(contrastive, "HOW", replace(contrastive.HOW, epochs=2))
    monkeypatch.setattr(maps, "STEPS", 9)


def right(fitted, source):
    answers = fitted.predict(source.vis, source.tac)["fused"].argmax(-1)
    return (answers == source.labels).double().mean().item()


@pytest.mark.parametrize("name", [*ALL, "robust_vish"])
def test_it_gives_probabilities_alike_alone_and_in_a_batch(name, learned):
    fitted, source, (vis, tac) = learned(name)
    found = fitted.predict(vis, tac)
    assert set(found) == {"fused", "vis", "tac"}
    alone = fitted.predict(vis[4:5], tac[4:5])
    for key, values in found.items():
        assert values.shape == (len(source), len(source.classes))
        torch.testing.assert_close(values.sum(-1), torch.ones(len(source)))
        torch.testing.assert_close(alone[key], values[4:5], atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("name", [one for one in ALL if one is not SLOW[2]])
def test_it_learns_its_source(name, learned):
    """Not asked of SPG: the prompt of a random text tower need not tell classes apart."""
    fitted, source, _ = learned(name)
    assert right(fitted, source) > 0.9
    assert fitted.parameters > 0 or name == "zero_shot"


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("modality", ["vis", "tac"])
def test_a_reading_of_one_modality_does_not_see_the_other_image(name, modality, learned):
    fitted, _, (vis, tac) = learned(name)
    other = (vis, tac.flip(0) * 2 + 1) if modality == "vis" else (vis.flip(0) * 2 + 1, tac)
    assert torch.equal(fitted.predict(vis, tac)[modality], fitted.predict(*other)[modality])


@pytest.mark.usefixtures("brief")
@pytest.mark.parametrize("name", ["erm_mlp", "linear_maps", "promptstyler", "spg"])
def test_the_same_seed_gives_the_same_answers_and_leaves_the_global_stream(name, learned):
    _, source, images = learned(name)
    before = torch.random.get_rng_state()
    fitted, again = fit(name, source), fit(name, source)
    assert torch.equal(torch.random.get_rng_state(), before)
    assert torch.equal(again.predict(*images)["fused"], fitted.predict(*images)["fused"])


@pytest.mark.slow
@pytest.mark.parametrize("name", BY_TEXT)
def test_methods_of_text_need_text(name, clip_source):
    bare = replace(clip_source, lang=None, plain=None, prompts=None, why_no_lang="No bank is used.")
    with pytest.raises(DataError, match="needs the classes' texts. No bank"):
        fit(name, bare)


def test_methods_that_live_on_text_refuse_texts_of_another_encoder(source):
    with pytest.raises(DataError, match="needs texts in the image encoder's own space"):
        fit("promptstyler", source)


@pytest.mark.slow
def test_spg_without_a_tower_says_how_to_get_one(clip_source):
    with pytest.raises(DataError, match="live text tower.*omnivat prompts"):
        fit("spg", replace(clip_source, prompts=None))


def test_a_source_with_nan_is_refused_before_anything_learns(source):
    spoilt = source.tac.clone()
    spoilt[3, 2] = torch.nan
    with pytest.raises(DataError, match="tac has NaN or infinite values"):
        replace(source, tac=spoilt)


def test_every_baseline_loads_and_those_of_others_say_exact_or_surrogate():
    assert set(LABELS) == set(BASELINES)
    assert all(callable(load(BASELINES, name, kind="baseline")) for name in BASELINES)
    assert all(
        LABELS[name].note.startswith(("exact", "surrogate")) for name in (*OF_CLIP, "mmrl", "ldc")
    )


# The mathematics


def test_the_contrastive_loss_is_small_for_pairs_that_belong_together():
    rows = torch.eye(4)
    assert contrastive_loss(rows, rows).item() == pytest.approx(0, abs=1e-4)
    assert contrastive_loss(rows, rows.roll(1, 0)).item() > 10


def test_the_rate_rises_then_falls_to_almost_nothing():
    rates = [rate(step, 100, 0.1) for step in range(100)]
    assert rates[9] == 1.0
    assert rates[0] == pytest.approx(0.1)
    assert rates[-1] < 0.01
    assert rates[10:] == sorted(rates[10:], reverse=True)


def test_spg_has_the_size_and_the_clips_of_its_code():
    """4,708,225 parameters at D = 512 fix the layers; the clips differ by layer."""
    prompt = torch.randn(4, 512)
    nets = spg.Generator(512, (4, 512)), spg.Discriminator(512, (4, 512))
    assert sum(p.numel() for net in nets for p in net.parameters()) == 4_708_225
    slopes = [getattr(layer, "negative_slope", 0.2) for net in nets for layer in net.layers]
    assert set(slopes) == {0.2}
    optimisers = [torch.optim.AdamW(net.parameters(), lr=0.0) for net in nets]
    images = 1e3 * torch.randn(2, 8, 512)
    spg._gan_step(*nets, optimisers, *images, prompt)
    norms = {name: float(p.grad.norm()) for name, p in nets[0].named_parameters()}
    assert norms["layers.2.weight"] == pytest.approx(5e-3, rel=1e-2)
    assert norms["layers.2.bias"] <= 5.1e-8 < norms["layers.11.bias"] <= 1.01


def test_arcface_turns_the_true_class_away_by_half_a_radian():
    angle = torch.tensor(0.3)
    rows, weight = torch.tensor([[angle.cos(), angle.sin()]]), torch.eye(2)
    logits = SCALE * torch.stack([torch.cos(angle + 0.5), angle.sin()])
    wanted = torch.nn.functional.cross_entropy(logits[None], torch.tensor([0]))
    torch.testing.assert_close(arcface(rows, weight, torch.tensor([0])), wanted)
    torch.testing.assert_close(scaled_cosines(rows, 7 * weight)[0, 0], SCALE * angle.cos())


def test_supcon_is_small_where_labels_gather_and_skips_rows_without_a_partner():
    rows = torch.eye(3)[torch.tensor([0, 0, 1, 1, 2])]
    gathered = supcon_loss(rows, torch.tensor([0, 0, 1, 1, 2]))
    mixed = supcon_loss(rows, torch.tensor([0, 1, 0, 1, 2]))
    assert gathered < 1e-4 < 5 < mixed
    assert supcon_loss(rows[:2], torch.tensor([0, 1])).item() == 0
