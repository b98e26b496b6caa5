"""TorchScript archives and ResNets of CLIP."""

import pytest
import torch
from torch import nn

from omnivat.encoders import load_encoder, text_encoder
from omnivat.encoders.clip_text import load_text_encoder
from omnivat.encoders.weights import read_weights
from omnivat.kit.errors import DataError, MissingNameError

pytest.importorskip("transformers")
pytestmark = pytest.mark.usefixtures("nothing_outside")

# TorchScript archives


def test_an_archive_is_read_as_torch_reads_it(clips, tmp_path):
    state = clips.rn50_state() | {"other.transposed": torch.randn(3, 4).half().T}
    clips.save_script(state, tmp_path / "a.pt")
    found = read_weights(tmp_path / "a.pt", "clip")
    assert set(found) == {key for key, value in state.items() if value.is_floating_point()}
    assert all(torch.equal(value, state[key].float()) for key, value in found.items())


# ResNets


def test_a_resnet_and_its_text_tower_agree_with_the_paper(clips, tmp_path):
    """The reference is written with plain modules, normalisation apart; texts by transformers."""
    state, place = clips.rn50_state(), tmp_path / "RN50.pt"
    large = torch.randn(2, 3, 224, 224, generator=torch.Generator().manual_seed(5))
    clips.tokenizer().save_pretrained(tmp_path)
    clips.save_script(clips.published_resnet(state), place)
    encoder = load_encoder("clip", weights=place)
    torch.testing.assert_close(
        encoder.embed(large), reference_rn50(state, large), rtol=1e-4, atol=1e-5
    )
    tower = load_text_encoder("clip", weights=place)
    wanted = clips.text_embeddings(clips.small_model(), clips.TEXTS)
    torch.testing.assert_close(tower.embed_texts(clips.TEXTS), wanted, rtol=0, atol=1e-5)
    assert (encoder.width, tower.width, tower.weights_hash) == (24, 24, encoder.text_hash)


def reference_rn50(state, x):
    def conv(x, name, norm, stride=1):
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


def test_an_encoder_without_a_text_tower_says_which_have_one(clips, tmp_path):
    with pytest.raises(MissingNameError, match="clip-vit-b16, clip-vit-l14"):
        text_encoder("efficientnet-lite0")
    state = {f"visual.{key}": value for key, value in clips.rn50_state().items()}
    torch.save(state, tmp_path / "a.pt")
    with pytest.raises(DataError, match="no text tower"):
        text_encoder("clip", weights=tmp_path / "a.pt")
