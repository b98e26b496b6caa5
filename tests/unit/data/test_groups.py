"""Groups of HDF5, as robomimic, ALOHA and laboratories write them, and files of one recording."""

import json

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.readers import read_pairs

h5py = pytest.importorskip("h5py")
SIZE = (16, 24, 3)


def film(grey, count=6, size=SIZE):
    """Return a stack of grey pictures, which grow brighter by 1."""
    return np.stack([np.full(size, grey + k, np.uint8) for k in range(count)])


def still(grey, size=SIZE):
    return film(grey, 1, size)[0]


def written(file, arrays, **attributes):
    """Write arrays by their names, and attributes "GROUP@NAME"."""
    with h5py.File(file, "a") as handle:
        for name, array in arrays.items():
            handle[name] = array
        for place, value in attributes.items():
            group, _, name = place.rpartition("@")
            handle[group or "/"].attrs[name] = value
    return file


def imported(source, out, *more):
    """Return each pair's domain, class, object, split and greys, in order of these."""
    assert main(["import", str(source), "--out", str(out), *map(str, more)]) == 0
    return sorted(
        (p.domain, p.material, p.object, p.split, *(grey(p, half) for half in ("vis", "tac")))
        for p in read_pairs(out).pairs
    )


def grey(pair, half):
    if pair.alone not in ("", half):
        return None
    return int(np.asarray(Image.open(getattr(pair, half)).convert("L")).mean().round())


def episodes(tmp_path, count=3, **attributes):
    arrays = {}
    for k in range(count):
        base = f"data/demo_{k}"
        arrays |= {
            f"{base}/obs/agentview_image": film(40 * k),
            f"{base}/obs/tactile_image": film(40 * k + 20),
            f"{base}/obs/object": np.ones((6, 14)),
            f"{base}/next_obs/agentview_image": film(200),
            f"{base}/actions": np.zeros((6, 7)),
        }
    return written(tmp_path / "low_dim.h5", arrays, **attributes)


def test_episodes_of_robomimic_are_objects_with_the_labels_and_splits_of_their_file(tmp_path):
    file = episodes(tmp_path, **{f"data/demo_{k}@label": w for k, w in enumerate("aba")})
    written(file, {"mask/train": [b"demo_0", b"demo_1"], "mask/valid": [b"demo_2"]})
    assert imported(file, tmp_path / "out", "--frames", 2, "--domain", "D") == sorted(
        ("D", "aba"[k], f"demo_{k}", "val" if k == 2 else "train", 40 * k + at, 40 * k + 20 + at)
        for k in range(3)
        for at in (1, 4)
    )


def test_episodes_without_a_class_name_options_that_give_it(tmp_path, capsys):
    file = episodes(tmp_path, **{"data/demo_1@kind": "felt", "data@kind": "wood"})
    assert main(["import", str(file), "--out", str(tmp_path / "none")]) == 1
    told = capsys.readouterr().err
    assert "demo_0, demo_1, demo_2, and no class of them" in told and "there are kind" in told
    table = tmp_path / "t.csv"
    rows = "episode,material,object,note\ndemo_0,wood,mug,\xfc\n1,felt,mug\ndata/demo_2,wood,\n"
    table.write_bytes(rows.encode("cp1252"))
    for option, kinds, things in (
        (["--labels", table], ["wood", "felt", "wood"], ["mug", "mug", "demo_2"]),
        (["--column", "material=kind"], ["wood", "felt", "wood"], ["demo_0", "demo_1", "demo_2"]),
        (["--column", "material="], ["unlabelled"] * 3, ["demo_0", "demo_1", "demo_2"]),
    ):
        out = tmp_path / kinds[1] / things[0]
        found = imported(file, out, "--frames", 1, *option)
        by_grey = sorted(found, key=lambda one: one[4])
        assert [one[1:3] for one in by_grey] == [*zip(kinds, things, strict=True)]
        noted = "t.csv: read as Windows-1252" in capsys.readouterr().out
        assert noted is (option[0] == "--labels")


@pytest.mark.parametrize("ending", [".hdf5", ".npz"])
def test_a_folder_of_files_has_a_recording_in_each(tmp_path, ending):
    """As ALOHA writes them: episode_0.hdf5 with observations/images/<camera>."""
    folder = tmp_path / "press"
    folder.mkdir()
    for k in range(12):
        arrays = {
            "observations/images/cam_high": film(10 * k, 4),
            "observations/images/gelsight": film(10 * k + 100, 8),  # twice the rate
            "observations/qpos": np.zeros((4, 14)),
            "label": "wood" if k % 2 else "felt",
        }
        file = folder / f"episode_{k}{ending}"
        np.savez(file, **arrays) if ending == ".npz" else written(file, arrays)
    assert imported(folder, tmp_path / "out", "--frames", 2) == sorted(
        ("press", "wood" if k % 2 else "felt", f"episode_{k}", "", 10 * k + v, 10 * k + 100 + t)
        for k in range(12)
        for v, t in ((1, 2), (3, 6))
    )


TWO = ["felt . . 10 110", "wood . . 0 100"]
ALONE = ["felt . . None 10", "wood . . None 0", "wood . . None 1"]


