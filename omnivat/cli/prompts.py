"""Make the LANG bank: text embeddings of the classes in eighty fixed styles.

python -m omnivat prompts --out FILE [--classes wood,steel,...] [--encoder minilm|clip-...]
"""

import argparse
from pathlib import Path

from omnivat.data.materials import MATERIALS
from omnivat.errors import SettingsError

TEXT_ENCODERS = ("minilm", "clip-vit-b16", "clip-vit-l14")


def add(parser: argparse.ArgumentParser) -> None:
    """Declare the arguments."""
    parser.add_argument("--out", type=Path, required=True, help="the .safetensors file to write")
    parser.add_argument("--classes", default=",".join(MATERIALS), help="names, with commas")
    parser.add_argument("--encoder", choices=TEXT_ENCODERS, default="minilm")
    parser.add_argument("--weights", type=Path, help="checkpoint of a CLIP encoder")


def run(options: argparse.Namespace) -> None:
    """Embed one prompt for each class and style, write the bank."""
    import numpy as np

    from omnivat.lang import minilm
    from omnivat.lang.bank import LangBank, save_bank
    from omnivat.lang.prompts import STYLES, prompts_for

    classes = tuple(name.strip() for name in options.classes.split(",") if name.strip())
    if len(classes) < 2 or len(set(classes)) < len(classes):
        raise SettingsError(f"--classes is '{options.classes}'; give two or more different names.")
    if options.encoder == "minilm":
        embed, origin = minilm.embed_texts, minilm.ORIGIN
    else:
        from omnivat.encoders import text_encoder

        embed = text_encoder(options.encoder, weights=options.weights)
        origin = f"{options.encoder}, fixed style phrases, not PromptStyler"
    texts = [text for name in classes for text in prompts_for(name)]
    embeddings = np.asarray(embed(texts), dtype=np.float32)
    shaped = embeddings.reshape(len(classes), len(STYLES), -1)
    save_bank(options.out, LangBank(embeddings=shaped, classes=classes, origin=origin))
    print(f"{len(texts)} texts by {origin} written to {options.out}")
