"""The contract of the methods from outside the project, run for each over one small source."""

from dataclasses import replace
from functools import cache

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.encoders.clip import open_clip
from omnivat.encoders.clip_live import LiveClip
from omnivat.encoders.lang.clip_prompts import ClipPrompts
from omnivat.encoders.running import CLIP_MEAN, CLIP_STD, pixels
from omnivat.kit.errors import DataError
from omnivat.kit.tables import load
from omnivat.study.baselines import BASELINES, LABELS, ldc, mmrl, spg
from omnivat.study.baselines.contract import Live, Source
from omnivat.study.baselines.contrastive import supcon_loss
from omnivat.study.baselines.mmrl import PROMPT
from omnivat.study.baselines.text import SCALE, arcface, scaled_cosines

pytestmark = pytest.mark.slow  # each method trains, on a CLIP of its own
CLASSES, WIDTH = ("wood", "steel", "glass"), 24
BY_TEXT = ("zero_shot", "promptstyler", "spg")
LIVE = ("mmrl", "ldc")
METHODS = (*BY_TEXT, *LIVE, "sitr_supcon")


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


@cache
def painted(name, row, tint=0.6):
    """A noisy image in the colours of its class, ten rows each, under a reddish light."""
    random = np.random.default_rng([row, name == "vis"])
    colours = (1 - tint) * np.roll((220, 120, 20), row // 10) + tint * np.array((200, 60, 60))
    noisy = colours + random.normal(0, 25, (96, 96, 3))
    return Image.fromarray(noisy.clip(0, 255).astype(np.uint8))


@pytest.fixture(scope="module")
def clip(clips, tmp_path_factory):
    """A small CLIP ViT that has learned the classes in plain light, in OpenAI's layout."""
    model = clips.small_model().train()
    images = torch.stack(
        [pixels(painted("seen", row, 0.0), CLIP_MEAN, CLIP_STD, 96) for row in range(30)]
    )
    prompts = [PROMPT.format(name) for name in CLASSES]
    texts = clips.tokenizer()(
        prompts, padding=True, truncation=True, max_length=16, return_tensors="pt"
    )
    optimiser = torch.optim.AdamW(model.parameters(), lr=1e-3)
    for _ in range(20):
        logits = model(pixel_values=images, **texts).logits_per_image
        optimiser.zero_grad()
        torch.nn.functional.cross_entropy(logits, torch.arange(30) // 10).backward()
        optimiser.step()
    file = clips.write("OpenAI state dict", tmp_path_factory.mktemp("clip"), model.eval())
    return LiveClip(open_clip("clip", file), torch.device("cpu"))


@pytest.fixture(scope="module")
def source(tower, clip):
    """Thirty pairs whose classes lie where the tower has their names."""
    random = torch.Generator().manual_seed(0)
    with torch.no_grad():
        plain = tower.embed_contexts(tower.words("a photo of a")[None], CLASSES)[0]
    plain = torch.nn.functional.normalize(plain - plain.mean(0), dim=-1) * 3
    labels = torch.arange(3).repeat_interleave(10)

    def drawn(spread, *shape):
        return spread * torch.randn(*shape, generator=random)

    return Source(
        vis=plain[labels] + drawn(0.3, 30, WIDTH),
        tac=plain[labels] + drawn(0.3, 30, WIDTH),
        labels=labels,
        objects=tuple(f"{label}/{i % 5}" for i, label in enumerate(labels.tolist())),
        classes=CLASSES,
        lang=plain[:, None] + drawn(0.1, 3, 6, WIDTH),
        lang_of_images=True,
        plain=plain,
        logit_scale=20.0,
        prompts=lambda: tower,
        live=Live(read=painted, load=lambda: clip, rows=torch.arange(30)),
    )


def inputs(fitted, source):
    """Return what a method takes of a source's pairs: embeddings, or images."""
    if not fitted.images:
        return source.vis, source.tac
    rows = torch.arange(len(source))
    return source.live.images("vis", rows), source.live.images("tac", rows)


def fit(name, source):
    return load(BASELINES, name, kind="baseline")(source)


@pytest.fixture(scope="module", autouse=True)
def short():
    """Fewer steps than published: enough for thirty pairs."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(mmrl, "HOW", replace(mmrl.HOW, epochs=12))
        patch.setattr(ldc, "LEAST", 130)
        for name in ("PROMPT_EPOCHS", "GAN_EPOCHS"):
            patch.setattr(spg, name, 8)
        yield


@pytest.fixture(scope="module")
def fitted(source):
    return {name: fit(name, source) for name in METHODS}


@pytest.mark.parametrize("name", METHODS)
def test_it_gives_probabilities_alike_alone_and_in_a_batch(name, source, fitted):
    vis, tac = inputs(fitted[name], source)
    found = fitted[name].predict(vis, tac)
    assert set(found) == {"fused", "vis", "tac"}
    for values in found.values():
        torch.testing.assert_close(values.sum(-1), torch.ones(30))
    alone = fitted[name].predict(vis[4:5], tac[4:5])
    for key, values in found.items():
        torch.testing.assert_close(alone[key], values[4:5], atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("name", [name for name in METHODS if name != "spg"])
def test_it_overfits_a_small_source(name, source, fitted):
    """Not asked of SPG: the prompt of a random text tower need not tell classes apart."""
    answers = fitted[name].predict(*inputs(fitted[name], source))["fused"].argmax(-1)
    assert (answers == source.labels).float().mean() > 0.9


@pytest.mark.parametrize("name", ["spg", *LIVE, "sitr_supcon", "promptstyler"])
def test_it_is_deterministic_and_leaves_the_global_stream(name, source, fitted):
    before = torch.random.get_rng_state()
    given = inputs(fitted[name], source)
    again = fit(name, source).predict(*given)["fused"]
    assert torch.equal(torch.random.get_rng_state(), before)
    assert torch.equal(again, fitted[name].predict(*given)["fused"])


def test_a_source_with_nan_is_refused_before_anything_learns(source):
    spoilt = source.tac.clone()
    spoilt[3, 2] = torch.nan
    with pytest.raises(DataError, match="tac has NaN or infinite values"):
        replace(source, tac=spoilt)


@pytest.mark.parametrize("name", METHODS)
def test_only_methods_of_text_need_text(name, source):
    bare = replace(
        source.select(torch.arange(0, 30, 2)),
        lang=None,
        plain=None,
        prompts=None,
        why_no_lang="No LANG bank is used.",
    )
    if name in BY_TEXT:
        with pytest.raises(DataError, match="needs the classes' texts. No LANG bank"):
            fit(name, bare)
    else:
        found = fit(name, bare)
        assert found.predict(*inputs(found, bare))["fused"].shape == (15, 3)


@pytest.mark.parametrize("name", METHODS)
def test_its_note_says_exact_or_surrogate(name):
    assert LABELS[name].note.startswith(("exact", "surrogate", "ours"))


def test_spg_without_a_tower_says_how_to_get_one(source):
    with pytest.raises(DataError, match="live text tower.*omnivat prompts"):
        fit("spg", replace(source, prompts=None))


# The mathematics


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
