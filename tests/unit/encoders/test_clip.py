"""CLIP in its layouts: the same embeddings, and its name checked."""

import json

import pytest
import torch

from omnivat.encoders import load_encoder, running, text_encoder
from omnivat.encoders.clip import PUBLISHED, ImageShape, image_shape, require_name
from omnivat.encoders.clip_names import ClipState
from omnivat.encoders.clip_text import load_text_encoder
from omnivat.kit.errors import DataError

pytest.importorskip("transformers")
pytestmark = pytest.mark.usefixtures("nothing_outside")


LAYOUTS = (
    "transformers folder",
    "bare safetensors",
    "OpenAI state dict",
    "OpenAI TorchScript",
    "open_clip folder",
)
STATING = (LAYOUTS[0], LAYOUTS[-1])  # the activation; QuickGELU is assumed for bare weights


@pytest.fixture
def images():
    return torch.randn(3, 3, 96, 96, generator=torch.Generator().manual_seed(5))


@pytest.mark.parametrize(
    ("activation", "layout"),
    [*(("quick_gelu", layout) for layout in LAYOUTS), *(("gelu", layout) for layout in STATING)],
)
def test_both_towers_agree_with_transformers_in_every_layout(
    clips, tmp_path, images, layout, activation
):
    model = clips.small_model(activation=activation)
    place = clips.write(layout, tmp_path / "clip", model)
    encoder = load_encoder("clip", weights=place)
    assert (encoder.name, encoder.width) == ("clip", 24)
    assert encoder.preprocessing == "resize 96x96 bicubic, RGB, CLIP mean and std"
    wanted = clips.image_embeddings(model, images)
    torch.testing.assert_close(encoder.embed(images), wanted, rtol=0, atol=1e-5)
    texts = torch.from_numpy(text_encoder("clip", weights=place)(clips.TEXTS))
    torch.testing.assert_close(texts, clips.text_embeddings(model, clips.TEXTS), rtol=0, atol=1e-5)


def test_half_precision_weights_are_widened(clips, tmp_path, images):
    model = clips.small_model().half()
    place = clips.write("OpenAI TorchScript", tmp_path / "clip", model)
    encoder = load_encoder("clip", weights=place)
    wanted = clips.image_embeddings(model.float(), images)
    torch.testing.assert_close(encoder.embed(images), wanted, rtol=0, atol=1e-5)


def test_the_layout_does_not_change_a_hash_and_the_weights_and_the_activation_do(clips, tmp_path):
    def hashes(layout, folder, **settings):
        place = clips.write(layout, tmp_path / folder, clips.small_model(**settings))
        encoder = load_encoder("clip", weights=place)
        assert load_text_encoder("clip", weights=place).weights_hash == encoder.text_hash
        return encoder.weights_hash, encoder.text_hash

    found = [hashes(layout, str(i)) for i, layout in enumerate(LAYOUTS[1::3])]
    found += [hashes(LAYOUTS[0], "seed", seed=1), hashes(LAYOUTS[0], "gelu", activation="gelu")]
    assert len(set(found[:2])) == 1
    assert len({image for image, _ in found}) == len({text for _, text in found}) == 3


def test_an_embedding_is_the_same_alone_and_in_any_batch(clips, tmp_path, images):
    encoder = load_encoder("clip", weights=clips.write(LAYOUTS[0], tmp_path, clips.small_model()))
    alone = torch.cat([encoder.embed(image[None]) for image in images])
    assert torch.equal(encoder.embed(images), alone)


@pytest.mark.parametrize(
    ("change", "right"),
    [
        (ImageShape(32, 768, (12,), 512, 224), "clip-vit-b32"),
        (ImageShape(14, 1024, (24,), 768, 336), "clip-vit-l14-336"),
        (ImageShape(0, 64, (3, 4, 6, 3), 1024, 224), "clip-rn50"),
        (ImageShape(32, 256, (12,), 512, 224), "clip, which takes any size"),
    ],
)
def test_weights_of_another_size_than_their_name_says_are_refused(change, right):
    assert require_name("clip", change, "some file") == right.partition(",")[0]
    with pytest.raises(
        DataError, match=f"not hold the weights of clip-vit-b16 .*use --encoder {right}"
    ):
        require_name("clip-vit-b16", change, "some file")
    assert require_name("clip", ImageShape(16, 768, (12,), 512, 224), "") == "clip-vit-b16"


def test_a_resnets_sizes_are_told_by_its_weights():
    names = [
        f"layer{k}.{n}.conv1.weight" for k, most in enumerate((3, 4, 6, 3), 1) for n in range(most)
    ]
    state = {name: torch.zeros(64) for name in names} | {
        "attnpool.positional_embedding": torch.zeros(7 * 7 + 1, 2048),
        "attnpool.c_proj.weight": torch.zeros(1024, 2048),
    }
    clip = ClipState(resnet=True, image=state, text={}, logit_scale=None)
    assert image_shape(clip) == PUBLISHED["clip-rn50"]


def test_the_pixels_of_clip_are_scaled_by_the_published_statistics():
    from transformers.image_utils import OPENAI_CLIP_MEAN, OPENAI_CLIP_STD

    assert tuple(OPENAI_CLIP_MEAN) == running.CLIP_MEAN
    assert tuple(OPENAI_CLIP_STD) == running.CLIP_STD


def test_pixel_statistics_beside_the_weights_are_used(clips, tmp_path):
    place = clips.write("open_clip folder", tmp_path, clips.small_model())
    file = tmp_path / "open_clip_config.json"
    config = json.loads(file.read_text()) | {"preprocess_cfg": {"mean": [0.5] * 3, "std": [1] * 3}}
    file.write_text(json.dumps(config))
    assert load_encoder("clip", weights=place).preprocessing.endswith("mean 0.5 0.5 0.5, std 1 1 1")
