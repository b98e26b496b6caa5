"""What a page without a server computes with: heads and encoder as ONNX files, the set in parts.

models.json              classes, orders and files of each head; rows of the examples; limits
first.onnx, own.onnx     the page's head (`omnivat/head/portable.py`), and that for own pictures
familiarity, own-…       of these heads, as their folders have it
set-N.safetensors        embeddings of PART pairs each, in half precision
../encoder-HASH.onnx     one file for all sets of that encoder
places.safetensors       F-hat to its position on each linear map, by method and stop
../resize.onnx           a picture to another size
../look.onnx, …          functions of the library (`app/site/programs.py`)

Each but the script of the runtime is packed as NAME.gz; the browser unpacks it.
"""

import shutil
from collections.abc import Mapping
from gzip import compress
from pathlib import Path
from typing import TYPE_CHECKING, Any

from app.explore.tab import NEIGHBOURS
from app.pair.pictures import PREVIEW_SIDE
from app.pair.tab import trained_span
from app.shared.familiar import NEAREST, training_pairs
from app.shared.resources import Resources
from app.shared.state import content_name
from app.site.runtime import write_runtime
from omnivat.data import images
from omnivat.head import calibration
from omnivat.head.heads import OWN
from omnivat.kit.files import replacing, write_json
from omnivat.kit.progress import OnStep, Step, ignore
from omnivat.kit.stages import IMAGES, STOPS

if TYPE_CHECKING:
    from omnivat.head.checkpoint import Head

HEADS = ("", OWN)  # the page's own, and that for own pictures
PART = 32  # pairs of one file of the set, 0.1 MB of the default encoder, packed
FAMILIARITY = "familiarity.safetensors"
RULES = {  # numbers and words of the library that the scripts use
    "pixels": {"jpeg": images.MAX_PIXELS, "other": images.VISITORS["pixels"]},
    "side": {"least": images.MIN_SIDE, "large": images.SHORT_SIDE, "preview": PREVIEW_SIDE},
    "stops": len(STOPS),
    "familiar": {"words": [words for _, words in calibration.WORDS], "unlike": calibration.UNLIKE},
    "nearest": NEAREST,
    "neighbours": NEIGHBOURS,
}


def write_models(
    desks: Mapping[str, Resources],
    folder: Path,
    runtime: Path | None = None,
    on_step: OnStep = ignore,
) -> str:
    """Write all that the routes of Try a pair need into a new folder of `folder`; return its name.

    The name changes with the content, so a browser may keep every file. Raises MissingPackageError
    if a package of ONNX is not installed, DataError for a head or set that cannot be read.
    """
    from app.site.programs import write_programs
    from omnivat.encoders.onnx_runtime import write_resize

    made = folder / "models"
    write_runtime(made / "runtime", runtime)
    write_resize(made / "resize.onnx")
    write_programs(made)
    for done, (name, resources) in enumerate(desks.items()):
        on_step(Step(done=done, total=len(desks), text=f"models of {name}"))
        write_set(resources, made / name)
    for file in files_in(made):
        if file.suffix != ".mjs":
            pack(file)
    hashes = (bytes.fromhex(content_name(file.read_bytes())) for file in files_in(made))
    return made.rename(folder / f"models-{content_name(b''.join(hashes))[:8]}").name


def files_in(folder: Path) -> list[Path]:
    """Return all files below a folder."""
    return sorted(path for path in folder.rglob("*") if path.is_file())


def pack(file: Path) -> None:
    """Replace a file by its gzip, whose bytes depend on nothing else; a plain server packs
    nothing.
    """
    with replacing(file.with_name(f"{file.name}.gz")) as packed:
        packed.write_bytes(compress(file.read_bytes(), 9, mtime=0))
    file.unlink()


