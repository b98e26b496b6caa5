"""Methods that learn inside CLIP, from pairs on disk through `embed` and `protocol` to a record."""

import json
import shutil
from dataclasses import replace

import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.store import load_embeddings
from omnivat.encoders.embed import embed_pairs
from omnivat.kit.errors import DataError
from omnivat.study.baselines import ldc, mmrl
from omnivat.study.protocol.images import live_of, require_own_images

METHODS = "mmrl,ldc,nearest_mean"


@pytest.fixture
def folder(clips, tmp_path, monkeypatch, paint):
    """Two domains of two materials, a small CLIP, and both methods cut to one epoch."""
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    for module in (mmrl, ldc):
        monkeypatch.setattr(module, "HOW", replace(module.HOW, epochs=1))
    monkeypatch.setattr(ldc, "LEAST", 1)
    lines = ["vis,tac,domain,material,object"]
    for domain in ("lab", "field"):
        for material in ("wood", "steel"):
            for number in range(4):
                names = [f"{domain}/{material}/{number}_{side}.png" for side in ("vis", "tac")]
                for name in names:
                    paint(tmp_path / "pairs" / name)
                lines.append(",".join([*names, domain, material, f"{domain}{material}{number}"]))
    (tmp_path / "pairs" / "pairs.csv").write_text("\n".join(lines) + "\n")
    weights = clips.write("OpenAI state dict", tmp_path / "clip", clips.small_model())
    given = ["--encoder", "clip", "--weights", str(weights), "--workers", "1"]
    out = str(tmp_path / "set.safetensors")
    assert main(["embed", str(tmp_path / "pairs"), *given, "--out", out]) == 0
    return tmp_path


def records(folder, *more):
    out = folder / f"out{len(list(folder.glob('out*')))}"
    given = ["--embeddings", str(folder / "set.safetensors"), "--out", str(out), "--seeds", "0"]
    code = main(["protocol", *given, "--methods", METHODS, "--sources", "lab", *more])
    assert code == 0
    lines = (out / "runs.jsonl").read_text().splitlines()
    return {record["method"]: record for record in map(json.loads, lines)}


def test_they_run_where_embed_ran_and_moved_images_are_named_and_others_refused(folder, capsys):
    for found in records(folder).values():
        target = found["targets"]["field"]
        assert set(target["scores"]) >= {"fused", "vis", "tac"}
        assert target["pairs"] == 8 and set(target["margins"]) == {"vis", "tac", "pair"}
    shutil.move(folder / "pairs", folder / "moved")
    assert "--images PAIRS" in records(folder)["mmrl"]["skipped"]
    assert "targets" in records(folder, "--images", str(folder / "moved"))["mmrl"]
    Image.new("RGB", (30, 20), (255, 0, 0)).save(folder / "moved" / "field/wood/0_vis.png")
    assert "do not belong together" in records(folder)["ldc"]["skipped"]
    given = ["--embeddings", str(folder / "set.safetensors"), "--out", str(folder / "x")]
    assert main(["protocol", *given, "--images", str(folder / "nowhere")]) == 1
    assert "Check --images" in capsys.readouterr().err


def test_the_central_square_that_was_embedded_is_read_again(folder):
    wood, steel = (folder / "pairs" / "lab" / name for name in ("wood", "steel"))
    pairs = tuple(
        Pair(
            vis=place / "0_vis.png",
            tac=place / "0_tac.png",
            domain="lab",
            material=place.name,
            tac_crop=12,
        )
        for place in (wood, steel)
    )
    weights = folder / "clip" / "ViT.pt"
    out = folder / "cropped.safetensors"
    embed_pairs(PairSet(pairs=pairs, origin="crops"), "clip", out, weights=weights)
    found = load_embeddings(out)
    require_own_images(found)
    assert live_of(found).read("tac", 1).size == (12, 12)
    whole = replace(found, rows={k: v for k, v in found.rows.items() if k != "tac_crop"})
    with pytest.raises(DataError, match="do not belong together"):
        require_own_images(whole)
