"""CLIP in every layout: the same embeddings, its name checked, damage refused in one sentence."""

import json
import pickle
from collections.abc import Callable
from pathlib import Path
from typing import Any

import pytest
import torch
from safetensors.torch import load_file, save_file
from torch import Tensor, nn

from omnivat.encoders import load_encoder, text_encoder
from omnivat.encoders.archives import read_script
from omnivat.encoders.checkpoints import Checkpoint, find
from omnivat.encoders.clip_resnet import AttentionPool, Bottleneck
from omnivat.encoders.clip_shapes import PUBLISHED, ImageShape, require_name
from omnivat.encoders.clip_text import load_text_encoder
from omnivat.errors import DataError, MissingNameError

pytest.importorskip("transformers")

LAYOUTS = (
    "transformers folder",
    "bare safetensors",
    "OpenAI state dict",
    "OpenAI TorchScript",
    "open_clip folder",
    "open_clip training checkpoint",
)
TEXTS = ["a wood", "steel!", "x" * 99]
WEIGHTS = "model.safetensors"


@pytest.fixture(autouse=True)
def nothing_outside(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No hub, no checkpoints of the person who runs the tests."""
    monkeypatch.setattr("omnivat.encoders.hub.fetch", lambda *_, **__: "There is no hub here.")
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for name in ("CLIP", *(name.upper().replace("-", "_") for name in PUBLISHED)):
        monkeypatch.delenv(f"OMNIVAT_{name}", raising=False)


@pytest.fixture
def images() -> Tensor:
    return torch.randn(3, 3, 96, 96, generator=torch.Generator().manual_seed(5))


@pytest.mark.parametrize("activation", ["quick_gelu", "gelu"])
@pytest.mark.parametrize("layout", LAYOUTS)
def test_both_towers_agree_with_transformers_in_every_layout(
    clips: Any, tmp_path: Path, images: Tensor, layout: str, activation: str
) -> None:
    if activation == "gelu" and layout in LAYOUTS[1:4]:
        pytest.skip("a file of bare weights states no activation; QuickGELU is assumed")
    model = clips.small_model(activation=activation)
    place = clips.write(layout, tmp_path / "clip", model)
    encoder = load_encoder("clip", weights=place)
    assert (encoder.name, encoder.width) == ("clip", 24)
    assert encoder.preprocessing == "resize 96x96 bicubic, RGB, CLIP mean and std"
    wanted = clips.image_embeddings(model, images)
    torch.testing.assert_close(encoder.embed(images), wanted, rtol=0, atol=1e-5)
    texts = torch.from_numpy(text_encoder("clip", weights=place)(TEXTS))
    torch.testing.assert_close(texts, clips.text_embeddings(model, TEXTS), rtol=0, atol=1e-5)


@pytest.mark.parametrize("layout", LAYOUTS)
def test_half_precision_weights_are_widened(
    clips: Any, tmp_path: Path, images: Tensor, layout: str
) -> None:
    model = clips.small_model().half()
    place = clips.write(layout, tmp_path / "clip", model)
    encoder = load_encoder("clip", weights=place)
    wanted = clips.image_embeddings(model.float(), images)
    torch.testing.assert_close(encoder.embed(images), wanted, rtol=0, atol=1e-5)


def test_the_layout_does_not_change_a_hash_and_the_weights_and_the_activation_do(
    clips: Any, tmp_path: Path
) -> None:
    def hashes(layout: str, folder: str, **settings: Any) -> tuple[str, str]:
        place = clips.write(layout, tmp_path / folder, clips.small_model(**settings))
        encoder: Any = load_encoder("clip", weights=place)
        assert load_text_encoder("clip", weights=place).weights_hash == encoder.text_hash
        return encoder.weights_hash, encoder.text_hash

    found = [hashes(layout, str(i)) for i, layout in enumerate(LAYOUTS)]
    found += [hashes(LAYOUTS[0], "seed", seed=1), hashes(LAYOUTS[0], "gelu", activation="gelu")]
    assert len(set(found[: len(LAYOUTS)])) == 1
    assert len({image for image, _ in found}) == len({text for _, text in found}) == 3


def test_an_embedding_is_the_same_alone_and_in_any_batch(
    clips: Any, tmp_path: Path, images: Tensor
) -> None:
    encoder = load_encoder("clip", weights=clips.write(LAYOUTS[0], tmp_path, clips.small_model()))
    alone = torch.cat([encoder.embed(image[None]) for image in images])
    assert torch.equal(encoder.embed(images), alone)


@pytest.mark.parametrize(
    ("change", "right"),
    [
        (ImageShape("ViT", 32, 768, (12,), 512, 224), "clip-vit-b32"),
        (ImageShape("ViT", 14, 1024, (24,), 768, 336), "clip-vit-l14-336"),
        (ImageShape("ResNet", 32, 64, (3, 4, 6, 3), 1024, 224), "clip-rn50"),
        (ImageShape("ViT", 32, 256, (12,), 512, 224), "clip, which takes any size"),
    ],
)
def test_weights_of_another_size_than_their_name_says_are_refused(
    change: ImageShape, right: str
) -> None:
    with pytest.raises(DataError, match=f"patch 16.*use --encoder {right}"):
        require_name("clip-vit-b16", change, "some file")


def test_a_published_shape_has_its_name_even_when_any_clip_is_loaded() -> None:
    assert require_name("clip", PUBLISHED["clip-vit-l14"], "some file") == "clip-vit-l14"
    assert require_name("clip-rn101", PUBLISHED["clip-rn101"], "some file") == "clip-rn101"


@pytest.mark.parametrize("name", ["clip-vit-b16", "clip-vit-l14", "clip-rn50"])
def test_a_small_model_is_no_published_one(clips: Any, tmp_path: Path, name: str) -> None:
    place = clips.write("OpenAI TorchScript", tmp_path, clips.small_model())
    with pytest.raises(DataError, match="use --encoder clip, which takes any size"):
        load_encoder(name, weights=place)


def test_pixel_statistics_beside_the_weights_are_used(clips: Any, tmp_path: Path) -> None:
    place = clips.write("open_clip folder", tmp_path, clips.small_model())
    file = tmp_path / "open_clip_config.json"
    config = json.loads(file.read_text()) | {"preprocess_cfg": {"mean": [0.5] * 3, "std": [1] * 3}}
    file.write_text(json.dumps(config))
    assert load_encoder("clip", weights=place).preprocessing.endswith("mean 0.5 0.5 0.5, std 1 1 1")


# TorchScript archives


def test_an_archive_is_read_as_torch_reads_it(clips: Any, tmp_path: Path) -> None:
    state = clips.rn50_state() | {"other.transposed": torch.randn(3, 4).half().T}
    clips.save_script(state, tmp_path / "a.pt")
    found = read_script(tmp_path / "a.pt")
    assert set(found) == set(state)
    assert all(torch.equal(found[key], state[key]) for key in state)


def test_an_archive_that_would_run_something_is_refused(clips: Any, tmp_path: Path) -> None:
    from zipfile import ZipFile

    class Evil:
        def __reduce__(self) -> Any:
            return print, ("it ran",)

    with ZipFile(tmp_path / "a.pt", "w") as archive:
        archive.writestr("a/constants.pkl", b"")
        archive.writestr("a/data.pkl", pickle.dumps(Evil()))
    with pytest.raises(DataError, match="the archive calls"):
        load_encoder("clip", weights=tmp_path / "a.pt")


# ResNets

WRITERS = ("a.safetensors", "a.pt", "script.pt", "training.pt")


def write_resnet(clips: Any, state: dict[str, Tensor], file: Path) -> Path:
    clips.tokenizer().save_pretrained(file.parent)
    if file.suffix == ".safetensors":
        save_file(state, file)
    elif file.name.startswith("script"):
        clips.save_script(state, file)
    elif file.name.startswith("training"):
        record = {"epoch": 1, "name": "RN50-quickgelu", "state_dict": state}
        torch.save(record, file)
    else:
        torch.save(state, file)
    return file


@pytest.fixture
def large() -> Tensor:
    return torch.randn(2, 3, 224, 224, generator=torch.Generator().manual_seed(5))


@pytest.mark.parametrize("name", WRITERS)
def test_a_resnet_and_its_text_tower_agree_with_the_paper_in_every_kind_of_file(
    clips: Any, tmp_path: Path, large: Tensor, name: str
) -> None:
    """The reference is written with plain modules, normalisation apart; texts by transformers."""
    state = clips.rn50_state()
    place = write_resnet(clips, clips.published_resnet(state), tmp_path / name)
    encoder: Any = load_encoder("clip", weights=place)
    torch.testing.assert_close(
        encoder.embed(large), reference_rn50(state, large), rtol=1e-4, atol=1e-5
    )
    tower = load_text_encoder("clip", weights=place)
    wanted = clips.text_embeddings(clips.small_model(), TEXTS)
    torch.testing.assert_close(tower.embed_texts(TEXTS), wanted, rtol=0, atol=1e-5)
    assert (encoder.width, tower.width, tower.weights_hash) == (24, 24, encoder.text_hash)


def reference_rn50(state: dict[str, Tensor], x: Tensor) -> Tensor:
    def conv(x: Tensor, name: str, norm: str, stride: int = 1) -> Tensor:
        weight = state[f"{name}.weight"]
        x = nn.functional.conv2d(x, weight, stride=stride, padding=weight.shape[-1] // 2)
        mean, var = state[f"{norm}.running_mean"], state[f"{norm}.running_var"]
        return nn.functional.batch_norm(
            x, mean, var, state[f"{norm}.weight"], state[f"{norm}.bias"], eps=1e-5
        )

    for i in (1, 2, 3):
        x = conv(x, f"conv{i}", f"bn{i}", stride=2 if i == 1 else 1).relu()
    x = nn.functional.avg_pool2d(x, 2)
    for name in ("layer1.0", "layer1.1", "layer2.0", "layer3.0", "layer4.0"):
        pool = nn.AvgPool2d(2 if name[-1] == "0" and name[5] != "1" else 1)
        out = conv(x, f"{name}.conv1", f"{name}.bn1").relu()
        out = pool(conv(out, f"{name}.conv2", f"{name}.bn2").relu())
        out = conv(out, f"{name}.conv3", f"{name}.bn3")
        if name.endswith("0"):
            x = conv(pool(x), f"{name}.downsample.0", f"{name}.downsample.1")
        x = (x + out).relu()
    tokens = x.flatten(2).permute(2, 0, 1)
    tokens = torch.cat([tokens.mean(0, keepdim=True), tokens])
    tokens = tokens + state["attnpool.positional_embedding"][:, None]
    width = tokens.shape[-1]
    names = [f"attnpool.{name}_proj" for name in "qkv"]
    attention = nn.MultiheadAttention(width, width // 64)
    with torch.no_grad():
        attention.in_proj_weight.copy_(torch.cat([state[f"{name}.weight"] for name in names]))
        attention.in_proj_bias.copy_(torch.cat([state[f"{name}.bias"] for name in names]))
        attention.out_proj.weight.copy_(torch.eye(width))
        attention.out_proj.bias.zero_()
        seen = attention(tokens[:1], tokens, tokens, need_weights=False)[0][0]
    return nn.functional.linear(
        seen, state["attnpool.c_proj.weight"], state["attnpool.c_proj.bias"]
    )


def test_the_parts_of_the_published_rn50_have_its_sizes(clips: Any) -> None:
    """Width 64, four stages of 3, 4, 6 and 3: 38.3 million weights in the image tower."""
    state = clips.rn50_state(64, (3, 4, 6, 3))
    assert Bottleneck(state, "layer4.0", stride=2).widen.weight.shape == (2048, 512, 1, 1)
    assert AttentionPool(state).places.shape == (50, 2048)


def test_resnet_weights_without_a_part_are_refused_by_its_name(clips: Any, tmp_path: Path) -> None:
    state = clips.published_resnet(clips.rn50_state())
    del state["visual.attnpool.q_proj.bias"]
    with pytest.raises(DataError, match=r"attnpool\.q_proj\.bias"):
        load_encoder("clip", weights=write_resnet(clips, state, tmp_path / "a.pt"))


# What is missing or damaged


@pytest.mark.parametrize("name", list(PUBLISHED))
def test_a_missing_checkpoint_says_in_one_line_how_to_get_it(name: str, tmp_path: Path) -> None:
    with pytest.raises(DataError) as caught:
        load_encoder(name)
    sentence = str(caught.value)
    assert str(tmp_path / "cache" / name) in sentence
    assert "hf download" in sentence or "curl" in sentence
    assert f"OMNIVAT_{name.upper().replace('-', '_')}" in sentence
    assert "\n" not in sentence


def test_a_given_place_that_is_missing_is_named(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="nowhere"):
        load_encoder("clip-vit-b16", weights=tmp_path / "nowhere")


def test_the_environment_and_the_default_folder_are_looked_at(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    checkpoint = Checkpoint(name="clip-rn50", fetch="fetch {folder}")
    checkpoint.folder.mkdir(parents=True)
    assert find(checkpoint, None) == tmp_path / "cache" / "clip-rn50"
    monkeypatch.setenv("OMNIVAT_CLIP_RN50", str(tmp_path))
    assert find(checkpoint, None) == tmp_path


Damage = Callable[[Path], object]


@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (lambda folder: (folder / "config.json").write_text("{"), "not of a CLIP model"),
        (lambda folder: (folder / WEIGHTS).unlink(), "has no weights"),
        (lambda folder: (folder / WEIGHTS).write_bytes(b"x" * 99), "cannot be read"),
        (
            lambda folder: save_file({"fc.weight": torch.zeros(1)}, folder / WEIGHTS),
            "no weights of",
        ),
        (lambda folder: without(folder, "visual_projection.weight"), "lacks the weight 'visual_pr"),
        (lambda folder: without(folder, "layers.1.mlp.fc2.bias"), "lacks 1 weights"),
        (lambda folder: reshaped(folder, "layers.1.mlp.fc2.bias"), "expected"),
        (lambda folder: stated(folder, "hidden_size", 128), "states 128"),
        (lambda folder: stated(folder, "num_attention_heads", 7), "cannot be 7"),
    ],
)
def test_a_damaged_folder_is_refused(
    clips: Any, tmp_path: Path, damage: Damage, match: str
) -> None:
    folder = clips.write("transformers folder", tmp_path, clips.small_model())
    damage(folder)
    with pytest.raises(DataError, match=match):
        load_encoder("clip", weights=folder)


def without(folder: Path, ending: str) -> None:
    state = load_file(folder / WEIGHTS)
    kept = {k: v for k, v in state.items() if not k.endswith(ending) or k.startswith("text")}
    save_file(kept, folder / WEIGHTS)


def reshaped(folder: Path, ending: str) -> None:
    state = load_file(folder / WEIGHTS)
    save_file(
        {k: v[:-1].clone() if k.endswith(ending) else v for k, v in state.items()}, folder / WEIGHTS
    )


def stated(folder: Path, name: str, value: int) -> None:
    config = json.loads((folder / "config.json").read_text())
    config["vision_config"][name] = value
    (folder / "config.json").write_text(json.dumps(config))


def test_a_width_that_no_heads_of_64_fill_needs_its_settings(clips: Any, tmp_path: Path) -> None:
    model = clips.small_model(hidden_size=48)
    place = clips.write("bare safetensors", tmp_path, model)
    with pytest.raises(DataError, match="heads cannot be told from the weights; put"):
        load_encoder("clip", weights=place)


def test_an_encoder_without_a_text_tower_says_which_have_one(clips: Any, tmp_path: Path) -> None:
    with pytest.raises(MissingNameError, match="clip-vit-b16, clip-vit-l14"):
        text_encoder("efficientnet-lite0")
    state = {f"visual.{key}": value for key, value in clips.rn50_state().items()}
    with pytest.raises(DataError, match="no text tower"):
        text_encoder("clip", weights=write_resnet(clips, state, tmp_path / "a.safetensors"))


def test_a_folder_without_a_tokenizer_is_refused_where_no_package_carries_one(
    clips: Any, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("omnivat.encoders.clip_tokenizer.CARRIERS", ())
    folder = clips.write("transformers folder", tmp_path / "clip", clips.small_model())
    for file in folder.iterdir():
        if file.name not in ("config.json", WEIGHTS):
            file.unlink()
    with pytest.raises(DataError, match="no tokenizer"):
        text_encoder("clip", weights=folder)


def test_a_tokenizer_of_another_model_is_refused(clips: Any, tmp_path: Path) -> None:
    model = clips.small_model()
    place = clips.write("transformers folder", tmp_path, model)
    more = clips.tokenizer()
    more.add_tokens([f"new{i}" for i in range(9)])
    more.save_pretrained(place)
    with pytest.raises(DataError, match="609 tokens and the text tower 600"):
        text_encoder("clip", weights=place)


def test_published_merges_give_the_tokens_of_the_published_vocabulary(tmp_path: Path) -> None:
    """Two merges, so `ab` is one token, in the order: bytes, bytes ending a word, merges, marks."""
    import gzip

    from omnivat.encoders.clip_tokenizer import MERGES, load_tokenizer

    (tmp_path / MERGES).write_bytes(gzip.compress(b"#version\na b\nb c</w>"))
    found = load_tokenizer(tmp_path, longest=9, vocabulary=49408)
    assert found("ab a bc")["input_ids"] == [514, 64, 65 + 256, 64 + 256, 513, 515]


@pytest.mark.parametrize("prefix", ["clip.", "clip_model.", "net.image_encoder.", "model."])
@pytest.mark.parametrize("names", ["transformers", "OpenAI"])
def test_a_clip_inside_another_model_is_found_by_its_names(
    prefix: str, names: str, clips: Any, tmp_path: Path
) -> None:
    plain = clips.small_model().state_dict()
    state = plain if names == "transformers" else clips.openai_names(plain)
    wrapped = {f"{prefix}{key}": value for key, value in state.items()}
    torch.save(wrapped | {"head.weight": torch.zeros(5, 24)}, tmp_path / "wrapped.pt")
    torch.save(state, tmp_path / "plain.pt")
    found = load_encoder("clip", weights=tmp_path / "wrapped.pt")
    assert found.weights_hash == load_encoder("clip", weights=tmp_path / "plain.pt").weights_hash


@pytest.mark.parametrize("kind", ["ViT", "ResNet"])
def test_an_image_tower_alone_under_openais_names_loads(
    kind: str, clips: Any, tmp_path: Path
) -> None:
    whole = clips.openai_names(clips.small_model().state_dict())
    if kind == "ResNet":
        whole = clips.published_resnet(clips.rn50_state())
    alone = {k.removeprefix("visual."): v for k, v in whole.items() if k.startswith("visual.")}
    torch.save(alone, tmp_path / "alone.pt")
    torch.save(whole, tmp_path / "whole.pt")
    found = load_encoder("clip", weights=tmp_path / "alone.pt")
    assert found.weights_hash == load_encoder("clip", weights=tmp_path / "whole.pt").weights_hash
