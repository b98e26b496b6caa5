"""Sparsh, T3 and AnyTouch 2 over small random weights with the names and shapes of the authors'
code; no published file was at hand.
"""

import numpy as np
import pytest
import torch
from PIL import Image
from torch.nn import functional

from omnivat.cli import main
from omnivat.data.rest import minus_rest
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder
from omnivat.encoders.cache import embed_image
from omnivat.encoders.running import CLIP_MEAN, CLIP_STD, pixels
from omnivat.encoders.wrapping import IMAGENET_MEAN, IMAGENET_STD
from omnivat.kit.errors import DataError, SettingsError
from tests.unit.encoders import layers

WIDTH, DEPTH = 64, 2
PLAIN = ((0.0,) * 3, (1.0,) * 3)


def picture(seed, size=(240, 320)):
    random = np.random.default_rng(seed)
    return Image.fromarray(random.integers(0, 256, (size[1], size[0], 3), dtype=np.uint8))


NEW, OLD, REST = picture(1), picture(2), picture(3)


def norm(state, tokens, name="norm", eps=1e-5):
    weight, bias = state[f"{name}.weight"], state[f"{name}.bias"]
    return functional.layer_norm(tokens, (tokens.shape[-1],), weight, bias, eps)


def sparsh(kind, film, extra):
    """The weights of Sparsh; `film` for V-JEPA, `extra` for a register and layer scales."""
    sizes = layers.shapes(WIDTH, DEPTH, scales=extra)
    sizes |= {"norm.weight": (WIDTH,), "norm.bias": (WIDTH,), "patch_embed.proj.bias": (WIDTH,)}
    sizes["patch_embed.proj.weight"] = (WIDTH, 3, 2, 16, 16) if film else (WIDTH, 6, 16, 16)
    if film:
        sizes["pos_embed"] = (1, 600, WIDTH)
    if extra:
        sizes["register_tokens"] = (1, 1, WIDTH)
    state = layers.filled(sizes)
    if not film:
        state["pos_embed.frequency_bands"] = 10_000 ** -torch.linspace(0, 1, 17)[:-1].repeat(2, 1)
    others = layers.filled(sizes, seed=1)  # of the student, which is not read
    return {f"{kind}.{n}": v for n, v in state.items()} | {f"x.{n}": v for n, v in others.items()}


def by_hand(state, new, old, film):
    frames = [pixels(one, *PLAIN, (320, 240)) for one in (new, old)]
    cut, weight = state["patch_embed.proj.bias"], state["patch_embed.proj.weight"]
    if film:
        whole = torch.stack([frames[0], frames[0], frames[1], frames[1]], dim=1)
        tokens = functional.conv3d(whole[None], weight, cut, (2, 16, 16)).flatten(2).mT
        tokens = tokens + state["pos_embed"]
    else:
        tokens = functional.conv2d(torch.cat(frames)[None], weight, cut, 16).flatten(2).mT
        bands, rows = state["pos_embed.frequency_bands"][0], []
        for y, x in np.ndindex(20, 15):
            rows.append(torch.cat([f(at * bands) for at in (y, x) for f in (torch.sin, torch.cos)]))
        tokens = tokens + torch.stack(rows)
    if "register_tokens" in state:
        tokens = torch.cat((state["register_tokens"], tokens), dim=1)
    seen = norm(state, layers.by_hand(state, tokens, DEPTH, eps=1e-6), eps=1e-6)
    return seen[:, "register_tokens" in state :].mean(1)


@pytest.mark.parametrize(
    ("kind", "film", "extra"),
    [
        ("teacher_encoder.backbone", False, True),
        ("encoder", False, False),
        ("target_encoder", True, False),
    ],
)
def test_sparsh_is_the_mean_of_the_patch_tokens_of_this_frame_and_one_before(
    kind, film, extra, tmp_path
):
    state = sparsh(kind, film, extra)
    torch.save({"model": state} if film else state, tmp_path / "sparsh.ckpt")
    encoder = load_encoder("sparsh", weights=tmp_path / "sparsh.ckpt")
    own = {n.removeprefix(f"{kind}."): v for n, v in state.items() if n.startswith(kind)}
    for before in (None, OLD):
        found = encoder.embed(encoder.preprocess(NEW, before=before)[None])
        wanted = by_hand(own, NEW, before or NEW, film)
        torch.testing.assert_close(found, wanted, atol=1e-4, rtol=1e-4)
    lying = NEW.transpose(Image.Transpose.ROTATE_90)
    torch.testing.assert_close(encoder.preprocess(lying), encoder.preprocess(NEW))