@pytest.mark.parametrize(
    ("arrays", "more", "expected"),
    [  # NAME=GREY is a picture, NAME*2=GREY two
        ("wood/vis_0=0 wood/tac_0=100 felt/vis_0=10 felt/tac_0=110", [], TWO),
        ("wood/rgb*1=0 wood/touch*1=100 felt/rgb*1=10 felt/touch*1=110", [], TWO),
        ("vis/wood*1=0 tac/wood*1=100 vis/felt*1=10 tac/felt*1=110", [], TWO),
        ("rgb/wood/img_0=0 tac/wood/gel_0=100 rgb/felt/img_0=10 tac/felt/gel_0=110", [], TWO),
        ("wood/img_0=0 wood/img_1=1 felt/img_0=10", ["--tac", "img"], ALONE),
        ("wood*2=0 felt*1=10", ["--tac", "pictures"], ALONE),
        (
            "wood/0_rgb=0 wood/0_gelsight=100 felt/a1/rgb=10 felt/a1/gelsight=110",
            [],
            ["felt felt/a1 . 10 110", "wood . . 0 100"],
        ),
        (
            "train/wood/rgb*1=0 train/wood/tac*1=100 test/wood/rgb*1=10 test/wood/tac*1=110"
            " test/felt/rgb*1=20 test/felt/tac*1=120",
            [],
            ["felt . test 20 120", "wood . test 10 110", "wood . train 0 100"],
        ),
        (
            "wood/mug/rgb*1=0 wood/mug/tac*1=100 wood/fork/rgb*1=5 wood/fork/tac*1=105"
            " felt/hat/rgb*1=10 felt/hat/tac*1=110",
            [],
            ["felt felt/hat . 10 110", "wood wood/fork . 5 105", "wood wood/mug . 0 100"],
        ),
        (
            "new/wood/rgb*1=0 new/wood/tac*1=100 new/felt/rgb*1=5 new/felt/tac*1=105"
            " old/wood/rgb*1=10 old/wood/tac*1=110",
            [],
            ["new: felt . . 5 105", "new: wood . . 0 100", "old: wood . . 10 110"],
        ),
        (
            "mug_1/rgb*2=0 mug_1/tac*2=100 fork_1/rgb*2=10 fork_1/tac*2=110",
            ["--frames", 1],
            ["fork fork_1 . 11 111", "mug mug_1 . 1 101"],
        ),
        (
            "touch_0/rgb*2=0 touch_0/tac*2=100 touch_1/rgb*2=10 touch_1/tac*2=110 labels=[1,0]",
            ["--frames", 1, "--classes", "felt,wood"],
            ["felt touch_1 . 11 111", "wood touch_0 . 1 101"],
        ),
        (
            "rgb_0*1=0 rgb_1*1=1 rgb_2*1=2 rgb_3*1=3 rgb_4*1=4 tac_0*1=100 tac_1*1=101 tac_2*1=102"
            ' tac_3*1=103 tac_4*1=104 labels=["a","b","a","b","c"]',
            [],
            ["a 0 . 0 100", "a 2 . 2 102", "b 1 . 1 101", "b 3 . 3 103", "c 4 . 4 104"],
        ),
        (
            '0/left_tactile=100 0/right_tactile=120 0/wrist=0 0/label="wood" 0/item="mug"',
            [],
            ["left_tactile: wood mug . 0 100", "right_tactile: wood mug . 0 120"],
        ),
    ],
)
def test_groups_are_classes_objects_domains_and_splits_by_their_names(
    tmp_path, arrays, more, expected
):
    folder = tmp_path / "press"
    folder.mkdir()
    content = {}
    for one in arrays.split():
        name, _, value = one.partition("=")
        name, _, count = name.partition("*")
        given = json.loads(value)
        grey = isinstance(given, int)
        content[name] = film(given, int(count)) if count else still(given) if grey else given
    found = imported(written(folder / "a.h5", content), tmp_path / "out", *more)
    told = [f"{d}: {m} {o or '.'} {s or '.'} {v} {t}" for d, m, o, s, v, t in found]
    assert [one.removeprefix("press: ") for one in told] == expected


def test_commands_for_pairs_name_the_import_of_a_file_with_pictures(tmp_path, capsys):
    file = written(tmp_path / "a.h5", {f"{c}/{h}": film(0) for c in "ab" for h in ("rgb", "tac")})
    assert main(["try", str(file), "--out", str(tmp_path / "out.safetensors")]) == 1
    assert f"import {file} --out PAIRS`" in capsys.readouterr().err


def test_what_groups_do_not_pair_is_refused_or_left_out_with_its_reason(tmp_path, capsys):
    file = written(tmp_path / "a.h5", {"wood/rgb": film(0, 3), "wood/tac": film(9, 4)})
    assert main(["import", str(file), "--out", str(tmp_path / "none")]) == 1
    assert "3 pictures in wood/rgb and 4 pictures in wood/tac" in capsys.readouterr().err
    file = episodes(tmp_path, 2, **{"data@label": "felt"})
    with h5py.File(file, "a") as handle:
        del handle["data/demo_1/obs/tactile_image"]
    assert len(imported(file, tmp_path / "out")) == 5
    assert "It has no pictures of 'obs/tactile_image'" in capsys.readouterr().out
