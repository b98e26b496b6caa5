"""Contact signals: BioTac vibrations and folders of CSV or WAV become windows with names."""

import wave

import numpy as np
import pytest

from omnivat.cli import main
from omnivat.data.readers.signals import DYNAMIC, read_signals, signal_embeddings
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError, SettingsError

SAMPLES = np.random.default_rng(0).integers(-900, 900, (40, 22))


def biotac(root, name, rows=SAMPLES):
    """Write a record of the sensor: 22 samples a row between other columns."""
    lines = [",".join(("timestamp", "pdc", *DYNAMIC, "ele1"))]
    lines += [f"{k / 100},7,{','.join(map(str, row))},5," for k, row in enumerate(rows)]
    file = root / name
    file.parent.mkdir(parents=True, exist_ok=True)
    file.write_text("\n".join(lines) + "\n")


def sound(file, values, width=2, channels=1):
    file.parent.mkdir(parents=True, exist_ok=True)
    with wave.open(str(file), "wb") as made:
        made.setparams((channels, width, 2000, 0, "NONE", ""))
        whole = np.repeat((values * (2 ** (8 * width - 1) - 1)).astype(np.int64), channels)
        whole[1::channels] = 0 if channels > 1 else whole[1::channels]
        whole = whole + (128 if width == 1 else 0)
        made.writeframes(b"".join(int(v).to_bytes(width, "little", signed=width > 1) for v in whole))


def test_rows_of_a_biotac_record_are_laid_end_to_end(tmp_path):
    biotac(tmp_path, "raw_data/mat3/mat3_7_bio.csv")
    (recording,) = read_signals(tmp_path).recordings
    assert (recording.domain, recording.material) == ("BioTac", "mat3")
    np.testing.assert_array_equal(recording.signal, SAMPLES.reshape(-1))


def test_a_record_without_the_samples_is_left_out_with_the_reason(tmp_path):
    biotac(tmp_path, "mat1/mat1_1_bio.csv")
    (tmp_path / "mat1/mat1_2_bio.csv").write_text("timestamp,pdc\n0,1\n")
    (tmp_path / "mat1/mat1_3_bio.csv").write_bytes(b"\xff\x00")
    found = read_signals(tmp_path)
    assert len(found.recordings) == 1
    assert "lacks the column pac1" in found.skipped[0].why and len(found.skipped) == 2


@pytest.mark.parametrize(("width", "channels"), [(1, 1), (2, 1), (3, 2), (4, 1)])
def test_the_first_channel_of_a_wav_of_any_depth_is_read(tmp_path, width, channels):
    values = np.sin(np.arange(200) / 7)
    sound(tmp_path / "lab/felt/a.wav", values, width, channels)
    (recording,) = read_signals(tmp_path).recordings
    np.testing.assert_allclose(recording.signal, values, atol=2 ** (2 - 8 * width) + 1e-7)


@pytest.mark.parametrize("header", ["", "time,force\n"])
def test_the_last_column_of_a_csv_is_the_signal(tmp_path, header):
    file = tmp_path / "lab/Wood/a.csv"
    file.parent.mkdir(parents=True)
    file.write_text(header + "".join(f"{k},{k * k}\n" for k in range(70)))
    (recording,) = read_signals(tmp_path).recordings
    assert recording.material == "wood" and recording.signal[9] == 81.0


def a_set(root, recordings=5):
    for material in (1, 2):
        for number in range(recordings):
            rows = np.random.default_rng([material, number]).integers(-9, 9, (40, 22))
            biotac(root, f"mat{material}/mat{material}_{number}_bio.csv", rows)


