"""MMRL and LDC: their parts against their definitions, and what they refuse."""

from dataclasses import replace
from types import SimpleNamespace

import pytest
import torch
from PIL import Image
from torch import nn

from omnivat.encoders.clip import open_clip
from omnivat.encoders.clip_live import LiveClip, load_live
from omnivat.encoders.hub import remember
from omnivat.kit.errors import DataError
from omnivat.study.baselines import ldc, mmrl
from omnivat.study.baselines.contract import Live, Source
from omnivat.study.baselines.ldc import DeConfused, TokenLevels
from omnivat.study.baselines.mmrl import SCALE, Representations
from omnivat.study.baselines.mmrl import fit as fit_mmrl


def live_clip(clips, folder, layout="OpenAI state dict"):
    file = clips.write(layout, folder, clips.small_model())
    return LiveClip(open_clip("clip", file), torch.device("cpu"))


@pytest.fixture
def vit(clips, tmp_path):
    return live_clip(clips, tmp_path)


@pytest.fixture
def resnet(clips, tmp_path):
    clips.tokenizer().save_pretrained(tmp_path)
    torch.save(clips.published_resnet(clips.rn50_state()), tmp_path / "RN.pt")
    return LiveClip(open_clip("clip", tmp_path / "RN.pt"), torch.device("cpu"))


def source_of(clip, classes=("wood", "steel")):
    """Six pairs, one colour a class."""

    def read(name, row):
        return Image.new("RGB", (40, 30), (40 + 20 * row, 200 if row % 2 else 30, len(name)))

    labels = torch.arange(6) % len(classes)
    rows = torch.randn(6, clip.width, generator=torch.Generator().manual_seed(0))
    return Source(
        vis=rows,
        tac=rows,
        labels=labels,
        objects=tuple(map(str, range(6))),
        classes=classes,
        live=Live(read=read, load=lambda: clip, rows=torch.arange(6)),
    )


def test_a_live_clip_gives_the_models_own_embeddings(clips, tmp_path):
    clip = live_clip(clips, tmp_path, "open_clip folder")
    images, texts = torch.randn(3, 3, clips.SIDE, clips.SIDE), ["a photo of wood", "steel"]
    model = clips.small_model()
    torch.testing.assert_close(
        clip.embed(images), clips.image_embeddings(model, images), atol=1e-5, rtol=1e-5
    )
    torch.testing.assert_close(
        clip.embed_texts(texts), clips.text_embeddings(model, texts), atol=1e-5, rtol=1e-5
    )


def test_gradients_pass_through_both_towers_and_change_neither(vit):
    model = Representations(vit)
    before = {name: weight.clone() for name, weight in vit.image.state_dict().items()}
    plain, shared = model.images(torch.randn(2, 3, vit.side, vit.side))
    texts = model.texts(*vit.text_tokens(["wood", "steel"]))
    (SCALE * (plain + shared) @ texts.T).sum().backward()
    for name, weight in model.named_parameters():
        assert weight.grad is not None and weight.grad.abs().max() > 0, name
    assert all(weight.grad is None for weight in vit.image.parameters())
    assert all(torch.equal(before[name], now) for name, now in vit.image.state_dict().items())


def test_the_class_token_and_the_mean_of_the_shared_tokens_are_read_after_the_last_layer(vit):
    model, last = Representations(vit), []
    hook = vit.image_layers[-1].register_forward_hook(lambda *a: last.append(a[2]))
    found = model.images(torch.randn(2, 3, vit.side, vit.side))
    hook.remove()
    token, shared = last[0][:, 0], last[0][:, 1:6]
    normed = vit.image.vision_model.post_layernorm(shared).mean(1)
    wanted = vit.image_end(token), model.projection(normed)
    for mine, other in zip(found, wanted, strict=True):
        torch.testing.assert_close(mine, nn.functional.normalize(other, dim=-1))


def published(layers=12):
    """What the methods ask of ViT-B/16 to size themselves, without its weights."""
    return SimpleNamespace(
        image=SimpleNamespace(visual_projection=nn.Linear(768, 512, bias=False)),
        text=SimpleNamespace(text_projection=nn.Linear(512, 512, bias=False)),
        image_layers=[None] * layers,
        text_layers=[None] * 12,
        width=512,
        is_vit=True,
        device="cpu",
    )


def test_at_vit_b16_their_sizes_are_the_published_codes():
    """MMRL 4,992,256; LDC's adapters and head 3,428,352 and its de-confusion 1,320,448 for five
    classes.
    """
    clip = published()
    assert sum(p.numel() for p in Representations(clip).parameters()) == 4_992_256
    model = DeConfused(clip, torch.zeros(5, 512))
    sizes = {
        name: sum(p.numel() for p in part.parameters()) for name, part in model.named_children()
    }
    assert sizes["levels"] + sizes["head"] == 3_428_352
    assert sum(sizes.values()) - 3_428_352 == 1_320_448


