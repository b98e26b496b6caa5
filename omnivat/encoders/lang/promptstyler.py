"""PromptStyler, stage 1: word vectors of distinct styles that keep the class readable."""

from collections.abc import Sequence

import torch
from torch import Tensor
from torch.nn.functional import cross_entropy, normalize

from omnivat.encoders.lang.bank import LangBank
from omnivat.encoders.lang.clip_prompts import WORD, ClipPrompts
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.seeding import derive_seed

STYLE = f"a {WORD} style of a"


def style_loss(style: Tensor, earlier: Tensor) -> Tensor:
    """Return the mean |cosine| of a style (D,) with earlier styles (S, D); 0 for S = 0."""
    if not len(earlier):
        return style.new_zeros(())
    return (normalize(earlier, dim=-1) @ normalize(style, dim=-1)).abs().mean()


def content_loss(styled: Tensor, contents: Tensor) -> Tensor:
    """Return the cross-entropy of classifying styled classes by their plain names.

    styled, contents  (K, D) embeddings of "a S style of a CLASS" and of "CLASS"
    """
    logits = normalize(styled, dim=-1) @ normalize(contents, dim=-1).T
    return cross_entropy(logits, torch.arange(len(logits), device=logits.device))


def learn_styles(
    tower: ClipPrompts,
    classes: Sequence[str],
    *,
    styles: int = 80,
    steps: int = 100,
    lr: float = 2e-3,
    momentum: float = 0.9,
    seed: int = 0,
    on_step: OnStep = ignore,
) -> Tensor:
    """Return word vectors (styles, W), learned one after the other.

    Each starts at random (standard deviation 0.02) and takes `steps` steps of SGD on the sum of
    `style_loss`, against earlier styles, and `content_loss`. Only the word vector is trained.
    Source: Cho et al., PromptStyler, ICCV 2023, stage 1.
    """
    with torch.no_grad():
        contents = tower.embed_with_word(list(classes))
    texts = [STYLE, *styled_texts(classes)]
    words: list[Tensor] = []
    earlier = contents[:0]
    for index in range(styles):
        random = torch.Generator().manual_seed(derive_seed(seed, "style", index))
        word = (
            (0.02 * torch.randn(tower.word_width, generator=random)).to(contents).requires_grad_()
        )
        optimiser = torch.optim.SGD([word], lr=lr, momentum=momentum)
        for _ in range(steps):
            embedded = tower.embed_with_word(texts, word)
            loss = style_loss(embedded[0], earlier) + content_loss(embedded[1:], contents)
            (word.grad,) = torch.autograd.grad(loss, [word])
            optimiser.step()
        words.append(word.detach())
        with torch.no_grad():
            earlier = torch.cat((earlier, tower.embed_with_word([STYLE], words[-1])))
        on_step(Step(done=index + 1, total=styles, text="styles"))
    return torch.stack(words)


def styled_bank(
    tower: ClipPrompts, classes: Sequence[str], words: Tensor, *, origin: str
) -> LangBank:
    """Return the LANG bank of all classes in the styles `words` (S, W)."""
    texts = styled_texts(classes)
    with torch.no_grad():
        rows = [tower.embed_with_word(texts, word) for word in words]
    embeddings = torch.stack(rows, dim=1).float().cpu().numpy()
    return LangBank(embeddings=embeddings, classes=tuple(classes), origin=origin)


def styled_texts(classes: Sequence[str]) -> list[str]:
    """Return the prompt of each class, with a placeholder for the style.

    >>> styled_texts(["wood"])
    ['a x style of a wood']
    """
    return [f"{STYLE} {name}" for name in classes]