def test_windows_are_centred_scaled_and_split_by_recording(tmp_path):
    a_set(tmp_path)
    made, skipped = signal_embeddings(tmp_path, most=4)
    assert made.header.encoder == "strip" and made.vis.shape == (40, 64) and not skipped
    np.testing.assert_allclose(np.abs(made.tac).max(1), 1.0)
    whole = next(one for one in read_signals(tmp_path).recordings if one.name == made.rows["object"][1])
    start = int(made.rows["tac"][1].split("#")[1])
    cut = whole.signal[start : start + 64]
    cut = cut - cut.mean()
    np.testing.assert_allclose(made.tac[1], cut / np.abs(cut).max(), rtol=1e-5)
    parts = dict(zip(made.rows["object"], made.rows["split"], strict=True))
    assert sorted(parts.values()) == ["test"] * 4 + ["train"] * 6
    assert len(set(zip(made.rows["object"], made.rows["split"], strict=True))) == 10


def test_constant_windows_and_short_recordings_give_no_rows(tmp_path):
    a_set(tmp_path, 2)
    biotac(tmp_path, "mat1/mat1_8_bio.csv", np.ones((40, 22), int))
    biotac(tmp_path, "mat1/mat1_9_bio.csv", SAMPLES[:2])
    names = signal_embeddings(tmp_path)[0].rows["object"]
    assert not {name for name in names if "_8_" in name or "_9_" in name}


def test_bad_requests_end_in_one_sentence(tmp_path):
    with pytest.raises(DataError, match="has no recording"):
        read_signals(tmp_path)
    with pytest.raises(DataError, match="not a folder"):
        read_signals(tmp_path / "absent")
    biotac(tmp_path, "mat1/mat1_1_bio.csv")
    with pytest.raises(DataError, match="in 1 classes; two or more are needed"):
        signal_embeddings(tmp_path)
    with pytest.raises(SettingsError, match="window is 4"):
        signal_embeddings(tmp_path, window=4)


def test_a_folder_of_arrays_has_a_recording_a_row(tmp_path):
    signal = np.random.default_rng(0).integers(-9, 9, (6, 200)).astype(np.int16)
    np.savez(tmp_path / "lab.npz", signal=signal, material=np.array([1, 2] * 3))
    np.savez(tmp_path / "named.npz", signal=signal, material=["Wood"] * 6, domain=["a", "b"] * 3)
    found = read_signals(tmp_path).recordings
    assert [(one.domain, one.material) for one in found[:2]] == [("lab", "1"), ("lab", "2")]
    assert {(one.domain, one.material) for one in found[6:]} == {("a", "wood"), ("b", "wood")}
    np.testing.assert_array_equal(found[3].signal, signal[3])


@pytest.mark.parametrize(
    ("arrays", "why"),
    [
        ({"signal": np.ones((2, 9))}, "lacks the array 'material'"),
        ({"signal": np.ones((2, 9)), "material": [1]}, "no name for each of 2"),
        ({"signal": np.full((2, 9), np.nan), "material": [1, 2]}, "no table of finite numbers"),
        ({"signal": np.ones(9), "material": [1] * 9}, "no table of finite numbers"),
    ],
)
def test_arrays_that_do_not_fit_are_left_out_with_the_reason(tmp_path, arrays, why):
    np.savez(tmp_path / "bad.npz", **arrays)
    (tmp_path / "cut.npz").write_bytes(b"PK")
    with pytest.raises(DataError, match=why):
        read_signals(tmp_path)


def test_the_command_line_writes_a_set_of_signals(tmp_path, capsys):
    a_set(tmp_path / "data")
    (tmp_path / "data/mat1/mat1_99_bio.csv").write_text("pdc\n1\n")
    out = tmp_path / "set.safetensors"
    command = ["import", str(tmp_path / "data"), "--out", str(out), "--window", "128"]
    assert main([*command, "--encoder", "clip"]) == 1
    assert "pass --encoder strip" in capsys.readouterr().err
    assert main([*command, "--encoder", "strip"]) == 0
    assert "left out: mat1/mat1_99_bio.csv" in capsys.readouterr().out
    assert load_embeddings(out).width == 128
