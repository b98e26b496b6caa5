"""Recordings: LeRobot data sets in both layouts, and tables of videos, become folders of pairs."""

import io
import json
import os
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from omnivat.data.recordings import clips_of, is_recording, write_pairs
from omnivat.data.recordings.films import decoded
from omnivat.data.recordings.lerobot import LACKING
from omnivat.kit.errors import DataError, MissingPackageError, SettingsError, WriteError
from tests.unit.data.films import FPS, film

parquet = pytest.importorskip("pyarrow.parquet")
pa = pytest.importorskip("pyarrow")

LENGTH = 20
VIS, TAC = "observation.images.wrist", "observation.images.tactile_left"
HALVES = {VIS: "vis", TAC: "tac"}
TASKS = ("press wood", "press steel", "press wood")
PATHS = {  # of tables and of videos
    "v2.1": (
        "data/chunk-{episode_chunk:03d}/episode_{episode_index:06d}.parquet",
        "videos/chunk-{episode_chunk:03d}/{video_key}/episode_{episode_index:06d}.mp4",
    ),
    "v3.0": (
        "data/chunk-{chunk_index:03d}/file-{file_index:03d}.parquet",
        "videos/{video_key}/chunk-{chunk_index:03d}/file-{file_index:03d}.mp4",
    ),
}


def grey(episode, k, half):
    """Return the level that frame k of an episode shows: its code, so that pictures can be told
    apart.
    """
    return (20 + 60 * episode + 2 * k + (100 if half == "vis" else 0)) % 256


def png(value):
    with io.BytesIO() as handle:
        Image.new("RGB", (48, 48), (value,) * 3).save(handle, "PNG")
        return handle.getvalue()


def table(file, rows):
    file.parent.mkdir(parents=True, exist_ok=True)
    parquet.write_table(pa.Table.from_pylist(rows), file)


def info(version, kind, **more):
    features = {key: {"dtype": kind, "shape": [48, 48, 3]} for key in HALVES}
    data, films = PATHS[version]
    return {
        "codebase_version": version, "fps": FPS, "chunks_size": 1000, "data_path": data,
        "video_path": films, "features": features | {"action": {"dtype": "float32"}}, **more,
    }  # fmt: skip


def lerobot(root, version="v2.1", kind="image", **more):
    """Write a data set of three episodes; in v3 all of them share a file."""
    (root / "meta").mkdir(parents=True)
    (root / "meta" / "info.json").write_text(json.dumps(info(version, kind, **more)))
    rows = [{"episode_index": n, "length": LENGTH, "tasks": [task]} for n, task in enumerate(TASKS)]
    rows[0]["tasks"] = TASKS[0] if version == "v2.1" else rows[0]["tasks"]  # either is written
    groups = [[0], [1], [2]]
    if version == "v3.0":
        groups, places = [[0, 1, 2]], ["data", *(f"videos/{key}" for key in HALVES)]
        for n, row in enumerate(rows):
            row |= {f"{p}/{name}": 0 for p in places for name in ("chunk_index", "file_index")}
            row |= {f"videos/{key}/from_timestamp": n * LENGTH / FPS for key in HALVES}
        table(root / "meta" / "episodes" / "chunk-000" / "file-000.parquet", rows)
    else:
        (root / "meta" / "episodes.jsonl").write_text("\n".join(map(json.dumps, rows)) + "\n")
    for episodes in groups:
        names = {
            "episode_index": episodes[0],
            "episode_chunk": 0,
            "chunk_index": 0,
            "file_index": 0,
        }
        data, films = PATHS[version]
        frames = [(episode, k) for episode in episodes for k in range(LENGTH)]
        if kind == "video":
            for key, half in HALVES.items():
                values = [grey(*frame, half) for frame in frames]
                film(root / films.format(video_key=key, **names), values)
        else:
            cells = [
                {"episode_index": episode, "frame_index": k}
                | {key: {"bytes": png(grey(episode, k, half))} for key, half in HALVES.items()}
                for episode, k in frames
            ]
            table(root / data.format(**names), cells)
    return root


