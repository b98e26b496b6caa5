"""CLIP checkpoints that are missing or damaged are refused in one sentence."""

import pytest
import torch
from safetensors.torch import load_file, save_file

from omnivat.encoders import load_encoder, text_encoder
from omnivat.encoders.clip import PUBLISHED
from omnivat.encoders.hub import Checkpoint, find
from omnivat.encoders.weights import weights_file
from omnivat.kit.errors import DataError

pytest.importorskip("transformers")
pytestmark = pytest.mark.usefixtures("nothing_outside")

WEIGHTS = "model.safetensors"


@pytest.mark.parametrize("name", [*PUBLISHED][:2])
def test_a_missing_checkpoint_says_in_one_line_how_to_get_it(name, tmp_path):
    with pytest.raises(DataError) as caught:
        load_encoder(name)
    sentence = str(caught.value)
    assert str(tmp_path / "cache" / name) in sentence
    assert "hf download" in sentence or "curl" in sentence
    assert f"OMNIVAT_{name.upper().replace('-', '_')}" in sentence
    assert "\n" not in sentence


def test_the_environment_and_the_default_folder_are_looked_at(tmp_path, monkeypatch):
    checkpoint = Checkpoint(name="clip-rn50", fetch="fetch {folder}")
    checkpoint.folder.mkdir(parents=True)
    assert find(checkpoint, None) == tmp_path / "cache" / "clip-rn50"
    monkeypatch.setenv("OMNIVAT_CLIP_RN50", str(tmp_path))
    assert find(checkpoint, None) == tmp_path


def test_a_file_of_a_known_name_is_taken_before_another_alone(tmp_path):
    for name in ("other.pt", WEIGHTS):
        (tmp_path / name).touch()
    assert weights_file(tmp_path, "clip").name == WEIGHTS
    (tmp_path / WEIGHTS).unlink()
    assert weights_file(tmp_path, "clip").name == "other.pt"


@pytest.mark.parametrize(
    ("damage", "match"),
    [
        (lambda folder: (folder / "config.json").write_text("{"), "not readable JSON"),
        (lambda folder: (folder / WEIGHTS).unlink(), "has no weights"),
        (lambda folder: (folder / WEIGHTS).write_bytes(b"x" * 99), "cannot be read"),
        (
            lambda folder: save_file({"fc.weight": torch.zeros(1)}, folder / WEIGHTS),
            "no weights of",
        ),
        (
            lambda folder: without(folder, "layers.1.mlp.fc2.bias"),
            r"lacks the weight .*mlp\.fc2\.bias",
        ),
        (lambda folder: reshaped(folder, "layers.1.mlp.fc2.bias"), "expected"),
        (
            lambda folder: (folder / "config.json").write_text('{"model_type": "vit"}'),
            "not of a CLIP model but of 'vit'; use --encoder hf:",
        ),
    ],
)
def test_a_damaged_folder_is_refused(clips, tmp_path, damage, match):
    folder = clips.write("transformers folder", tmp_path, clips.small_model())
    damage(folder)
    with pytest.raises(DataError, match=match):
        load_encoder("clip", weights=folder)


def without(folder, ending):
    state = load_file(folder / WEIGHTS)
    kept = {k: v for k, v in state.items() if not k.endswith(ending) or k.startswith("text")}
    save_file(kept, folder / WEIGHTS)


def reshaped(folder, ending):
    state = load_file(folder / WEIGHTS)
    save_file(
        {k: v[:-1].clone() if k.endswith(ending) else v for k, v in state.items()}, folder / WEIGHTS
    )


@pytest.mark.parametrize(("width", "heads"), [(96, "1.5")])
def test_a_width_that_no_heads_of_64_fill_needs_its_settings(clips, tmp_path, width, heads):
    model = clips.small_model(hidden_size=width)
    place = clips.write("bare safetensors", tmp_path, model)
    with pytest.raises(DataError, match=f"width {width}, which {heads} attention heads cannot"):
        load_encoder("clip", weights=place)


def test_a_folder_without_a_tokenizer_is_refused_where_no_package_carries_one(
    clips, tmp_path, monkeypatch
):
    monkeypatch.setattr("omnivat.encoders.clip_text.CARRIERS", ())
    folder = clips.write("transformers folder", tmp_path / "clip", clips.small_model())
    for file in folder.iterdir():
        if file.name not in ("config.json", WEIGHTS):
            file.unlink()
    with pytest.raises(DataError, match="no tokenizer"):
        text_encoder("clip", weights=folder)


def test_a_tokenizer_of_another_model_is_refused(clips, tmp_path):
    model = clips.small_model()
    place = clips.write("transformers folder", tmp_path, model)
    more = clips.tokenizer()
    more.add_tokens([f"new{i}" for i in range(9)])
    more.save_pretrained(place)
    with pytest.raises(DataError, match="609 tokens and the text tower 600"):
        text_encoder("clip", weights=place)


def test_published_merges_give_the_tokens_of_the_published_vocabulary(tmp_path):
    """Two merges, so `ab` is one token, in the order: bytes, bytes ending a word, merges, marks."""
    import gzip

    from omnivat.encoders.clip_text import MERGES, load_tokenizer

    (tmp_path / MERGES).write_bytes(gzip.compress(b"#version\na b\nb c</w>"))
    found = load_tokenizer(tmp_path, longest=9, vocabulary=49408)
    assert found("ab a bc")["input_ids"] == [514, 64, 65 + 256, 64 + 256, 513, 515]


def test_a_given_place_that_is_missing_is_named(tmp_path):
    with pytest.raises(DataError, match="nowhere"):
        load_encoder("clip-vit-b16", weights=tmp_path / "nowhere")
