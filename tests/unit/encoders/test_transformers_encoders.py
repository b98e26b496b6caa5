"""A model of transformers as an encoder that the project does not list."""

import pytest
import torch

from omnivat.encoders import load_encoder
from omnivat.kit.errors import DataError

pytestmark = pytest.mark.usefixtures("nothing_outside")

SIZES = {
    "hidden_size": 32,
    "num_hidden_layers": 1,
    "num_attention_heads": 2,
    "intermediate_size": 48,
    "image_size": 64,
    "patch_size": 16,
}


LETTERS = {"hidden_size": 32, "num_hidden_layers": 1, "num_attention_heads": 2, "vocab_size": 50}


DINO = {key: value for key, value in SIZES.items() if key != "intermediate_size"}


# Models of transformers


def vision_model(kind):
    transformers = pytest.importorskip("transformers")
    configs = {
        "dinov2": lambda: transformers.Dinov2Config(**DINO),
        "i-jepa": lambda: transformers.IJepaConfig(**SIZES),
        "convnext": lambda: transformers.ConvNextConfig(
            hidden_sizes=[8, 16, 24, 32], depths=[1, 1, 1, 1], image_size=64
        ),
        "siglip": lambda: transformers.SiglipConfig(
            vision_config=SIZES, text_config={**LETTERS, "intermediate_size": 48}
        ),
    }
    torch.manual_seed(3)
    model = transformers.AutoModel.from_config(configs[kind]())
    with torch.no_grad():
        for weight in model.parameters():
            weight.copy_(torch.randn_like(weight) / max(1, weight.shape[-1]) ** 0.5)
    return model.eval()


def reference(kind, model, pixels):
    """Return what each model is pooled to, written out for each kind."""
    with torch.inference_mode():
        if kind == "siglip":
            found = model.vision_model(pixel_values=pixels).pooler_output
        elif kind == "convnext":
            found = model(pixel_values=pixels).pooler_output
        elif kind == "i-jepa":
            found = model(pixel_values=pixels).last_hidden_state.mean(1)
        else:
            found = model(pixel_values=pixels).last_hidden_state[:, 0]
    return found


POOLING = {
    "dinov2": "class token",
    "i-jepa": "mean of tokens",
    "convnext": "pooled output",
    "siglip": "projected image features",
}


@pytest.mark.parametrize("kind", POOLING)
def test_a_folder_of_transformers_loads_and_states_its_pooling(tmp_path, picture, kind):
    model = vision_model(kind)
    model.save_pretrained(tmp_path / "model")
    encoder = load_encoder(f"hf:{tmp_path / 'model'}")
    assert encoder.name == f"hf:{tmp_path / 'model'}" and encoder.width == 32
    assert encoder.preprocessing.startswith("resize 64x64 bicubic, RGB, mean 0.485")
    assert POOLING[kind] in encoder.preprocessing
    pixels = encoder.preprocess(picture)[None]
    torch.testing.assert_close(
        encoder.embed(pixels), reference(kind, model, pixels), rtol=0, atol=1e-5
    )


def test_the_pixels_are_those_of_the_models_own_settings(tmp_path):
    folder = tmp_path / "model"
    vision_model("dinov2").save_pretrained(folder)
    (folder / "preprocessor_config.json").write_text(
        '{"crop_size": {"height": 48, "width": 48}, "size": {"shortest_edge": 56}, '
        '"image_mean": [0.5, 0.5, 0.5], "image_std": [0.25, 0.25, 0.25]}'
    )
    said = load_encoder(f"hf:{folder}").preprocessing
    assert said.startswith("resize 48x48 bicubic, RGB, mean 0.5 0.5 0.5, std 0.25 0.25 0.25")


def test_a_model_whose_weights_are_not_all_there_is_refused(tmp_path):
    from safetensors.torch import load_file, save_file

    folder = tmp_path / "model"
    vision_model("dinov2").save_pretrained(folder)
    state = load_file(folder / "model.safetensors")
    state.pop("layernorm.weight")
    save_file(state, folder / "model.safetensors", metadata={"format": "pt"})
    with pytest.raises(
        DataError, match=r"lacks 1 weights of Dinov2Model, such as layernorm\.weight"
    ):
        load_encoder(f"hf:{folder}")


@pytest.mark.parametrize(
    ("name", "match"),
    [
        ("hf:./nowhere", "is not a folder with a model"),
        ("hf:owner/name", "no model 'owner/name' on this machine. There is no hub here."),
    ],
)
def test_a_model_that_is_not_there_is_named(name, match):
    with pytest.raises(DataError, match=match):
        load_encoder(name)


def test_a_model_of_texts_is_refused(tmp_path):
    transformers = pytest.importorskip("transformers")
    config = transformers.BertConfig(**LETTERS, intermediate_size=48)
    transformers.AutoModel.from_config(config).save_pretrained(tmp_path)
    with pytest.raises(DataError, match="BertModel does not take images alone"):
        load_encoder(f"hf:{tmp_path}")


def test_a_folder_of_something_else_is_refused_in_one_line(tmp_path):
    (tmp_path / "config.json").write_text("{}")
    with pytest.raises(DataError, match="cannot be loaded as a model of transformers") as caught:
        load_encoder(f"hf:{tmp_path}")
    assert "\n" not in str(caught.value)