def problem(clip):
    """Return why a recording cannot be read, or ""."""
    try:
        clip.read()
    except DataError as error:
        return str(error)
    return ""


def seen(file):
    return float(np.asarray(Image.open(file).convert("L"), float).mean())


@pytest.mark.parametrize("version", ["v2.1", "v3.0"])
@pytest.mark.parametrize("kind", ["video", "image"])
def test_each_layout_gives_the_pictures_of_the_same_moments(tmp_path, version, kind):
    if kind == "video":
        pytest.importorskip("av")
    root = lerobot(tmp_path / "press", version, kind)
    assert is_recording(root)
    count, skipped, *_ = write_pairs(clips_of(root), tmp_path / "out", frames=4)
    assert (count, skipped) == (12, [])
    found = read_pairs(tmp_path / "out")
    assert found.domains() == ("press",) and set(found.materials()) == {"press wood", "press steel"}
    assert len({pair.object for pair in found.pairs}) == 3
    for pair in found.pairs:
        episode, k = int(pair.object.split()[1]), int(pair.vis.name[:3])
        frame = int((k + 0.5) * LENGTH / 4 + 0.25)
        for half, file in (("vis", pair.vis), ("tac", pair.tac)):
            assert abs(seen(file) - grey(episode, frame, half)) < 1.5, (pair, half)


def test_splits_that_a_data_set_states_are_kept_and_a_single_one_tells_nothing(tmp_path):
    for name, splits, expected in (
        ("two", {"train": "0:2", "test": "2:3"}, ["train", "train", "test"]),
        ("one", {"train": "0:3"}, [""] * 3),
        ("odd", {"train": "all", "test": [2]}, [""] * 3),
    ):
        clips = clips_of(lerobot(tmp_path / name, "v3.0", splits=splits))
        assert [clip.split for clip in clips] == expected


def test_a_table_of_videos_gives_labels_parts_and_a_delay(tmp_path):
    film(tmp_path / "a.mp4", range(100, 140))
    film(tmp_path / "b.mp4", range(40, 80))
    rows = (
        "vis;tac;domain;material;object;split;start;end;tac_delay",
        "a.mp4;b.mp4;lab;Wood;oak;train;1;2;0,5",
        "a.mp4;b.mp4;lab;steel;;test;2.0;3;",
        "a.mp4;b.mp4;lab;steel;;test;3;2;",
        "a.mp4;b.mp4;lab;steel;;test;2;99;",
        "a.mp4;gone.mp4;lab;steel;;test;2;3;",
    )
    (tmp_path / "mine.csv").write_text("\n".join(rows))
    assert is_recording(tmp_path / "mine.csv")
    made = write_pairs(clips_of(tmp_path / "mine.csv"), tmp_path / "out", frames=1)
    order, late, gone = [one.why for one in made.skipped]
    assert (made.pairs, order) == (2, "Its end, 2 s, is not after its start.")
    assert "ends before" in late and "gone.mp4" in gone
    first, second = read_pairs(tmp_path / "out").pairs
    assert (first.material, first.object, first.split, second.split) == (
        "wood",
        "oak",
        "train",
        "test",
    )
    assert seen(first.vis) == pytest.approx(115, abs=1.5)
    assert seen(first.tac) == pytest.approx(60, abs=1.5)  # half a second later
    assert seen(second.tac) == pytest.approx(65, abs=1.5)


