"""Miniature trees of the real layouts, made by the tests that read them."""

import json
from io import BytesIO

import pytest
from PIL import Image


@pytest.fixture(scope="session")
def image_bytes():
    buffer = BytesIO()
    Image.new("RGB", (8, 8), "grey").save(buffer, "PNG")
    return buffer.getvalue()


@pytest.fixture
def tree(tmp_path, image_bytes):
    """Write small images below a folder and return it; `*` in a name stands for vis and tac."""

    def write(*names):
        for name in names:
            for half in ("vis", "tac") if "*" in name else ("",):
                path = tmp_path / name.replace("*", half)
                path.parent.mkdir(parents=True, exist_ok=True)
                path.write_bytes(image_bytes)
        return tmp_path

    return write


@pytest.fixture
def clip(tree):
    """Write a clip of Touch-and-Go: the same ten-digit numbers on both sides."""

    def write(name, frames):
        sides = ("video_frame", "gelsight_frame")
        return tree(*(f"dataset/{name}/{side}/{n:010d}.jpg" for n in frames for side in sides))

    return write


@pytest.fixture
def release(tree):
    """Write a benchmark release of ObjectFolder 2.0: objects by number and material."""
    order = ("Ceramic", "Glass", "Wood", "Plastic", "Iron", "Polycarbonate", "Steel")

    def write(objects, instances=2):
        files = [f"{thing}/{n}.png" for thing in objects for n in range(instances)]
        root = tree(*(f"{side}/{file}" for file in files for side in ("vision", "touch")))
        labels = {str(thing): order.index(name) for thing, name in objects.items()}
        (root / "label.json").write_text(json.dumps(labels))
        rows = [f"{thing},name,1.0,{name},http" for thing, name in objects.items()]
        (root / "objects.csv").write_text("\n".join(rows))
        return root

    return write


@pytest.fixture
def reasons():
    """Return what a reader skipped, with the reasons."""
    return lambda found: {skipped.what: skipped.why for skipped in found.skipped}
