"""Recordings of tactile packages: `.hapt` folders by haptix, `.touch` files by their layout."""

import json
import struct

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.readers import read_pairs
from omnivat.data.recordings import clips_of, is_recording, write_pairs
from tests.unit.data.test_tracks import shown

COUNT = 10


def greys(first):
    return np.stack([np.full((16, 24, 3), first + k, np.uint8) for k in range(COUNT)])


def hapt(folder, frames, kind="DIGIT_v2", serial="D20804", **labels):
    core = pytest.importorskip("haptix.core")
    io = pytest.importorskip("haptix.io")
    raw = core.RawData(
        array=frames,
        checksum=core.RawData.compute_checksum(frames),
        dtype=str(frames.dtype),
        shape=frames.shape,
    )
    sensor = core.SensorMeta(type=kind, serial=serial)
    press = core.InteractionMeta(type="pressing")
    data = core.HaptData(raw, sensor, "imaging", 30.0, press, core.Labels(**labels))
    return io.save(data, folder)


def touch(file, sensors, payload=(), cut=0):
    """Write a .touch file: `sensors` has frames by name; each has a stream of its own, too."""
    h5py = pytest.importorskip("h5py")

    def packed(text):
        return struct.pack("<I", len(text)) + text

    def event(stream, time, body):
        return packed(struct.pack("<32sd", stream, time) + body)

    config = {
        "group_name": "hand",
        "sensors": [
            {"sensor_name": name, "sensor_type": "Digit", "serial_id": f"D{k}"}
            for k, name in enumerate(sensors)
        ],
        "payload": [{"type": "text_input", "label": name, "default": v} for name, v in payload],
    }
    chunks = []
    for part in (slice(0, 6), slice(6, None)):
        blob = struct.pack("<I", len(sensors))
        for name, frames in sensors.items():
            times = [0.4 + k / 30 for k in range(COUNT)][part]
            shots = [
                event(b"camera", time, struct.pack("<III", *one.shape) + one.tobytes())
                for time, one in zip(times, frames[part], strict=True)
            ]
            noise = [event(b"audio", time, b"abc") for time in times]
            blob += packed(name.encode()) + struct.pack("<I", 2)
            for stream, events in ((b"audio", noise), (b"camera", shots)):
                blob += packed(stream) + struct.pack("<I", len(events)) + b"".join(events)
        chunks.append(blob[: len(blob) - cut])
    with h5py.File(file, "w") as handle:
        handle.create_dataset("config", data=json.dumps(config), dtype=h5py.string_dtype())
        stored = handle.create_dataset("sensor_chunks", (2,), h5py.vlen_dtype(np.uint8))
        for k, chunk in enumerate(chunks):
            stored[k] = np.frombuffer(chunk, np.uint8)
    return file


def test_a_folder_of_hapt_recordings_keeps_sensors_objects_and_materials(tmp_path, capsys):
    hapt(tmp_path / "in" / "a.hapt", greys(50), material="Wood", object_name="block")
    hapt(tmp_path / "in" / "b.hapt", greys(150), serial="D20805", material="steel")
    hapt(tmp_path / "in" / "c.hapt", greys(9), material="steel")
    (tmp_path / "in" / "c.hapt" / "raw" / "checksum.sha256").write_text("0" * 64)
    out = tmp_path / "out"
    assert main(["import", str(tmp_path / "in"), "--out", str(out), "--frames", "2"]) == 0
    found = read_pairs(out)
    assert found.modalities() == ("tac",) and found.domains() == (
        "DIGIT_v2 D20804",
        "DIGIT_v2 D20805",
    )
    assert [(p.material, p.object) for p in found.pairs[::2]] == [("wood", "block"), ("steel", "b")]
    assert shown(out, "tac") == [52, 57, 152, 157]
    assert "does not have its checksum" in capsys.readouterr().out


def test_recordings_in_folders_have_the_labels_of_a_table_beside_them(tmp_path):
    for name in ("wood/a", "steel/a"):
        core = tmp_path / "in" / f"{name}.hapt"
        hapt(core, greys(50))
        (core / "labels.json").unlink()
    touch(tmp_path / "in" / "b.touch", {"thumb": greys(20)})
    table = "file;material;object\nwood/a.hapt;oak;plank\na.hapt;iron;pan\nb;felt;hat\n"
    (tmp_path / "in" / "press.csv").write_text(table)
    found = {(clip.material, clip.object) for clip in clips_of(tmp_path / "in")}
    assert found == {("oak", "plank"), ("iron", "pan"), ("felt", "hat")}
    (tmp_path / "in" / "press.csv").write_text("touch,material\nwood/a.hapt,wood\n")
    assert [clip.material for clip in clips_of(tmp_path / "in")] == ["wood"]


def test_a_touch_file_gives_each_camera_by_its_times_and_the_labels_of_its_payload(tmp_path):
    file = touch(
        tmp_path / "press.touch",
        {"thumb": greys(20), "index": greys(120)},
        [("Difficulty", 8), ("Grasped object", "Apple"), ("Material", "")],
    )
    assert is_recording(file)
    made = write_pairs(clips_of(tmp_path), tmp_path / "out", frames=2)
    assert made[:2] == (4, [])
    found = read_pairs(tmp_path / "out")
    assert [(p.domain, p.material, p.object) for p in found.pairs[::2]] == [
        ("Digit D0", "apple", "Apple"),
        ("Digit D1", "apple", "Apple"),
    ]
    assert shown(tmp_path / "out", "tac") == [22, 27, 122, 127]


def test_a_table_may_name_a_recording_of_one_sensor_as_the_touch_of_a_film(tmp_path):
    touch(tmp_path / "a.touch", {"thumb": greys(20)})
    (tmp_path / "press.csv").write_text("touch,material,start\na.touch,wood,0.1\n")
    assert write_pairs(clips_of(tmp_path / "press.csv"), tmp_path / "out", frames=1).pairs == 1
    assert shown(tmp_path / "out", "tac") == [26]
    (tmp_path / "labels.csv").write_text("file;material;split\na.touch;glass;test\n")
    (clip,) = clips_of(tmp_path / "a.touch", labels=tmp_path / "labels.csv")
    assert (clip.material, clip.split, clip.object) == ("glass", "test", "a")


@pytest.mark.parametrize("cut", [1, 200, 4000])
def test_a_damaged_recording_is_left_out_in_a_sentence(tmp_path, cut):
    touch(tmp_path / "a.touch", {"thumb": greys(20)}, cut=cut)
    touch(tmp_path / "b.touch", {"thumb": greys(20)})
    (tmp_path / "c.touch").write_bytes(b"no HDF5")
    (tmp_path / "d.hapt").mkdir()
    made = write_pairs(clips_of(tmp_path), tmp_path / "out", frames=2)
    assert made.pairs == 2
    whys = {one.what.split()[0]: one.why for one in made.skipped}
    assert "a.touch' is damaged" in whys["a"] and "cannot be read" in whys["c"]
    assert "manifest.json' cannot be read" in whys["d"]