def test_a_folder_of_films_with_a_spreadsheet_of_parts_keeps_one_object_of_a_film(tmp_path, capsys):
    """Names without suffixes, clock times, units in headers, and numbered classes."""
    openpyxl = pytest.importorskip("openpyxl")
    film(tmp_path / "Gel 1.mp4", range(40, 80))
    book = openpyxl.Workbook()
    for row in (
        ["Touch video", "Start [s]", "End (s)", "Label"],
        ["gel 1", "0,5", "00:00:01", 0],
        ["gel 1", "0:02", "2.5", 0],
        ["gel 1", "3", "3.5", 1],
    ):
        book.active.append(row)
    book.save(tmp_path / "notes.xlsx")
    line = ["import", str(tmp_path), "--out", str(tmp_path / "out"), "--frames", "1"]
    assert main([*line, "--classes", "wood,felt"]) == 0
    found = sorted(
        (round(seen(p.tac)), p.material, p.object) for p in read_pairs(tmp_path / "out").pairs
    )
    assert [one[1:] for one in found] == [("wood", "gel 1 0")] * 2 + [("felt", "gel 1 1")]
    assert [one[0] for one in found] == pytest.approx([47, 62, 72], abs=1.5)
    assert "touches of 'touch video'" in capsys.readouterr().out


@pytest.mark.parametrize("ending", ["tif", "gif"])
def test_a_stack_of_pictures_is_a_film_of_one_object(tmp_path, ending, capsys):
    def saved(name, levels):
        first, *others = [Image.new("RGB", (48, 48), (10,) * 3) for _ in levels]
        for image, level in zip((first, *others), levels, strict=True):
            image.paste((level,) * 3, (0, 0, 24, 12))  # an eighth of it
        named = {"append_images": others, "save_all": True} if others else {}
        first.save(tmp_path / name, **named)

    saved(f"a.{ending}", [10, 10, 250, 10])
    saved("b.png", [90])
    (tmp_path / "t.csv").write_text(f"vis,tac,material\nb.png,a.{ending},wood\nb.png,b.png,felt\n")
    line = ["import", str(tmp_path / "t.csv"), "--out", str(tmp_path / "out")]
    assert main([*line, "--frames", "2", "--pick", "contact"]) == 0
    pairs = read_pairs(tmp_path / "out").pairs
    found = [(p.material, p.object, round(seen(p.tac))) for p in pairs if p.material == "wood"]
    assert found == [("wood", f"a.{ending}", 10), ("wood", f"a.{ending}", 40)]
    assert "some pictures are films" in capsys.readouterr().out


def test_labels_of_episodes_are_enough_for_the_command(tmp_path, capsys):
    pytest.importorskip("av")
    root = lerobot(tmp_path / "press", "v3.0", "video")
    (tmp_path / "labels.csv").write_text("episode,class,sensor\n0.0,wood,A\n2,glass,B\n9,felt,B\n")
    line = ["import", str(root), "--out", str(tmp_path / "out"), "--frames", "2"]
    assert main([*line, "--labels", str(tmp_path / "labels.csv")]) == 0
    said = capsys.readouterr().out
    assert "4 pairs of 2 recordings" in said
    assert "--labels does not list this episode." in said and "which is not there." in said
    assert read_pairs(tmp_path / "out").domains() == ("A", "B")


def test_a_film_of_too_many_pixels_is_refused_before_its_pictures_are_decoded(
    tmp_path, monkeypatch
):
    film(tmp_path / "a.mp4", range(0, 200, 20))
    monkeypatch.setattr("omnivat.data.images.MAX_PIXELS", 48 * 48 - 1)
    with pytest.raises(DataError, match="is 48 × 48 pixels, more than"):
        next(decoded(b"", file=str(tmp_path / "a.mp4"), name="a.mp4", waiting=[0.0]))


