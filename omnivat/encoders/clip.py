"""Open a CLIP checkpoint of any layout: find it, read it, check its name, load its image tower."""

from pathlib import Path

import torch

from omnivat.encoders.clip_names import clip_state
from omnivat.encoders.clip_settings import ANY, Clip, clip_settings, image_shape, require_name
from omnivat.encoders.clip_towers import ClipTower
from omnivat.encoders.hub import Checkpoint, find
from omnivat.encoders.weights import read_weights
from omnivat.kit.errors import DataError

_OPENAI = (
    "curl -L --create-dirs -o {folder}/%s.pt"
    " https://openaipublic.azureedge.net/clip/models/%s/%s.pt"
)


def _on_hub(name: str, repository: str, megabytes: int) -> Checkpoint:
    fetch = f"hf download {repository} --local-dir {{folder}}"
    return Checkpoint(name=name, hub=repository, fetch=fetch, megabytes=megabytes)


def _at_openai(name: str, file: str, digest: str) -> Checkpoint:
    return Checkpoint(name=name, fetch=_OPENAI % (file, digest, file))


CHECKPOINTS = {
    checkpoint.name: checkpoint
    for checkpoint in (
        _on_hub("clip-vit-b32", "openai/clip-vit-base-patch32", 605),
        _on_hub("clip-vit-b16", "openai/clip-vit-base-patch16", 599),
        _on_hub("clip-vit-l14", "openai/clip-vit-large-patch14", 1711),
        _on_hub("clip-vit-l14-336", "openai/clip-vit-large-patch14-336", 1712),
        _at_openai(
            "clip-rn50", "RN50", "afeb0e10f9e5a86da6080e35cf09123aca3b358a0c3e3b6c78a7b63bc04b6762"
        ),
        _at_openai(
            "clip-rn101",
            "RN101",
            "8fa8567bab74a42d41c5915025a8e4538c3bdbe8804a470a72f30b0d94fab599",
        ),
        Checkpoint(name=ANY, fetch="hf download OWNER/NAME --local-dir {folder}"),
    )
}


def open_clip(name: str, weights: Path | None, *, download: str = "ask") -> Clip:
    """Find and read the checkpoint called `name`, or the one at `weights`.

    download  "ask", "yes" or "no": permission to fetch a missing one (see `hub.py`)

    Raises DataError if it is missing, not a CLIP, or of another size than its name states.
    """
    place = find(CHECKPOINTS[name], weights, download=download)
    found = read_weights(place, name)
    state = clip_state(found.state)
    if state is None:
        raise DataError(
            f"'{found.file}' holds no weights of CLIP (its first name is"
            f" '{min(found.state, default='none')}'); name a checkpoint of CLIP, or use --encoder"
            " hf:FOLDER for another model of transformers."
        )
    try:
        shape = image_shape(state) if state.image else None
    except (KeyError, ValueError) as error:
        raise DataError(f"'{found.file}' lacks the weight {error} of {name}.") from error
    return Clip(
        name=name if shape is None else require_name(name, shape, found.file),
        place=place,
        file=found.file,
        weights=state,
        settings=clip_settings(found, name),
        shape=shape,
    )


def load(
    name: str, *, weights: Path | None, device: torch.device, precision: str, download: str = "ask"
) -> ClipTower:
    """Load the image tower of a CLIP checkpoint as an encoder. Raises DataError if it has none."""
    return ClipTower(open_clip(name, weights, download=download), device, precision)
