"""The sheet of thumbnails: every pair has its tiles, and what is missing is counted."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.cli.thumbnails import start_of
from omnivat.data.store import save_embeddings
from omnivat.kit.errors import DataError
from omnivat.maps.thumbnails import write_thumbnails


@pytest.fixture
def pictures(make_embeddings, tmp_path):
    """A set of four pairs whose images are on disk, each of one colour."""
    chosen = make_embeddings(domains=("TAG-sim",), per_class=1).select(
        make_embeddings(domains=("TAG-sim",), per_class=1).label < 4
    )
    for index, name in enumerate([*chosen.rows["vis"], *chosen.rows["tac"]]):
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        Image.new("RGB", (20, 10), (30 * index, 0, 200)).save(path)
    return chosen, tmp_path


def test_tile_i_is_pair_i_and_tile_n_plus_i_its_touch(pictures, tmp_path):
    chosen, root = pictures
    assert write_thumbnails(chosen, root, tmp_path / "s.webp", tile=16) == 0
    about = json.loads((tmp_path / "s.json").read_text())
    assert about == {"tile": 16, "columns": 3, "count": 8}
    sheet = Image.open(tmp_path / "s.webp").convert("RGB")
    for index in range(8):
        left, top = index % 3 * 16, index // 3 * 16
        red = sheet.getpixel((left + 8, top + 8))[0]
        assert abs(red - 30 * index) <= 6


def test_an_unreadable_image_leaves_a_grey_tile_and_is_counted(pictures, tmp_path):
    chosen, root = pictures
    (root / chosen.rows["vis"][1]).write_bytes(b"no image")
    assert write_thumbnails(chosen, root, tmp_path / "s.webp", tile=16) == 1
    grey = Image.open(tmp_path / "s.webp").convert("RGB").getpixel((24, 8))
    assert all(abs(value - 128) <= 4 for value in grey)


def test_a_folder_without_any_of_the_images_is_refused_and_nothing_is_written(pictures, tmp_path):
    chosen, _ = pictures
    with pytest.raises(DataError, match="None of the 8 images is under"):
        write_thumbnails(chosen, tmp_path / "elsewhere", tmp_path / "s.webp")
    assert not (tmp_path / "s.webp").exists()


def test_a_set_too_large_for_one_sheet_says_which_tile_would_fit(make_embeddings, tmp_path):
    chosen = make_embeddings(domains=("TAG-sim",), per_class=1)
    many = replace(chosen, rows={k: v * 20_000 for k, v in chosen.rows.items()})
    with pytest.raises(DataError, match="choose --tile 36 or less"):
        write_thumbnails(many, tmp_path, tmp_path / "s.webp")


def test_the_names_start_where_the_images_of_a_table_are(pictures, tmp_path):
    embeddings, root = pictures
    table = tmp_path / "elsewhere" / "mine.csv"
    table.parent.mkdir()
    lines = [
        f"{root / vis},{root / tac},lab,wood"
        for vis, tac in zip(embeddings.rows["vis"], embeddings.rows["tac"], strict=True)
    ]
    table.write_text("\n".join(["vis,tac,domain,material", *lines]))
    assert start_of(table, embeddings.rows["vis"]) == root


def test_images_that_lie_deeper_are_found_where_only_one_place_has_them(pictures, tmp_path):
    embeddings, _ = pictures
    names = embeddings.rows["vis"]
    inner = tmp_path / "set" / "dataset"
    for place in (inner, tmp_path / "set" / "copy"):
        (place / names[0]).parent.mkdir(parents=True)
        (place / names[0]).touch()
        wanted = inner if place == inner else tmp_path / "set"
        assert start_of(tmp_path / "set", names) == wanted


def test_the_command_writes_the_sheet_beside_the_embeddings(pictures, tmp_path, capsys):
    chosen, root = pictures
    save_embeddings(tmp_path / "set.safetensors", chosen)
    (root / chosen.rows["tac"][0]).unlink()
    line = ["--embeddings", str(tmp_path / "set.safetensors"), "--tile", "16"]
    assert main(["thumbnails", str(root), *line]) == 0
    sheet = tmp_path / "set.thumbnails.webp"
    assert f"8 thumbnails written to {sheet}, 1 images missing" in capsys.readouterr().out
    with Image.open(sheet) as image:
        assert image.size == (48, 48)
    assert main(["thumbnails", str(tmp_path / "none"), *line]) == 1
    assert "There is no folder or file at" in capsys.readouterr().err


def test_a_set_without_pairs_has_no_sheet(make_embeddings, tmp_path):
    none = make_embeddings().select(np.array([], dtype=np.int64))
    with pytest.raises(DataError, match="no pairs in these embeddings"):
        write_thumbnails(none, tmp_path, tmp_path / "sheet.webp")