@pytest.fixture
def t3(tmp_path):
    """A folder of T3 with two sensors, and their weights."""
    folder, files = tmp_path / "t3", {}
    (folder / "encoders").mkdir(parents=True)
    for seed, name in enumerate(("digit", "gs_tag")):
        sizes = layers.shapes(WIDTH, 1) | {
            "patch_embed.proj.weight": (WIDTH, 3, 16, 16),
            "patch_embed.proj.bias": (WIDTH,),
            "cls_token": (1, 1, WIDTH),
            "pos_embed": (1, 197, WIDTH),
        }
        files[name] = layers.filled(sizes, seed)
        torch.save(files[name], folder / "encoders" / f"{name}.pth")
    sizes = layers.shapes(WIDTH, DEPTH) | {"norm.weight": (WIDTH,), "norm.bias": (WIDTH,)}
    files["trunk"] = layers.filled(sizes, 2)
    torch.save(files["trunk"], folder / "trunk.pth")
    return folder, files


def test_t3_reads_a_touch_by_the_encoder_of_its_sensor_and_the_shared_trunk(t3):
    (folder, files), sensor, name = t3, "GelSight", "gs_tag"
    state, trunk = files[name], files["trunk"]
    image = pixels(NEW, IMAGENET_MEAN, IMAGENET_STD)[None]
    weights = state["patch_embed.proj.weight"], state["patch_embed.proj.bias"]
    tokens = functional.conv2d(image, *weights, 16).flatten(2).mT
    tokens = torch.cat((state["cls_token"], tokens), dim=1) + state["pos_embed"]
    tokens = layers.by_hand(state, tokens, 1, eps=1e-6)
    wanted = norm(trunk, layers.by_hand(trunk, tokens, DEPTH))[:, 0]
    encoder = load_encoder("t3", weights=folder)
    fixed = load_encoder(f"t3@{name}", weights=folder)
    for found in (
        encoder.embed(encoder.preprocess(NEW, sensor=sensor)[None]),
        torch.from_numpy(embed_image(fixed, NEW))[None],
    ):
        torch.testing.assert_close(found, wanted, atol=1e-4, rtol=1e-4)
    assert fixed.name == f"t3@{name}"


def anytouch():
    """The weights of AnyTouch 2, of four frames in two tubes; another tower is not read."""
    sizes = {
        "embeddings.class_embedding": (WIDTH,),
        "embeddings.position_embedding.weight": (2 * 196 + 1, WIDTH),
        "embeddings.patch_embedding.weight": (WIDTH, 3, 2, 16, 16),
    }
    for name in ("pre_layrnorm", "post_layernorm"):
        sizes |= {f"{name}.weight": (WIDTH,), f"{name}.bias": (WIDTH,)}
    for name, shape in layers.shapes(WIDTH, DEPTH).items():
        plain = name.replace("blocks.", "encoder.layers.").replace(".norm", ".layer_norm")
        plain = plain.replace("attn.proj", "self_attn.out_proj")
        for third in "qkv" if "qkv" in name else " ":
            own = plain.replace("attn.qkv", f"self_attn.{third}_proj")
            sizes[own] = (WIDTH, *shape[1:]) if "qkv" in name else shape
    state = {f"touch_model.{name}": shape for name, shape in sizes.items()}
    state |= {"touch_projection.weight": (32, WIDTH), "sensor_token": (20, 5, WIDTH)}
    found = layers.filled({f"touch_mae_model.{name}": shape for name, shape in state.items()})
    return found | {"vision_model.embeddings.class_embedding": torch.zeros(3)}


