"""Miniature trees of the real layouts, made by the tests that read them."""

import json
from collections.abc import Callable, Iterable
from io import BytesIO
from pathlib import Path

import pytest
from PIL import Image

Put = Callable[[Path], Path]


@pytest.fixture(scope="session")
def image_bytes() -> bytes:
    buffer = BytesIO()
    Image.new("RGB", (8, 8), "grey").save(buffer, "PNG")
    return buffer.getvalue()


@pytest.fixture
def put(image_bytes: bytes) -> Put:
    """Write a small image at a path, with its folders."""

    def write(path: Path) -> Path:
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_bytes(image_bytes)
        return path

    return write


@pytest.fixture
def pair(put: Put) -> Callable[..., None]:
    """Write both halves of a pair of a plain folder."""

    def write(folder: Path, name: str, vis: str = ".png", tac: str = ".png") -> None:
        put(folder / f"{name}_vis{vis}")
        put(folder / f"{name}_tac{tac}")

    return write


@pytest.fixture
def clip(put: Put) -> Callable[..., None]:
    """Write a clip of Touch-and-Go: the same ten-digit numbers on both sides."""

    def write(root: Path, name: str, frames: Iterable[int]) -> None:
        for number in frames:
            for side in ("video_frame", "gelsight_frame"):
                put(root / "dataset" / name / side / f"{number:010d}.jpg")

    return write


@pytest.fixture
def release(tmp_path: Path, put: Put) -> Callable[..., Path]:
    """Write a benchmark release of ObjectFolder 2.0: objects by number and material."""
    order = ("Ceramic", "Glass", "Wood", "Plastic", "Iron", "Polycarbonate", "Steel")

    def write(objects: dict[int, str], instances: int = 2) -> Path:
        for thing in objects:
            for instance in range(instances):
                for side in ("vision", "touch"):
                    put(tmp_path / side / str(thing) / f"{instance}.png")
        labels = {str(thing): order.index(name) for thing, name in objects.items()}
        (tmp_path / "label.json").write_text(json.dumps(labels))
        rows = [f"{thing},name,1.0,{name},http" for thing, name in objects.items()]
        (tmp_path / "objects.csv").write_text("\n".join(rows))
        return tmp_path

    return write


@pytest.fixture
def item(put: Put) -> Callable[..., None]:
    """Write the frames of one TacQuad item: 70 of each sensor, 72 images of GelSight."""

    def write(root: Path, part: str, name: str, frames: int = 70) -> None:
        folder = root / f"data_{part}" / name
        for sensor in ("gelsight", "digit", "duragel"):
            for number in range(frames):
                put(folder / sensor / f"{number}.png")
            for number in range(frames + 2 * (sensor == "gelsight")):
                put(folder / f"img_{sensor}" / f"{number}.png")

    return write