def test_nothing_is_written_unless_all_of_it_is(tmp_path, monkeypatch):
    film(tmp_path / "a.mp4", range(100, 120))
    (tmp_path / "videos.csv").write_text("vis,tac,material\na.mp4,a.mp4,wood\n")
    clips = clips_of(tmp_path)

    def stop(_):
        raise KeyboardInterrupt

    with pytest.raises(KeyboardInterrupt):
        write_pairs(clips, tmp_path / "out", on_step=stop)
    (tmp_path / "full").mkdir()
    (tmp_path / "full" / "mine.txt").write_text("mine")
    with pytest.raises(WriteError, match="new folder"):
        write_pairs(clips, tmp_path / "full")
    assert {path.name for path in tmp_path.iterdir()} == {"a.mp4", "videos.csv", "full"}
    monkeypatch.setitem(__import__("sys").modules, "av", None)
    with pytest.raises(MissingPackageError, match="pip install av"):
        write_pairs(clips, tmp_path / "out")


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"codebase_version": "v1.6"}, "v2 and v3 are read"),
        ({"fps": "x"}, "fps of .* is 'x'"),
        ({"data_path": "../../{episode_index}.parquet"}, "leads out of"),
        ({"data_path": "data/\0.parquet"}, "it may hold"),
        ({"data_path": "{nobody}"}, "is '{nobody}'; it may hold {video_key}, {episode_index}"),
        ({"data_path": "{episode_index:999999999d}"}, "9d}' cannot be read"),
        ({"data_path": "{episode_index.real.__class__}"}, "__}' cannot be read"),
        ({"features": []}, "No camera of .* is called tactile"),
        ({"features": {key: {"dtype": "image"} for key in (TAC, "a", "b")}}, "--vis"),
    ],
)
def test_an_odd_description_is_refused_in_a_sentence(tmp_path, change, words):
    root = lerobot(tmp_path / "press")
    (root / "meta" / "info.json").write_text(json.dumps(info("v2.1", "image") | change))
    with pytest.raises(DataError, match=words):
        write_pairs(clips_of(root), tmp_path / "out")


def test_one_damaged_episode_is_left_out_and_named(tmp_path):
    root = lerobot(tmp_path / "press")
    good = {"episode_index": 0, "length": LENGTH, "tasks": ["wood"]}
    odd = (
        '{"episode_index": 7',
        "[]",
        '{"episode_index": 1}',
        '{"episode_index": 2, "length": 1e999}',
        json.dumps({"episode_index": 1, "length": LENGTH, "tasks": ["\ud800"]}),
        '{"episode_index": 3, "length": 999999999}',
        json.dumps(good),
    )
    (root / "meta" / "episodes.jsonl").write_text("\n".join([json.dumps(good), *odd]))
    count, skipped, *_ = write_pairs(clips_of(root), tmp_path / "out", frames=2)
    assert count == 2 and len(skipped) == len(odd)
    whys = [LACKING] * 6 + ["It is listed twice."]
    assert [one.why for one in skipped] == whys


@pytest.mark.parametrize("place", [None, [1], "one", float("nan")])
def test_an_episode_whose_file_has_no_number_is_left_out_with_that_reason(tmp_path, place):
    root = lerobot(tmp_path / "press", "v3.0")
    file = root / "meta" / "episodes" / "chunk-000" / "file-000.parquet"
    table(file, [row | {"data/file_index": place} for row in parquet.read_table(file).to_pylist()])
    with pytest.raises(DataError, match="data/file_index is .* number from 0"):
        write_pairs(clips_of(root), tmp_path / "out")


def test_a_circle_of_links_is_an_episode_left_out(tmp_path):
    root = lerobot(tmp_path / "press")
    file = root / "data" / "chunk-000" / "episode_000001.parquet"
    file.unlink()
    file.symlink_to(file.name)
    _, skipped, *_ = write_pairs(clips_of(root), tmp_path / "out", frames=2)
    assert [one.what for one in skipped] == ["episode 1"]


@pytest.mark.parametrize("domain", ["#1 gel", "..", "+5N", "=1", "𠀀" * 90])
def test_pairs_of_a_domain_of_any_name_are_read_again(tmp_path, domain):
    write_pairs(clips_of(lerobot(tmp_path / "press"), domain=domain), tmp_path / "out", frames=2)
    assert {pair.domain for pair in read_pairs(tmp_path / "out").pairs} == {domain}


