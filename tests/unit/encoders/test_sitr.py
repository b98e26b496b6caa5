"""SITR's loader over a stand-in with the names and shapes of the published code; no published
file was at hand.
"""

import numpy as np
import pytest
import torch
from PIL import Image
from torch import nn

from omnivat.encoders import load_encoder
from omnivat.encoders.sitr import MEAN, STD
from omnivat.kit.errors import DataError
from tests.unit.encoders import layers

WIDTH, DEPTH, SIDE, PATCH = 128, 2, 32, 16
PLACES = (SIDE // PATCH) ** 2


def shapes(width, depth, places, presses, patch=16):
    """Names and shapes of the authors' module, read off its definition (hgupt3/gsrl)."""
    found = {"cls_token": (1, 1, width), "pos_embed": (1, places + 1, width)}
    parts = {
        "patch_embed.proj": (width, 3, patch, patch),
        "norm": (width,),
        "decoder_pred": (3 * patch**2, width),
        "contrastive_head": (128, width),
    }
    if presses:
        found["c_pos_embed"] = (1, places, width)
        parts["c_patch_embed.proj"] = (width, 3 * presses, patch, patch)
    for name, shape in parts.items():
        found |= {f"{name}.weight": shape, f"{name}.bias": shape[:1]}
    return found | layers.shapes(width, depth)


def made(presses):
    return layers.filled(shapes(WIDTH, DEPTH, PLACES, presses))


def picture(seed):
    random = np.random.default_rng(seed)
    return Image.fromarray(random.integers(0, 256, (SIDE, SIDE, 3), dtype=np.uint8))


def written(folder, state, pictures=19):
    (folder / "calibration").mkdir(parents=True, exist_ok=True)
    for index in range(pictures):
        picture(index).save(folder / "calibration" / f"{index:04d}.png")
    torch.save(state, folder / "SITR.pth")
    return folder / "SITR.pth"


def difference(seed):
    """A picture less the one at rest, in the statistics of the authors' code."""
    raw = np.asarray(picture(seed), np.float32) - np.asarray(picture(0), np.float32)
    return torch.from_numpy((raw - np.array(MEAN)) / np.array(STD)).permute(2, 0, 1).float()


def oracle(state, seed, presses):
    """The class token, layer by layer as the authors' code has them."""
    conv, norm = nn.functional.conv2d, nn.functional.layer_norm
    weight, bias = state["patch_embed.proj.weight"], state["patch_embed.proj.bias"]
    tokens = conv(difference(seed)[None], weight, bias, PATCH).flatten(2).mT
    tokens = torch.cat((state["cls_token"], tokens), dim=1) + state["pos_embed"]
    if presses:
        weight, bias = state["c_patch_embed.proj.weight"], state["c_patch_embed.proj.bias"]
        stack = torch.cat([difference(index) for index in presses])[None]
        own = conv(stack, weight, bias, PATCH).flatten(2).mT + state["c_pos_embed"]
        tokens = torch.cat((tokens, own), dim=1)

    tokens = layers.by_hand(state, tokens, DEPTH)
    return layers.part(state, "norm", norm, tokens[:, 0], (WIDTH,))


@pytest.mark.parametrize(("number", "presses"), [(0, []), (8, [1, 3, 7, 9, 10, 12, 16, 18])])
def test_its_embedding_is_the_class_token_of_the_press_beside_the_calibration(
    number, presses, tmp_path
):
    state = made(number)
    encoder = load_encoder("sitr", weights=written(tmp_path, state))
    assert encoder.width == WIDTH and f"{number} presses" in encoder.preprocessing
    found = encoder.embed(encoder.preprocess(picture(50))[None])
    with torch.no_grad():
        torch.testing.assert_close(found, oracle(state, 50, presses), atol=1e-4, rtol=1e-4)


def test_another_sensor_at_rest_is_another_encoder(tmp_path):
    first = load_encoder("sitr", weights=written(tmp_path / "a", made(0)))
    file = written(tmp_path / "b", made(0))
    picture(77).save(file.parent / "calibration" / "0000.png")
    assert load_encoder("sitr", weights=file).weights_hash != first.weights_hash


@pytest.mark.parametrize(
    ("presses", "change", "message"),
    [
        (4, {}, "needs 5 pictures.*0003.png is missing"),
        (0, {"blocks.1.norm2.bias": None}, r"lacks the weight 'blocks.1.norm2.bias' of sitr"),
        (
            0,
            {"blocks.1.attn.qkv.weight": (5, WIDTH)},
            r"has blocks.1.self_attn.in_proj_weight of shape \(5, 128\), expected \(384, 128\)",
        ),
        (4, {"c_patch_embed.proj.weight": (WIDTH, 21, 16, 16)}, "21 channels of calibration"),
        (0, {"pos_embed": (1, 7, WIDTH)}, "6 patches; SITR's width is a multiple of 64"),
    ],
)
def test_what_does_not_fit_is_refused_in_a_sentence(tmp_path, presses, change, message):
    state = made(presses) | {n: torch.zeros(shape or 0) for n, shape in change.items()}
    state = {n: value for n, value in state.items() if change.get(n, value) is not None}
    with pytest.raises(DataError, match=message):
        load_encoder("sitr", weights=written(tmp_path, state, pictures=3))


def test_it_needs_the_published_weights():
    with pytest.raises(DataError, match="published weights; download.*--tac-weights FILE"):
        load_encoder("sitr")
