"""The LANG bank: what it keeps, and that texts of another checkpoint are refused."""

from dataclasses import replace

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.embeddings import Header
from omnivat.encoders import load_encoder
from omnivat.encoders.lang.bank import PLAIN, LangBank, load_bank, save_bank
from omnivat.kit.errors import DataError
from omnivat.training import TrainSettings, train
from tests.builders import head_settings

BANK = LangBank(
    embeddings=np.arange(24, dtype=np.float32).reshape(2, 3, 4),
    classes=("wood", "steel"),
    origin="a test",
    plain=np.zeros((2, 4), np.float32),
    encoder="clip-vit-b16",
    text_hash="aaaa",
    logit_scale=14.25,
)
HEADER = Header(
    encoder="clip-vit-b16",
    weights_hash="1",
    preprocessing="none",
    domains=("TAG",),
    classes=("wood", "steel"),
    text_hash="aaaa",
)


def test_a_bank_is_read_as_it_was_written(tmp_path):
    save_bank(tmp_path / "bank.safetensors", BANK)
    found = load_bank(tmp_path / "bank.safetensors")
    assert np.array_equal(found.embeddings, BANK.embeddings)
    assert found.plain is not None and np.array_equal(found.plain, BANK.plain)
    for name in ("classes", "origin", "encoder", "text_hash", "logit_scale"):
        assert getattr(found, name) == getattr(BANK, name)
    turned = found.for_classes(("steel", "wood"))
    assert turned.text_hash == "aaaa" and turned.plain is not None
    assert np.array_equal(turned.embeddings, BANK.embeddings[::-1]) and turned.hash != BANK.hash
    assert turned.plain.shape == (2, 4)


def test_texts_are_of_the_images_where_one_checkpoint_made_both():
    assert BANK.is_of(HEADER)
    assert not BANK.is_of(replace(HEADER, text_hash=""))
    assert not replace(BANK, text_hash="").is_of(HEADER)
    assert not BANK.is_of(replace(HEADER, encoder="clip-vit-l14", text_hash="bbbb"))


def test_a_bank_of_another_checkpoint_of_the_same_name_and_width_is_refused():
    with pytest.raises(DataError, match=r"text tower aaaa.*text tower bbbb.*omnivat prompts"):
        BANK.is_of(replace(HEADER, text_hash="bbbb"))


def test_the_command_records_the_tower_of_the_checkpoint(clips, tmp_path, monkeypatch):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    place = clips.write("OpenAI state dict", tmp_path / "clip", clips.small_model())
    out = tmp_path / "bank.safetensors"
    command = ["prompts", "--encoder", "clip", "--weights", str(place), "--out", str(out)]
    assert main([*command, "--classes", "wood,steel"]) == 0
    bank = load_bank(out)
    encoder = load_encoder("clip", weights=place)
    assert bank.text_hash == encoder.text_hash and bank.encoder == "clip"
    assert bank.logit_scale == pytest.approx(np.exp(2.6592), rel=1e-4)
    assert bank.embeddings.shape == (2, 80, 24) and bank.plain is not None
    wanted = clips.text_embeddings(clips.small_model(), [PLAIN.format("wood")])[0]
    np.testing.assert_allclose(bank.plain[0], wanted, atol=2e-3)  # kept in half precision


def test_a_bank_without_a_class_says_how_to_make_one():
    with pytest.raises(
        DataError, match="no text for rubber.*omnivat prompts --classes wood,rubber"
    ):
        load_bank().for_classes(("wood", "rubber"))


def test_training_refuses_it_too(make_embeddings):
    pairs = make_embeddings(domains=("TAG-sim",))
    pairs = replace(pairs, header=replace(pairs.header, encoder="clip-vit-b16", text_hash="bbbb"))
    texts = np.ones((5, 3, 4), np.float32)
    bank = replace(BANK, embeddings=texts, classes=pairs.header.classes, plain=None)
    head = head_settings(pairs, lang_width=4, width=8)
    with pytest.raises(DataError, match="another checkpoint"):
        train(pairs, head, TrainSettings(epochs=1), bank=bank)