def write_set(resources: Resources, folder: Path) -> None:
    """Write the models of one set into `folder`, and its encoder beside it."""
    import numpy as np
    from safetensors.numpy import save_file

    folder.mkdir(parents=True, exist_ok=True)
    first, embeddings = resources.head(), resources.embeddings()
    first.require_embeddings(embeddings)
    for start in range(0, len(embeddings), PART):
        rows = {
            n: np.asarray(getattr(embeddings, n)[start : start + PART]).astype(np.float16)
            for n in IMAGES
        }
        with replacing(folder / f"set-{start // PART}.safetensors") as file:
            save_file(rows, file)
    heads = {}
    for name in resources.heads.keys() & set(HEADS):
        head = resources.head_named(name)
        index, of = training_pairs(resources, head)
        heads[name] = _write_head(head, folder, name or "first") | {
            "familiarity": _copied(head, folder, name),
            "training": {"index": index.tolist(), "of": of},
        }
    record = {
        "heads": heads,
        "encoder": write_encoder(resources, folder.parent),
        "key": resources.encoder_key(),
        "width": embeddings.width,
        "pairs": len(embeddings),
        "part": PART,
        "rows": resources.example_rows(),
        "stops": write_places(resources, folder / "places.safetensors"),
        "rules": RULES,
    }
    write_json(folder / "models.json", record)


def write_places(resources: Resources, file: Path) -> list[tuple[int, float]]:
    """Write how rows of F-hat are placed on the linear maps of a set: "METHOD STOP" -> (2, D + 1).

    Return the stops of a pair's journey over these maps, each with its order.
    """
    from safetensors.torch import save_file

    from omnivat.maps.frames import read_frames
    from omnivat.maps.journey import map_stops

    found, stops = {}, []
    file_of_frames = resources.frames.wait().file
    if file_of_frames is not None:
        frames = read_frames(file_of_frames)
        for at in map_stops(resources.head(), resources.embeddings(), frames):
            stops.append((at.stop, at.order))
            for method, known in at.affine.items():
                if known is not None:
                    found[f"{method} {at.stop}"] = known.T.float().contiguous()
    with replacing(file) as whole:
        save_file(found, whole)
    return stops


def _copied(head: "Head", folder: Path, name: str) -> str:
    """Copy what a head's folder holds of its familiar images; return the file, "" without it."""
    if not head.path or not (head.path / FAMILIARITY).is_file():
        return ""
    copy = f"{name}-{FAMILIARITY}" if name else FAMILIARITY
    shutil.copyfile(head.path / FAMILIARITY, folder / copy)
    return copy


def write_encoder(resources: Resources, folder: Path) -> dict[str, Any] | None:
    """Write the encoder of a set's head and return how the page uses it; None for one that needs
    Python.
    """
    from omnivat.data.dots import dots_of
    from omnivat.data.relief.files import touch_of
    from omnivat.data.strips import ENCODER as STRIP
    from omnivat.encoders.base import for_modality
    from omnivat.encoders.efficientnet import NAME, EfficientNetLite0
    from omnivat.encoders.running import SIDE
    from omnivat.encoders.strip import StripReader

    wanted = resources.head().encoder
    sides = {NAME: SIDE, STRIP: 0}  # of the picture that it reads; 0: any
    if wanted["name"] not in sides or touch_of(wanted["preprocessing"]) != "colours":
        return None
    file = folder / f"encoder-{wanted['weights_hash']}.onnx"
    encoder = for_modality(resources.encoder(), "vis")
    if not file.is_file() and isinstance(encoder, EfficientNetLite0 | StripReader):
        encoder.write_onnx(file)
    dots = dots_of(wanted["preprocessing"])
    return {"file": file.name, "side": sides[wanted["name"]], "dots": dots}


def _write_head(head: "Head", folder: Path, name: str) -> dict[str, Any]:
    """Write one head; return what the page has to know of it."""
    from omnivat.head.dtg import groups, parents
    from omnivat.head.portable import write_head

    write_head(folder / f"{name}.onnx", head)
    model, own = head.model, head.settings
    count = 0 if own.generation == "none" else 2**own.levels - 1
    return {
        "file": f"{name}.onnx",
        "parents": parents(own.generation, count) if count else [],
        "groups": [[g.start, g.stop] for g in groups(own.generation, count)] if count else [],
        "arrangement": own.generation,
        "in_use": own.tree_at_inference,
        "classes": own.classes,
        "learned": model.order,
        "orders": {n: model.orders[n] for n in IMAGES},
        "span": trained_span(head),
        "linear": own.maps,
        "attends": own.mffa,
        "source": head.source,
    }
