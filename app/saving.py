"""Heads and sets made in the page, as zip files to download."""

import zipfile
from io import BytesIO
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from omnivat.checkpoint import Head
    from omnivat.data.store import Embeddings

HEAD_NOTE = """A head made in the OmniVaT page.

python app.py --head {name}
python -m omnivat evaluate --head {name} --embeddings FILE
"""
SET_NOTE = """A set of embeddings made in the OmniVaT page. It holds no images.

python app.py --embeddings {name}/embeddings.safetensors
python -m omnivat train --embeddings {name}/embeddings.safetensors --source DOMAIN --out my-head
"""


def head_zip(head: "Head", name: str) -> bytes:
    """Return a zip of the head's folder, called `name`."""
    from omnivat.checkpoint import save_head

    with TemporaryDirectory(prefix="omnivat-save-") as folder:
        place = save_head(Path(folder) / name, head)
        return _zipped(place, name, HEAD_NOTE)


def set_zip(embeddings: "Embeddings", name: str) -> bytes:
    """Return a zip of an embeddings file and its manifest, in a folder called `name`."""
    from omnivat.data.store import save_embeddings

    with TemporaryDirectory(prefix="omnivat-save-") as folder:
        place = Path(folder) / name
        place.mkdir()
        save_embeddings(place / "embeddings.safetensors", embeddings)
        return _zipped(place, name, SET_NOTE)


def _zipped(folder: Path, name: str, note: str) -> bytes:
    with BytesIO() as out:
        with zipfile.ZipFile(out, "w", zipfile.ZIP_DEFLATED) as archive:
            for file in sorted(folder.rglob("*")):
                if file.is_file():
                    archive.write(file, f"{name}/{file.relative_to(folder)}")
            archive.writestr(f"{name}/README.txt", note.format(name=name))
        return out.getvalue()
