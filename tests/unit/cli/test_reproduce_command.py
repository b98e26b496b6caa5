"""`omnivat reproduce` from made trees of the four layouts and a small random CLIP to its tables."""

import json

import pytest

from omnivat.data.paper_sets import find_paper_sets, read_paper_sets
from omnivat.data.store import load_embeddings
from omnivat.encoders.lang.bank import load_bank
from omnivat.kit.errors import DataError


@pytest.fixture
def root(tmp_path, paint, monkeypatch):
    """A folder with two data sets, small, at other depths and under other names."""
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    folder = tmp_path / "data"
    touch_and_go(folder / "downloads" / "TAG", paint)
    objectfolder_2(folder / "DATA_new", paint)
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


def objectfolder_2(root, paint):
    labels, names = {}, {2: "Wood", 6: "Steel", 3: "Plastic"}  # by the release's numbers
    for k, (start, label) in enumerate((s, label) for s in (1, 101) for label in [*names] * 3):
        labels[str(start + k)] = label
        for side in ("vision", "touch"):
            paint(root / side / str(start + k) / "0.png")
    (root / "label.json").write_text(json.dumps(labels))
    rows = [f"{thing},name,1.0,{names[label]},http" for thing, label in labels.items()]
    (root / "objects.csv").write_text("\n".join(rows))


def test_the_papers_sets_are_found_where_they_lie_and_read_as_one(root, tmp_path):
    found = read_paper_sets(root)
    assert list(found.places) == ["touch_and_go", "objectfolder_2"]
    assert found.missing == ("ObjectFolder Real", "TacQuad")
    assert {pair.domain for pair in found.pairs.pairs} == {"TAG", "OF 2.0 A", "OF 2.0 B"}
    assert not found.pairs.simulated  # the rendered touch of OF 2.0 is the paper's own data
    (tmp_path / "empty").mkdir()
    with pytest.raises(DataError, match="None of Touch-and-Go"):
        find_paper_sets(tmp_path / "empty")
    with pytest.raises(DataError, match="There is no folder '.*nowhere'"):
        find_paper_sets(tmp_path / "nowhere")


def test_a_set_that_is_there_twice_is_refused_with_both_places(root, paint):
    touch_and_go(root / "copy", paint)
    with pytest.raises(DataError, match=r"Touch-and-Go is there twice.*TAG.*copy|copy.*TAG"):
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
    bank = load_bank(out / "lang.safetensors")
    assert bank.origin.startswith("PromptStyler stage 1, 2 styles of 1 steps, seed 0, through clip")
    assert bank.text_hash == pairs.header.text_hash
    report = (out / "protocol" / "report.md").read_text()
    assert "OmniVaT" in report and "CLIP zero-shot" in report and "printed: " in report
    margins, cost = (out / "margins.md").read_text(), (out / "cost.md").read_text()
    assert "printed: OmniVaT" in margins and "0.258" in margins and "not comparable" in margins
    assert "printed: LDC" in cost and "172.5" in cost
    assert list((out / "ablations").glob("*.md"))
    runs = (out / "protocol" / "runs.jsonl").read_text()
    again = run(*command).out
    assert again.count("; kept") == 2 and "0 runs done" in again
    assert (out / "protocol" / "runs.jsonl").read_text() == runs
