"""Films as phones, browsers and sensors write them: turned, of untrue length, unequal."""

import os
import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from omnivat.data.recordings import clips_of, write_pairs
from omnivat.data.recordings.tracks import Film
from omnivat.kit.errors import DataError
from tests.unit.data.films import MATRICES, film, turned


def shown(folder, half):
    """Return the grey of each picture that was written, in order."""
    files = sorted(folder.rglob(f"*_{half}.png"))
    return [round(float(np.asarray(Image.open(file).convert("L"), float).mean())) for file in files]


def imported(folder, vis, tac, **options):
    (folder / "videos.csv").write_text(f"vis,tac,material\n{vis},{tac},wood\n")
    return write_pairs(clips_of(folder), folder / "out", **options)


@pytest.mark.parametrize("matrix", MATRICES)
def test_a_turned_or_mirrored_film_is_shown_upright_photo_and_touch_alike(tmp_path, matrix):
    film(tmp_path / "a.mp4", [200] * 12, spot=slice(0, 16))
    turned(tmp_path / "a.mp4", matrix)
    imported(tmp_path, "a.mp4", "a.mp4", frames=1)
    plain = np.full((48, 48, 3), 50)
    plain[:16, :16] = 200
    for half in ("vis", "tac"):
        (file,) = (tmp_path / "out").rglob(f"*_{half}.png")
        assert np.abs(np.asarray(Image.open(file), int) - MATRICES[matrix](plain)).mean() < 3


@pytest.mark.parametrize(
    ("name", "options"),
    [
        ("live.webm", {"codec": "libvpx", "live": "1"}),  # states no length
        ("sound.mkv", {"codec": "mpeg4", "sound": 4.0}),  # is as long as its sound
        ("plain.avi", {"codec": "mpeg4"}),
        ("stream.mpg", {"format": "mpegts"}),  # does not begin at 0, and has no index
    ],
)
def test_a_film_lasts_as_long_as_its_pictures(tmp_path, name, options):
    film(tmp_path / name, range(100, 140, 2), **options)
    assert imported(tmp_path, name, name, frames=4).pairs == 4
    assert shown(tmp_path / "out", "vis") == pytest.approx([104, 114, 124, 134], abs=2)


def test_a_film_has_its_length_where_freed_memory_is_overwritten(tmp_path):
    film(tmp_path / "a.mp4", range(100, 120))
    code = (
        "from omnivat.data.recordings.tracks import Film; from pathlib import Path; import sys;"
        "print(Film(file=Path(sys.argv[1])).shown(None)[1])"
    )
    done = subprocess.run(
        [sys.executable, "-c", code, str(tmp_path / "a.mp4")],
        env=os.environ | {"MALLOC_PERTURB_": "165"},
        capture_output=True,
        text=True,
    )
    assert (done.stdout, done.stderr) == ("2.0\n", "")


def test_a_last_picture_that_is_held_is_shown_until_it_ends(tmp_path):
    film(tmp_path / "a.mp4", range(100, 109), codec="mpeg4", hold=3.2)
    assert imported(tmp_path, "a.mp4", "a.mp4", frames=4).pairs == 4
    assert shown(tmp_path / "out", "tac") == pytest.approx([105, 108, 108, 108], abs=1.5)


@pytest.mark.parametrize(
    ("align", "photos", "touches"),
    [("time", (104, 112), (102, 106)), ("share", (104, 112), (105, 115))],
)
def test_films_of_other_length_and_rate_are_paired_by_time_or_by_share(
    tmp_path, align, photos, touches
):
    film(tmp_path / "photo.mp4", range(100, 116), rate=20)  # 0.8 s
    film(tmp_path / "touch.mp4", range(100, 120), rate=10)  # 2 s
    made = imported(tmp_path, "photo.mp4", "touch.mp4", frames=2, align=align)
    assert shown(tmp_path / "out", "vis") == pytest.approx(photos, abs=1.5)
    assert shown(tmp_path / "out", "tac") == pytest.approx(touches, abs=1.5)
    assert made.unequal == ["row 2 (0.8 s, 2.0 s)"]


def test_a_list_of_films_in_place_of_a_film_leads_to_no_other_file(tmp_path):
    film(tmp_path / "a.mp4", range(100, 120))
    (tmp_path / "b.mp4").write_text("ffconcat version 1.0\nfile a.mp4\n")
    with pytest.raises(DataError, match="b.mp4' is no video that can be read"):
        Film(file=tmp_path / "b.mp4").shown(None)
