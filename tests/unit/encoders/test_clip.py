"""CLIP towers with small random weights of the published names, and what a missing one says."""

from collections.abc import Callable
from pathlib import Path

import pytest
import torch
from safetensors.torch import save_file
from torch import Tensor, nn

from omnivat.encoders import load_encoder, text_encoder
from omnivat.encoders.checkpoints import Checkpoint, find
from omnivat.encoders.clip_resnet import AttentionPool, Bottleneck
from omnivat.errors import DataError, MissingNameError

transformers = pytest.importorskip("transformers")


@pytest.fixture(autouse=True)
def nothing_outside(monkeypatch: pytest.MonkeyPatch, tmp_path: Path) -> None:
    """No hub, no checkpoints of the person who runs the tests."""
    monkeypatch.setattr("omnivat.encoders.checkpoints._from_hub", lambda repository: None)
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for name in ("CLIP_VIT_B16", "CLIP_VIT_L14", "CLIP_RN50"):
        monkeypatch.delenv(f"OMNIVAT_{name}", raising=False)


@pytest.fixture
def images() -> Tensor:
    return torch.randn(3, 3, 224, 224, generator=torch.Generator().manual_seed(5))


@pytest.fixture
def vit_folder(tmp_path: Path) -> Path:
    """A small CLIP model as `transformers` saves it, tokenizer included."""
    sizes = {"hidden_size": 32, "num_hidden_layers": 2, "num_attention_heads": 2}
    config = transformers.CLIPConfig(
        text_config={
            **sizes,
            "intermediate_size": 48,
            "vocab_size": 600,
            "bos_token_id": 598,
            "eos_token_id": 599,
            "max_position_embeddings": 16,
        },
        vision_config={**sizes, "intermediate_size": 48, "image_size": 224, "patch_size": 32},
        projection_dim=24,
    )
    torch.manual_seed(0)
    model = transformers.CLIPModel(config).eval()
    folder = tmp_path / "vit"
    config.save_pretrained(folder)
    save_file({k: v.contiguous() for k, v in model.state_dict().items()}, folder / WEIGHTS)
    write_tokenizer(folder)
    return folder


WEIGHTS = "model.safetensors"


def write_tokenizer(folder: Path) -> None:
    letters = [chr(code) for code in range(33, 127)]
    words = [*letters, *(letter + "</w>" for letter in letters)]
    words += [f"spare{i}" for i in range(598 - len(words))]
    words += ["<|startoftext|>", "<|endoftext|>"]
    vocabulary = {word: index for index, word in enumerate(words)}
    transformers.CLIPTokenizer(vocab=vocabulary, merges=[]).save_pretrained(folder)


def whole_model(folder: Path) -> nn.Module:
    model: nn.Module = transformers.CLIPModel(transformers.CLIPConfig.from_pretrained(folder))
    from safetensors.torch import load_file

    model.load_state_dict(load_file(folder / WEIGHTS))
    return model.eval()


@pytest.mark.parametrize("name", ["clip-vit-b16", "clip-vit-l14"])
def test_the_image_tower_agrees_with_the_whole_model(
    vit_folder: Path, images: Tensor, name: str
) -> None:
    encoder = load_encoder(name, weights=vit_folder)
    model = whole_model(vit_folder)
    with torch.inference_mode():
        pooled = model.vision_model(pixel_values=images).pooler_output
        wanted = model.visual_projection(pooled)
    assert encoder.width == 24
    torch.testing.assert_close(encoder.embed(images), wanted)


def test_the_text_tower_agrees_with_the_whole_model(vit_folder: Path) -> None:
    texts = ["a wood", "steel!", "x" * 99]
    found = torch.from_numpy(text_encoder("clip-vit-b16", weights=vit_folder)(texts))
    tokens = transformers.CLIPTokenizer.from_pretrained(vit_folder)(
        texts, padding=True, truncation=True, max_length=16, return_tensors="pt"
    )
    model = whole_model(vit_folder)
    with torch.inference_mode():
        wanted = model.text_projection(model.text_model(**tokens).pooler_output)
    torch.testing.assert_close(found, wanted)