def test_a_stored_picture_is_bytes_and_never_the_name_of_a_file(tmp_path):
    root = lerobot(tmp_path / "press")
    (tmp_path / "secret.png").write_bytes(png(9))
    cell = {"bytes": str(tmp_path / "secret.png")}
    cells = [{"episode_index": 1, "frame_index": k, VIS: cell, TAC: cell} for k in range(LENGTH)]
    table(root / "data" / "chunk-000" / "episode_000001.parquet", cells)
    count, skipped, *_ = write_pairs(clips_of(root), tmp_path / "out", frames=2)
    assert (count, [one.what for one in skipped]) == (4, ["episode 1"])


@pytest.mark.parametrize(
    ("cameras", "photo", "touches"),
    [
        (["images.wrist", "tactile.left", "tactile.right"], "images.wrist", 2),
        (["images.contact_cam_scene", "images.digit0"], "images.contact_cam_scene", 1),
        (["images.stack_view", "images.obstacle_cam", "gelsightMini"], "--vis", 0),
        (["images.angel_top", "images.finger_left"], "--tac", 0),
        (["images.top"], "the photos alone with --vis", 0),
    ],
)
def test_cameras_are_recognised_by_whole_words_and_others_are_asked_for(
    tmp_path, cameras, photo, touches
):
    root = lerobot(tmp_path / "press")
    description = info("v2.1", "image", features={name: {"dtype": "image"} for name in cameras})
    (root / "meta" / "info.json").write_text(json.dumps(description))
    if not touches:
        with pytest.raises(DataError, match=photo):
            clips_of(root)
        return
    chosen = {clip.cameras for clip in clips_of(root)}
    assert len(chosen) == touches and all(one.startswith(f"photo {photo}, touch") for one in chosen)


def test_names_that_are_equal_as_folders_get_folders_of_their_own(tmp_path):
    film(tmp_path / "a.mp4", range(100, 120))
    long = "x" * 90
    rows = [f"a.mp4,a.mp4,wood,{long}{k}" for k in range(2)]
    (tmp_path / "videos.csv").write_text("vis,tac,material,domain\n" + "\n".join(rows))
    clips = [replace(clip, name="press") for clip in clips_of(tmp_path)]
    assert (
        write_pairs(clips, tmp_path / "out", frames=2)[0]
        == len(list((tmp_path / "out").rglob("*_tac.png")))
        == 4
    )


@pytest.mark.skipif(not hasattr(os, "mkfifo"), reason="no pipes")
def test_a_pipe_is_refused_wherever_a_file_is_named(tmp_path, capsys):
    film(tmp_path / "a.mp4", range(100, 120))
    for name in ("v.mp4", "in.csv"):
        os.mkfifo(tmp_path / name)
    (tmp_path / "videos.csv").write_text("vis,tac,material\nv.mp4,v.mp4,wood\na.mp4,a.mp4,wood\n")
    count, skipped, *_ = write_pairs(clips_of(tmp_path), tmp_path / "out", frames=2)
    assert count == 2 and "pipe or device" in skipped[0].why
    assert main(["try", str(tmp_path / "in.csv"), "--out", str(tmp_path / "set")]) == 1
    assert "pipe or device" in capsys.readouterr().err


def test_unknown_cameras_and_settings_are_refused_in_a_sentence(tmp_path):
    root = lerobot(tmp_path / "press")
    with pytest.raises(DataError, match="omnivat import"):
        read_pairs(root)
    with pytest.raises(DataError, match="has no camera 'x'"):
        clips_of(root, vis="x")
    with pytest.raises(DataError, match="too few pictures in that time: 20 of 21"):
        write_pairs(clips_of(root), tmp_path / "out", frames=LENGTH + 1)
    rows = ("a.mp4,wood,soon", "a.mp4,wood,inf", "a.mp4,wood,1e300", ",wood,1")
    films = tmp_path / "films"
    films.mkdir()
    (films / "videos.csv").write_text("\n".join(["tac,material,start", *rows]))
    problems = [*map(problem, clips_of(films))]
    assert ["start is" in one for one in problems] == [True, True, True, False]
    assert "names no video" in problems[-1]
    with pytest.raises(SettingsError, match="for LeRobot"):
        clips_of(films, tac=["x", "y"])
