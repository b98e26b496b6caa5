"""Make the LANG bank: text embeddings of the classes in eighty styles, fixed or learned.

python -m omnivat prompts --out FILE [--classes wood,steel,...] [--encoder minilm|clip-...]
python -m omnivat prompts --out FILE --encoder clip-vit-b16 --method promptstyler
"""

import argparse
from typing import TYPE_CHECKING

from omnivat.cli.arguments import count, declare, download, listed, one_of, passed, progress_bar
from omnivat.data.materials import MATERIALS
from omnivat.kit.errors import SettingsError
from omnivat.kit.files import require_writable

if TYPE_CHECKING:
    from omnivat.encoders.clip_text import ClipText
    from omnivat.encoders.lang.bank import LangBank

CLIPS = (
    "clip-vit-b32",
    "clip-vit-b16",
    "clip-vit-l14",
    "clip-vit-l14-336",
    "clip-rn50",
    "clip-rn101",
    "clip",
)
TEXT_ENCODERS = ("minilm", *CLIPS)
METHODS = ("phrases", "promptstyler")


def add(parser: argparse.ArgumentParser) -> None:
    words = "eighty fixed style phrases, or styles learned as word vectors (CLIP only)"
    declare(
        parser,
        "out",
        "device",
        classes={"type": listed, "default": tuple(MATERIALS), "help": "names, with commas"},
        encoder=one_of(TEXT_ENCODERS, "text encoder"),
        weights="checkpoint of a CLIP encoder",
        seed="of the learned styles",
        method=one_of(METHODS, words),
        styles=count("number of styles for promptstyler", default=80),
        steps=count("steps for each learned style", default=100),
    )
    download(parser)


def run(options: argparse.Namespace) -> None:
    """Embed one prompt for each class and style, write the bank."""
    from omnivat.encoders.lang.bank import save_bank

    classes = options.classes
    if len(classes) < 2 or len(set(classes)) < len(classes):
        raise SettingsError(f"--classes is {','.join(classes)}; give two or more different names.")
    require_writable(options.out)
    learned, clip = options.method == "promptstyler", None
    if learned and options.encoder == "minilm":
        raise SettingsError(
            "--method promptstyler learns word vectors through CLIP's text tower; "
            "add --encoder clip-vit-b16 or --encoder clip-vit-l14."
        )
    if options.encoder != "minilm":
        from omnivat.encoders.clip_text import load_text_encoder

        clip = load_text_encoder(
            options.encoder, **passed(options, "weights", "device", "download")
        )
    bank = _learned(options, classes, clip) if learned and clip else _phrases(classes, clip)
    save_bank(options.out, _of_clip(bank, clip) if clip else bank)
    print(f"{bank.embeddings[..., 0].size} texts by {bank.origin} written to {options.out}")


def _phrases(classes: tuple[str, ...], clip: "ClipText | None") -> "LangBank":
    """Embed the classes in fixed phrases."""
    import numpy as np

    from omnivat.encoders.lang.bank import LangBank
    from omnivat.encoders.lang.prompts import ORIGIN, STYLES, embed_texts, prompts_for

    texts = [text for name in classes for text in prompts_for(name)]
    if clip is None:
        values, origin = embed_texts(texts), ORIGIN
    else:
        values = clip.embed_texts(texts).cpu().numpy()
        origin = f"{clip.name}, fixed style phrases, not PromptStyler"
    shaped = values.astype(np.float32).reshape(len(classes), len(STYLES), -1)
    return LangBank(embeddings=shaped, classes=classes, origin=origin)


def _learned(options: argparse.Namespace, classes: tuple[str, ...], clip: "ClipText") -> "LangBank":
    """Learn styles through CLIP's text tower."""
    from omnivat.encoders.lang.clip_prompts import ClipPrompts
    from omnivat.encoders.lang.promptstyler import learn_styles, styled_bank

    tower = ClipPrompts(clip.network, clip.tokenizer)
    with progress_bar("learn styles") as show:
        words = learn_styles(
            tower, classes, **passed(options, "styles", "steps", "seed"), on_step=show
        )
    origin = (
        f"PromptStyler stage 1, {len(words)} styles of {options.steps} steps, seed {options.seed},"
        f" through {clip.name} (weights {clip.weights_hash[:12]})"
    )
    return styled_bank(tower, classes, words, origin=origin)


def _of_clip(bank: "LangBank", clip: "ClipText") -> "LangBank":
    """Return the bank with the plain prompts, the tower's hash and the model's logit scale."""
    from dataclasses import replace

    from omnivat.encoders.hub import remember
    from omnivat.encoders.lang.bank import PLAIN

    remember(clip.weights_hash, clip.place)
    plain = clip.embed_texts([PLAIN.format(name) for name in bank.classes])
    return replace(
        bank,
        plain=plain.cpu().numpy(),
        encoder=clip.name,
        text_hash=clip.weights_hash,
        logit_scale=clip.logit_scale,
    )