def test_a_vit_embedding_is_the_same_alone_and_in_any_batch(
    vit_folder: Path, images: Tensor
) -> None:
    encoder = load_encoder("clip-vit-b16", weights=vit_folder)
    alone = torch.cat([encoder.embed(image[None]) for image in images])
    assert torch.equal(encoder.embed(images), alone)


def rn50_state(width: int = 8, blocks: tuple[int, ...] = (2, 1, 1, 1)) -> dict[str, Tensor]:
    """Random weights under the published names. The published tower: width 64, (3, 4, 6, 3)."""
    torch.manual_seed(1)
    state: dict[str, Tensor] = {}

    def conv(name: str, norm: str, out: int, into: int, kernel: int) -> None:
        state[f"{name}.weight"] = torch.randn(out, into, kernel, kernel) / (into * kernel**2) ** 0.5
        state[f"{norm}.weight"] = torch.rand(out) + 0.5
        state[f"{norm}.bias"] = torch.randn(out) / 10
        state[f"{norm}.running_mean"] = torch.randn(out) / 10
        state[f"{norm}.running_var"] = torch.rand(out) + 0.5
        state[f"{norm}.num_batches_tracked"] = torch.tensor(3)

    for i, (out, into) in enumerate(
        [(width // 2, 3), (width // 2, width // 2), (width, width // 2)]
    ):
        conv(f"conv{i + 1}", f"bn{i + 1}", out, into, 3)
    into = width
    for stage, count in enumerate(blocks):
        middle = width * 2**stage
        for block in range(count):
            name = f"layer{stage + 1}.{block}"
            conv(f"{name}.conv1", f"{name}.bn1", middle, into, 1)
            conv(f"{name}.conv2", f"{name}.bn2", middle, middle, 3)
            conv(f"{name}.conv3", f"{name}.bn3", 4 * middle, middle, 1)
            if block == 0:
                conv(f"{name}.downsample.0", f"{name}.downsample.1", 4 * middle, into, 1)
            into = 4 * middle
    state["attnpool.positional_embedding"] = torch.randn(50, into) / into**0.5
    for name in "qkvc":
        out = 20 if name == "c" else into
        state[f"attnpool.{name}_proj.weight"] = torch.randn(out, into) / into**0.5
        state[f"attnpool.{name}_proj.bias"] = torch.randn(out) / 10
    return state


def published(state: dict[str, Tensor]) -> dict[str, Tensor]:
    """As published: the image tower beside other weights, halves where they are large."""
    whole = {f"visual.{key}": value for key, value in state.items()}
    return whole | {"logit_scale": torch.tensor(4.6), "text_projection": torch.zeros(4, 4)}


class Archive(nn.Module):
    """What gives a TorchScript archive with the published names in it."""

    def __init__(self, state: dict[str, Tensor]) -> None:
        super().__init__()
        for key, value in state.items():
            *path, leaf = key.split(".")
            owner: nn.Module = self
            for name in path:
                if name not in owner._modules:
                    owner.add_module(name, nn.Module())
                owner = owner._modules[name]  # type: ignore[assignment]
            owner.register_buffer(leaf, value)

    def forward(self, x: Tensor) -> Tensor:
        return x


def save_script(state: dict[str, Tensor], file: Path) -> None:
    import warnings

    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        torch.jit.save(torch.jit.script(Archive(state)), file)


WRITERS: dict[str, Callable[[dict[str, Tensor], Path], object]] = {
    "a.safetensors": save_file,
    "a.pt": torch.save,
    "script.pt": save_script,
}


@pytest.mark.parametrize("name", WRITERS)
def test_rn50_reads_each_kind_of_file_to_the_same_weights(
    tmp_path: Path, images: Tensor, name: str
) -> None:
    state = published(rn50_state())
    WRITERS[name](state, tmp_path / name)
    encoder = load_encoder("clip-rn50", weights=tmp_path / name)
    save_file(state, tmp_path / "reference.safetensors")
    reference = load_encoder("clip-rn50", weights=tmp_path / "reference.safetensors")
    assert encoder.weights_hash == reference.weights_hash
    assert encoder.width == 20
    assert torch.equal(encoder.embed(images), reference.embed(images))


def test_rn50_is_the_network_of_the_paper(tmp_path: Path, images: Tensor) -> None:
    """The reference below is written with plain modules, normalisation apart."""
    state = rn50_state()
    save_file(published(state), tmp_path / "a.safetensors")
    encoder = load_encoder("clip-rn50", weights=tmp_path / "a.safetensors")
    torch.testing.assert_close(
        encoder.embed(images), reference_rn50(state, images), rtol=1e-4, atol=1e-5
    )


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


def test_the_parts_of_the_published_rn50_have_its_sizes() -> None:
    """Width 64, four stages of 3, 4, 6 and 3: 38.3 million weights in the image tower."""
    state = rn50_state(64, (3, 4, 6, 3))
    assert Bottleneck(state, "layer4.0", stride=2).widen.weight.shape == (2048, 512, 1, 1)
    assert AttentionPool(state).places.shape == (50, 2048)


@pytest.mark.parametrize("name", ["clip-vit-b16", "clip-vit-l14", "clip-rn50"])
def test_a_missing_checkpoint_says_in_one_sentence_how_to_get_it(name: str, tmp_path: Path) -> None:
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


def test_the_hub_is_asked_only_when_no_place_was_given(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    asked: list[str] = []

    def hub(repository: str) -> Path:
        asked.append(repository)
        return tmp_path

    monkeypatch.setattr("omnivat.encoders.checkpoints._from_hub", hub)
    checkpoint = Checkpoint(name="some", fetch="fetch {folder}", hub="owner/some")
    with pytest.raises(DataError):
        find(checkpoint, tmp_path / "nowhere")
    assert asked == []
    assert find(checkpoint, None) == tmp_path
    assert asked == ["owner/some"]


def test_a_hub_that_cannot_be_reached_is_no_checkpoint(monkeypatch: pytest.MonkeyPatch) -> None:
    import huggingface_hub

    from omnivat.encoders import checkpoints

    monkeypatch.undo()

    def unreachable(*_: object, **__: object) -> str:
        raise OSError("no network")

    monkeypatch.setattr(huggingface_hub, "snapshot_download", unreachable)
    assert checkpoints._from_hub("owner/some") is None


@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (lambda folder: (folder / "config.json").unlink(), "no config.json"),
        (lambda folder: (folder / "config.json").write_text("{"), "not of a CLIP model"),
        (lambda folder: (folder / WEIGHTS).unlink(), "has no weights"),
        (lambda folder: (folder / WEIGHTS).write_bytes(b"x" * 99), "cannot be read"),
        (lambda folder: save_file({"vision_model.a": torch.zeros(1)}, folder / WEIGHTS), "lacks"),
        (
            lambda folder: save_file(
                {"visual_projection.weight": torch.zeros(2, 2)}, folder / WEIGHTS
            ),
            "other shapes",
        ),
    ],
)
def test_a_damaged_vit_folder_is_refused(
    vit_folder: Path, damage: Callable[[Path], object], match: str
) -> None:
    damage(vit_folder)
    with pytest.raises(DataError, match=match):
        load_encoder("clip-vit-b16", weights=vit_folder)


def test_rn50_weights_without_a_part_are_refused_by_its_name(tmp_path: Path) -> None:
    state = published(rn50_state())
    del state["visual.attnpool.q_proj.bias"]
    save_file(state, tmp_path / "a.safetensors")
    with pytest.raises(DataError, match=r"attnpool\.q_proj\.bias"):
        load_encoder("clip-rn50", weights=tmp_path / "a.safetensors")


def test_an_encoder_without_a_text_tower_says_which_have_one() -> None:
    with pytest.raises(MissingNameError, match="clip-vit-b16, clip-vit-l14"):
        text_encoder("clip-rn50")


def test_a_folder_without_a_tokenizer_is_refused(vit_folder: Path) -> None:
    for file in vit_folder.iterdir():
        if file.name not in ("config.json", WEIGHTS):
            file.unlink()
    with pytest.raises(DataError, match="tokenizer"):
        text_encoder("clip-vit-b16", weights=vit_folder)