def test_levels_are_layers_6_8_10_and_12_of_twelve():
    assert [number + 1 for number in TokenLevels(published()).after] == [6, 8, 10, 12]
    assert [number + 1 for number in TokenLevels(published(24)).after] == [18, 20, 22, 24]


@pytest.mark.parametrize("kind", ["vit", "resnet"])
def test_ldc_mixes_its_levels_by_their_weights(kind, request):
    """Adapters that pass a level on, alone, give what the definition says."""
    clip = request.getfixturevalue(kind)
    model = DeConfused(clip, torch.eye(3, clip.width)).eval()
    images = torch.randn(2, 3, clip.side, clip.side)
    plain, levels = model.levels(clip, images)
    torch.testing.assert_close(plain, clip.embed(images), atol=1e-5, rtol=1e-4)
    summed = wanted_levels(clip, model.levels, images)
    torch.testing.assert_close(levels, summed, atol=1e-5, rtol=1e-4)
    found = model(images)
    base = clip.logit_scale * nn.functional.normalize(plain, dim=-1) @ torch.eye(3, clip.width).T
    torch.testing.assert_close(found["base"], base)
    share = (found["mixed"] - found["clear"]) / (found["own"] - found["clear"])
    assert (share > 0).all() and (share < 1).all() and share.std(1).max() < 1e-3


def wanted_levels(clip, levels, images):
    """The sum 0.1, 0.2, 0.3, 0.4 of the adapted levels, computed from hooks on the tower."""
    kept = []
    stages = clip.image_layers if clip.is_vit else clip.image.stages
    hooks = [part.register_forward_hook(lambda *a: kept.append(a[2])) for part in stages]
    end = clip.image.visual_projection if clip.is_vit else clip.image.pool
    clip.embed(images)
    for hook in hooks:
        hook.remove()
    chosen = [kept[number] for number in levels.after] if clip.is_vit else kept
    total = torch.zeros(())
    for weight, adapter, level in zip((0.1, 0.2, 0.3, 0.4), levels.adapters, chosen, strict=True):
        adapted = adapter(level)
        total = total + weight * (adapted.mean(1) if clip.is_vit else adapted)
    return end(total)


def test_mmrl_refuses_a_resnet(resnet):
    with pytest.raises(DataError, match="layers of a ViT.*ResNet; embed"):
        fit_mmrl(source_of(resnet))


def test_without_images_the_reason_is_given(vit):
    bare = replace(source_of(vit), live=None, why_not_live="Pass --images FOLDER.")
    with pytest.raises(DataError, match="learns inside CLIP.*not at hand. Pass --images FOLDER."):
        fit_mmrl(bare)


def test_a_live_clip_is_found_by_the_hash_of_its_weights(clips, tmp_path, monkeypatch):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    load_live.cache_clear()
    file = clips.write("OpenAI state dict", tmp_path / "clip", clips.small_model())
    own = open_clip("clip", file).image_hash
    remember(own, file)
    assert load_live("clip", own).width == clips.EMBED
    remember("0" * 16, file)
    with pytest.raises(DataError, match="are not those of the embeddings"):
        load_live("clip", "0" * 16)
    with pytest.raises(DataError, match="one CLIP for both images.*'efficientnet-lite0'"):
        load_live("efficientnet-lite0", "0" * 16)


def test_a_live_clip_without_a_text_tower_is_refused(clips, tmp_path, monkeypatch):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    load_live.cache_clear()
    torch.save({f"visual.{k}": v for k, v in clips.rn50_state().items()}, tmp_path / "RN.pt")
    own = open_clip("clip", tmp_path / "RN.pt").image_hash
    remember(own, tmp_path / "RN.pt")
    with pytest.raises(DataError, match="an image tower and no text tower"):
        load_live("clip", own)


@pytest.mark.slow
@pytest.mark.parametrize(("method", "steps"), [("mmrl", 10), ("ldc", 40)])
def test_they_learn_a_source_the_same_each_time_and_predict_alike_alone(
    method, steps, vit, monkeypatch
):
    module = {"mmrl": mmrl, "ldc": ldc}[method]
    monkeypatch.setattr(module, "HOW", replace(module.HOW, epochs=steps))
    monkeypatch.setattr(ldc, "LEAST", steps)
    source, rows = source_of(vit), torch.arange(6)
    before = torch.random.get_rng_state()
    fitted, again = module.fit(source), module.fit(source)
    assert torch.equal(torch.random.get_rng_state(), before)
    given = source.live.images("vis", rows), source.live.images("tac", rows)
    found = fitted.predict(*given)["fused"]
    wood = found[:, 0][source.labels == 0].min(), found[:, 0][source.labels == 1].max()
    assert fitted.images and wood[0] > wood[1] + 0.02
    assert torch.equal(again.predict(*given)["fused"], found)
    alone = fitted.predict(*(some[2:3] for some in given))["fused"]
    torch.testing.assert_close(alone, found[2:3], atol=1e-5, rtol=1e-4)
    torch.testing.assert_close(found.sum(1), torch.ones(6))
