"""PromptStyler's first stage, on a tiny random CLIP text tower."""

import numpy as np
import pytest
import torch

from omnivat.encoders.lang.clip_prompts import ClipPrompts
from omnivat.encoders.lang.promptstyler import (
    STYLE,
    content_loss,
    learn_styles,
    style_loss,
    styled_bank,
    styled_texts,
)

CLASSES = ("wood", "steel", "glass")
WORDS = ["<pad>", "x", "a", "style", "of", *CLASSES, "<bos>", "<eos>"]


class Tokenizer:
    """A word is a token; the last id ends a text, as in CLIP."""

    def __call__(self, texts, padding=False, return_tensors="pt"):
        rows = [[8, *(WORDS.index(word) for word in text.split()), 9] for text in texts]
        width = max(map(len, rows))
        ids = torch.tensor([row + [9] * (width - len(row)) for row in rows])
        mask = torch.tensor([[1] * len(row) + [0] * (width - len(row)) for row in rows])
        return {"input_ids": ids, "attention_mask": mask}


@pytest.fixture(scope="module")
def network():
    transformers = pytest.importorskip("transformers")
    config = transformers.CLIPTextConfig(
        vocab_size=10,
        hidden_size=16,
        intermediate_size=32,
        num_hidden_layers=2,
        num_attention_heads=2,
        max_position_embeddings=12,
        projection_dim=12,
        bos_token_id=8,
        eos_token_id=9,
        pad_token_id=0,
    )
    with torch.random.fork_rng():
        torch.manual_seed(0)
        model = transformers.CLIPTextModelWithProjection(config)
        for parameter in model.parameters():
            torch.nn.init.normal_(parameter, std=0.2)
    return model


@pytest.fixture(scope="module")
def tower(network):
    return ClipPrompts(network, Tokenizer())


def test_putting_in_another_words_vector_is_reading_that_word(network, tower):
    steel = network.get_input_embeddings().weight[WORDS.index("steel")].detach()
    replaced = tower.embed_with_word(["a x style of a wood"], steel)
    torch.testing.assert_close(replaced, tower.embed_with_word(["a steel style of a wood"]))


def test_only_the_word_vector_gets_a_gradient(network, tower):
    word = torch.zeros(16, requires_grad=True)
    tower.embed_with_word([STYLE], word).sum().backward()
    assert word.grad.abs().sum() > 0
    assert all(parameter.grad is None for parameter in network.parameters())


def test_style_loss_is_the_mean_absolute_cosine_to_earlier_styles():
    style = torch.tensor([2.0, 0.0])
    earlier = torch.tensor([[3.0, 0.0], [0.0, 1.0], [-1.0, 0.0]])
    assert style_loss(style, earlier).item() == pytest.approx(2 / 3)
    assert style_loss(style, earlier[:0]).item() == 0


def test_content_loss_falls_when_styled_classes_stay_near_their_names():
    names = torch.eye(3)
    right, mixed = content_loss(5 * names, names), content_loss(names.roll(1, 0), names)
    assert right < mixed
    assert right.item() == pytest.approx(-np.log(np.e / (np.e + 2)), abs=1e-6)


def test_learning_makes_styles_differ_and_keeps_classes_readable(tower):
    start = learn_styles(tower, CLASSES, styles=3, steps=0)
    learned = learn_styles(tower, CLASSES, styles=3, steps=40, lr=1.0)

    def losses(words):
        with torch.no_grad():
            styles = torch.stack([tower.embed_with_word([STYLE], w)[0] for w in words])
            contents = tower.embed_with_word(list(CLASSES))
            likeness = style_loss(styles[-1], styles[:-1])
            content = content_loss(
                tower.embed_with_word(styled_texts(CLASSES), words[-1]), contents
            )
        return float(likeness), float(likeness + content)

    assert losses(learned)[0] < losses(start)[0] - 0.02
    assert losses(learned)[1] < losses(start)[1]


def test_same_seed_gives_the_same_styles_and_a_longer_list_starts_alike(tower):
    short, long, other = (
        learn_styles(tower, CLASSES, styles=n, steps=2, seed=s) for n, s in ((2, 1), (3, 1), (2, 2))
    )
    assert torch.equal(short, long[:2])
    assert not torch.equal(short, other)


def test_the_bank_holds_every_class_in_every_style(tower):
    steps = []
    words = learn_styles(tower, CLASSES, styles=4, steps=1, on_step=steps.append)
    assert [(step.done, step.total) for step in steps] == [(k, 4) for k in (1, 2, 3, 4)]
    bank = styled_bank(tower, CLASSES, words, origin="tiny")
    assert bank.embeddings.shape == (3, 4, 12)
    wanted = tower.embed_with_word(["a x style of a steel"], words[1])[0]
    np.testing.assert_allclose(bank.embeddings[1, 1], wanted.detach().numpy(), rtol=1e-5)
    assert len(np.unique(bank.embeddings[0].round(6), axis=0)) == 4
    assert bank.origin == "tiny"
