"""The page learns with the frames whether the set has thumbnails."""

from dataclasses import replace

import pytest

from app.shared.resources import Resources

from .conftest import served

SHEET = "set.thumbnails.webp"


@pytest.mark.parametrize(("files", "told"), [((SHEET,), "none"), (None, "sheet")])
def test_frames_tell_whether_a_sheet_of_thumbnails_can_be_requested(
    small_places, tmp_path, files, told
):
    for name in (SHEET, "set.thumbnails.json") if files is None else files:
        (tmp_path / name).write_bytes(b"{}")
    embeddings = tmp_path / "set.safetensors"
    embeddings.hardlink_to(small_places.embeddings)
    frames = tmp_path / "frames.bin"
    frames.write_bytes(b"OVFRAMES")
    resources = Resources(replace(small_places, frames=frames, embeddings=embeddings))
    client = served(resources)
    response = client.get("/omnivat/frames")
    assert response.headers["X-Thumbnails"] == told
    status = client.get("/omnivat/thumbnails.json").status_code
    assert status == (200 if told == "sheet" else 404)
    resources.shared.close()
