"""`omnivat reproduce` from made trees of the four layouts and a small random CLIP to its tables."""

import json

import pytest

from omnivat.data.paper_sets import find_paper_sets, read_paper_sets
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError


@pytest.fixture
def root(tmp_path, paint, monkeypatch):
    """A folder with each data set, small, at other depths and under other names."""
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "data"
    touch_and_go(folder / "downloads" / "TAG", paint)
    objectfolder_real(folder / "OF_Real", paint)
    objectfolder_2(folder / "DATA_new", paint)
    tacquad(folder / "tq" / "tacquad", paint)
    return folder


def touch_and_go(root, paint):
    lines = {"train": [], "test": []}
    for number, (split, label) in enumerate(
        (split, label) for split in lines for label in (3, 4, 1) for _ in range(2)
    ):
        for side in ("video_frame", "gelsight_frame"):
            paint(root / "dataset" / "20220101_000000" / side / f"{number:010d}.jpg")
        lines[split].append(f"20220101_000000/{number:010d}.jpg,{label}\n")
    for split, rows in lines.items():
        (root / f"{split}.txt").write_text("".join(rows))


def objectfolder_real(root, paint):
    names = ("Wood", "Wood", "Steel", "Steel", "Plastic", "Plastic")
    for thing in range(1, 7):
        recording = root / str(thing) / "tactile_data" / "0" / "0"
        for camera in ("gelsight", "in_hand"):
            paint(recording / camera / "0.png")
    rows = "".join(f"{i},{name}\n" for i, name in enumerate(names, start=1))
    (root / "materials.csv").write_text("object,material\n" + rows)


def objectfolder_2(root, paint):
    order = ("Ceramic", "Glass", "Wood", "Plastic", "Iron", "Polycarbonate", "Steel")
    objects = {}
    for start in (1, 101):  # A, then B
        for k in range(21):
            objects[start + k] = ("Wood", "Steel", "Plastic")[k % 3]
    for thing in objects:
        for side in ("vision", "touch"):
            paint(root / side / str(thing) / "0.png")
    labels = {str(thing): order.index(name) for thing, name in objects.items()}
    (root / "label.json").write_text(json.dumps(labels))
    rows = [f"{thing},name,1.0,{name},http" for thing, name in objects.items()]
    (root / "objects.csv").write_text("\n".join(rows))


def tacquad(root, paint):
    for part, items in (
        ("indoor", ("wood_block", "steel_cup")),
        ("outdoor", ("wood_bench", "steel_rail")),
    ):
        for name in items:
            for sensor in ("gelsight", "digit", "duragel"):
                for number in range(3):
                    paint(root / f"data_{part}" / name / sensor / f"{number}.png")
                    paint(root / f"data_{part}" / name / f"img_{sensor}" / f"{number}.png")
        rows = "".join(f"{name},0,2,0,2,0,2\n" for name in items)
        (root / f"contact_{part}.csv").write_text(rows)


def test_the_four_sets_are_found_where_they_lie_and_read_as_one(root):
    found = read_paper_sets(root)
    assert list(found.places) == ["touch_and_go", "objectfolder_real", "objectfolder_2", "tacquad"]
    assert found.missing == ()
    domains = {pair.domain for pair in found.pairs.pairs}
    assert domains >= {"TAG", "OF Real", "OF 2.0 A", "OF 2.0 B", "TQ-DIGIT", "TQ-GelMini"}
    assert not found.pairs.simulated  # the rendered touch of OF 2.0 is the paper's own data


def test_what_is_not_there_is_named(root, tmp_path):
    only = tmp_path / "data" / "OF_Real"
    assert read_paper_sets(only).missing == ("Touch-and-Go", "ObjectFolder 2.0", "TacQuad")
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match="None of Touch-and-Go"):
        find_paper_sets(tmp_path / "empty")
    with pytest.raises(DataError, match="no folder"):
        find_paper_sets(tmp_path / "nowhere")


def test_a_set_that_is_there_twice_is_refused_with_both_places(root, paint):
    objectfolder_real(root / "copy", paint)
    with pytest.raises(DataError, match=r"ObjectFolder Real is there twice.*OF_Real.*copy"):
        find_paper_sets(root)


@pytest.mark.slow
def test_one_command_writes_the_papers_tables_and_goes_on_from_where_it_stopped(
    clips, root, tmp_path, run, monkeypatch
):
    monkeypatch.setattr(clips, "LONGEST", 32)  # prompts are spelt by letters
    place = clips.write("OpenAI state dict", tmp_path / "clip", clips.small_model())
    out = tmp_path / "out"
    command = ["reproduce", "--data", str(root), "--weights", str(place), "--out", str(out)]
    command += ["--seeds", "0", "--styles", "2", "--steps", "1", "--only", "expansion"]
    command += ["--methods", "omnivat,nearest_mean,zero_shot", "--set", "width=8"]
    command += ["--set", "epochs=1", "--workers", "1"]
    said = run(*command).out
    assert "$ omnivat prompts --encoder clip" in said and "$ omnivat protocol" in said
    pairs = load_embeddings(out / "embeddings.safetensors")
    assert pairs.header.encoder == "clip" and pairs.header.text_hash
    assert not pairs.header.simulated
    report = (out / "protocol" / "report.md").read_text()
    assert "OmniVaT" in report and "CLIP zero-shot" in report and "printed: " in report
    margins, cost = (out / "margins.md").read_text(), (out / "cost.md").read_text()
    assert "printed: OmniVaT" in margins and "0.168" in margins and "not comparable" in margins
    assert "printed: LDC" in cost and "172.5" in cost
    assert list((out / "ablations").glob("*.md"))
    runs = (out / "protocol" / "runs.jsonl").read_text()
    again = run(*command).out
    assert again.count("; kept") == 2 and "0 runs done" in again
    assert (out / "protocol" / "runs.jsonl").read_text() == runs
