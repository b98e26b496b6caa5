"""`omnivat prompts`: fixed phrases or learned styles."""

from types import SimpleNamespace

import torch

from omnivat.cli import main
from omnivat.encoders.lang.bank import load_bank


def test_learning_styles_needs_a_tower_with_word_vectors(tmp_path, capsys):
    code = main(["prompts", "--out", str(tmp_path / "bank"), "--method", "promptstyler"])
    assert code == 1
    assert "add --encoder clip-vit-b16" in capsys.readouterr().err


def test_styles_are_learned_through_clip_and_the_bank_says_so(tmp_path, monkeypatch, capsys):
    """The tower is a stand-in whose embedding is the word vector plus a vector for each text."""

    class Words:
        word_width = 4

        def __init__(self, network, tokenizer):
            pass

        def embed_with_word(self, texts, word=None):
            random = [torch.Generator().manual_seed(len(text)) for text in texts]
            rows = torch.stack([torch.randn(4, generator=r) for r in random])
            return rows if word is None else rows + word

    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    clip = SimpleNamespace(
        network=None,
        tokenizer=None,
        name="clip-vit-b16",
        weights_hash="0123456789abcdef",
        logit_scale=12.5,
        place=tmp_path,
        embed_texts=lambda texts: torch.ones(len(texts), 4),
    )
    monkeypatch.setattr("omnivat.encoders.clip_text.load_text_encoder", lambda name, **_: clip)
    monkeypatch.setattr("omnivat.encoders.lang.clip_prompts.ClipPrompts", Words)
    out = tmp_path / "bank.safetensors"
    command = ["prompts", "--out", str(out), "--encoder", "clip-vit-b16", "--styles", "3"]
    assert main([*command, "--method", "promptstyler", "--steps", "2", "--seed", "7"]) == 0
    bank = load_bank(out)
    assert bank.embeddings.shape == (5, 3, 4)
    assert (
        bank.origin
        == "PromptStyler stage 1, 3 styles of 2 steps, seed 7, through clip-vit-b16 (weights"
        " 0123456789ab)"
    )
    assert "15 texts by PromptStyler" in capsys.readouterr().out
    assert (bank.encoder, bank.text_hash) == ("clip-vit-b16", "0123456789abcdef")
    assert bank.logit_scale == 12.5 and bank.plain.shape == (5, 4)
