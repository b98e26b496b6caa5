"""What an encoder costs for one picture, in processor time on this machine."""

import time
from typing import Any

import numpy as np
import torch
from PIL import Image

from omnivat.data.dots import FILLED
from omnivat.data.embeddings import Header
from omnivat.data.relief.files import touch_of
from omnivat.encoders.base import CHOSEN, ENCODERS, JOINED, for_modality, load_encoder
from omnivat.kit.errors import OmniVatError

ROUNDS, SIDE = 5, 240  # pixels of the picture


def cost_of(header: Header) -> float | None:
    """Return milliseconds of processor time for one picture, the median of ROUNDS; None where the
    encoder is no entry of the project's table, or its weights are not here.

    A name in a file loads no code of others. A set of both modalities has the mean of both.
    """
    parts = header.encoder.split(JOINED)
    known = [match and match[1] in ENCODERS for match in map(CHOSEN.fullmatch, parts)]
    if not all(known):
        return None
    drawn: dict[str, Any] = {
        "dots": "fill" if FILLED in header.preprocessing else "keep",
        "touch": touch_of(header.preprocessing),
    }
    noise = np.random.default_rng(0).integers(0, 255, (SIDE, SIDE, 3), np.uint8)
    picture = Image.fromarray(noise)
    try:
        encoder = load_encoder(header.encoder, download="no", **drawn)
        if encoder.weights_hash != header.weights_hash:
            return None
        each = []
        for modality in header.modalities:
            own = for_modality(encoder, modality)
            times = []
            for _ in range(1 + ROUNDS):
                start = time.process_time()
                with torch.inference_mode():
                    own.embed(own.preprocess(picture)[None])
                times.append(time.process_time() - start)
            each.append(float(np.median(times[1:])))
    except (OmniVatError, TypeError):  # weights elsewhere, or several pictures are wanted
        return None
    return 1000 * float(np.mean(each))