def test_anytouch_2_reads_four_frames_less_the_sensor_at_rest_with_the_tokens_of_its_kind(tmp_path):
    state = anytouch()
    torch.save(state, tmp_path / "any.pth")
    encoder = load_encoder("anytouch2", weights=tmp_path / "any.pth")
    tower = {n.removeprefix("touch_mae_model."): v for n, v in state.items()}
    own = {n.removeprefix("touch_model."): v for n, v in tower.items()}
    frames = [
        pixels(minus_rest(one, REST, offset=130), CLIP_MEAN, CLIP_STD)
        for one in (OLD, OLD, NEW, NEW)
    ]
    weight = own["embeddings.patch_embedding.weight"]
    cut = functional.conv3d(torch.stack(frames, 1)[None], weight, None, (2, 16, 16)).flatten(2).mT
    places = own["embeddings.position_embedding.weight"]
    first = own["embeddings.class_embedding"] + places[0]
    named = {n.replace("encoder.layers.", "blocks."): v for n, v in own.items()}
    for block in range(DEPTH):
        for kind in ("weight", "bias"):
            thirds = [named[f"blocks.{block}.self_attn.{one}_proj.{kind}"] for one in "qkv"]
            named[f"blocks.{block}.attn.qkv.{kind}"] = torch.cat(thirds)
            for old, new in (("self_attn.out_proj", "attn.proj"), ("layer_norm1", "norm1"),
                             ("layer_norm2", "norm2")):  # fmt: skip
                named[f"blocks.{block}.{new}.{kind}"] = named[f"blocks.{block}.{old}.{kind}"]
    for sensor, number in (("GelSight Mini", 3), ("7", 7)):
        row = torch.cat((first[None], tower["sensor_token"][number], cut[0] + places[1:]))[None]
        seen = layers.by_hand(named, norm(named, row, "pre_layrnorm"), DEPTH)
        wanted = norm(named, seen[:, 0], "post_layernorm") @ tower["touch_projection.weight"].T
        ready = encoder.preprocess(NEW, before=OLD, rest=REST, sensor=sensor)
        torch.testing.assert_close(encoder.embed(ready[None]), wanted, atol=1e-4, rtol=1e-4)


def test_embedding_a_set_gives_each_touch_the_frame_before_the_rest_picture_and_the_sensor(
    tmp_path,
):
    torch.save(anytouch(), tmp_path / "any.pth")
    rows = ["tac,domain,material,tac_before"]
    for domain in ("TQ-DIGIT-sim", "my DuraGel"):
        (tmp_path / domain).mkdir()
        REST.save(tmp_path / domain / "rest.png")
        OLD.save(tmp_path / domain / "0.png")
        NEW.save(tmp_path / domain / "1_tac.png")
        rows.append(f"{domain}/1_tac.png,{domain},wood,{domain}/0.png")
    (tmp_path / "pairs.csv").write_text("\n".join(rows))
    out = tmp_path / "set.safetensors"
    command = ["embed", tmp_path, "--encoder", "anytouch2", "--weights", tmp_path / "any.pth"]
    command += ["--tac-rest", "all", "--dots", "keep", "--no-flips", "--out", out]
    assert main(list(map(str, command))) == 0
    encoder = load_encoder("anytouch2", weights=tmp_path / "any.pth")
    for sensor, row in zip(("DIGIT", "DuraGel"), load_embeddings(out).tac, strict=True):
        ready = encoder.preprocess(NEW, before=OLD, rest=REST, sensor=sensor)
        np.testing.assert_allclose(encoder.embed(ready[None])[0].numpy(), row, atol=1e-6)


def test_they_need_the_published_weights():
    with pytest.raises(DataError, match="Sparsh needs the weights that its authors publish"):
        load_encoder("sparsh")


def test_what_does_not_fit_is_refused_in_a_sentence(t3, tmp_path):
    folder, _ = t3
    torch.save(anytouch(), tmp_path / "any.pth")
    touch = load_encoder("anytouch2", weights=tmp_path / "any.pth")
    with pytest.raises(DataError, match="'anytouch2' needs the picture of the untouched sensor"):
        touch.preprocess(NEW, sensor="DIGIT")
    with pytest.raises(DataError, match="no sensor 'kitchen', but gelsight, digit, .*@SENSOR"):
        touch.preprocess(NEW, rest=REST, sensor="kitchen")
    with pytest.raises(DataError, match="'t3' needs the kind of sensor"):
        embed_image(load_encoder("t3", weights=folder), NEW)
    with pytest.raises(DataError, match="is no folder of T3; name one with trunk.pth"):
        load_encoder("t3", weights=tmp_path)
    with pytest.raises(DataError, match="lacks the weight 'patch_embed.proj.weight' of Sparsh"):
        load_encoder("sparsh", weights=tmp_path / "any.pth")
    with pytest.raises(SettingsError, match="takes no kind of sensor; leave out '@digit'"):
        load_encoder("efficientnet-lite0@digit")
