"""Live's own functions on real frames of GelSights: contact, and a recording for LeRobot."""

import io
import json
import shutil
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.data.readers import read_pairs

ROOT = Path(__file__).resolve().parents[4]
SIZE = (256, 192)  # as Live draws them
SCRIPT = """
import { readFileSync, writeFileSync } from "node:fs";
await import(`${ROOT}/tests/web/browser.js`);
const { apart, blocksOf, restOf } = await import(`${ROOT}/app/web/pair/feed.js`);
const { dataSets } = await import(`${ROOT}/app/web/pair/lerobot.js`);
const { zipped } = await import(`${ROOT}/app/web/pair/zip.js`);
const blocks = (name) => blocksOf({ data: readFileSync(name), width: 256, height: 192 });
const { rest, frames, pictures, out } = JSON.parse(readFileSync(0));
if (rest) {
  const known = restOf(rest.map(blocks));
  const touched = (name) => apart(blocks(name), known.mean) > known.limit;
  console.log(JSON.stringify(known && frames.map(touched)));
} else {
  const blob = (name) => new Blob([readFileSync(name)]);
  const contentOf = async (blob) => new Uint8Array(await blob.arrayBuffer());
  const pairs = pictures.map(({ label, ...files }, k) => {
    const shots = Object.entries(files).map(([name, file]) => [name, blob(file), [256, 192]]);
    return { label, time: 1e12 + 250 * k, pictures: shots };
  });
  const files = zipped(await dataSets(pairs, contentOf));
  writeFileSync(out, Buffer.concat(files.map((part) => Buffer.from(part))));
}
"""


def page(**asked):
    """Run the page's own scripts outside a browser."""
    if shutil.which("node") is None:
        pytest.skip("node is not installed")
    script = SCRIPT.replace("${ROOT}", ROOT.as_uri())
    done = subprocess.run(
        ["node", "--input-type=module", "-e", script],
        input=json.dumps(asked), capture_output=True, text=True, timeout=240,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return json.loads(done.stdout or "null")


def written(folder, name, pixels, noise, random):
    """Write a frame as the canvas holds it, with the noise of a camera; return its place."""
    small = np.asarray(Image.fromarray(pixels).resize(SIZE), float)
    noisy = np.clip(small + random.normal(0, noise, small.shape), 0, 255).astype(np.uint8)
    (folder / name).write_bytes(
        np.dstack([noisy, np.full(noisy.shape[:2], 255, np.uint8)]).tobytes()
    )
    return str(folder / name)


def test_each_real_press_is_a_contact_and_no_rest_frame_is(tmp_path, presses):
    calm, pressed = presses("gelsight_mini")
    random = np.random.default_rng(0)
    rest = [written(tmp_path, f"r{k}", calm, 4, random) for k in range(10)]
    brighter = [np.clip(calm.astype(int) + k, 0, 255).astype(np.uint8) for k in range(3)]
    again = [written(tmp_path, f"a{k}", brighter[k % 3], 4, random) for k in range(12)]
    touched = [written(tmp_path, f"p{k}", one, 4, random) for k, one in enumerate(pressed)]
    found = page(rest=rest, frames=[*again, *touched])
    assert not any(found[:12]) and all(found[12:])
    assert len(pressed) >= 24


def test_a_recording_of_live_is_a_data_set_of_lerobot_and_is_imported(tmp_path, presses):
    """Of photo and touch; a source that ends begins another data set."""
    datasets, pandas = pytest.importorskip("datasets"), pytest.importorskip("pandas")
    _, pressed = presses("gelsight_mini")
    pictures = []
    for k, one in enumerate(pressed[:7]):
        files = {}
        for half in ("vis", "tac") if k < 6 else ("tac",):
            files[half] = str(tmp_path / f"{k}_{half}")
            Image.fromarray(one).resize(SIZE).save(files[half], "JPEG")
        pictures.append({"label": ("wood", "a/b ü", "=felt")[min(k // 2, 2)], **files})
    page(pictures=pictures, out=str(tmp_path / "recording.zip"))
    with zipfile.ZipFile(io.BytesIO((tmp_path / "recording.zip").read_bytes())) as packed:
        packed.extractall(tmp_path)
    sets = {path.name for path in tmp_path.glob("My sensor*")}
    assert sets == {"My sensor", "My sensor 2"}
    root = tmp_path / "My sensor"
    info = json.loads((root / "meta" / "info.json").read_text("utf-8"))
    kinds = {name: one["dtype"] for name, one in info["features"].items()}
    features = {
        n: datasets.Value(k) if k != "image" else datasets.Image() for n, k in kinds.items()
    }
    frames = datasets.Dataset.from_parquet(
        str(root / "data" / "chunk-000" / "file-000.parquet"),
        features=datasets.Features(features),
        cache_dir=tmp_path / "cache",
    )
    assert frames["timestamp"][:] == [k / info["fps"] for k in frames["frame_index"]]
    assert frames["time"][:] == [k / 4 for k in range(6)] and info["fps"] == 4
    assert frames[3]["observation.images.tactile"].size == SIZE
    tasks = pandas.read_parquet(root / "meta" / "tasks.parquet")
    assert [tasks.iloc[k].name for k in frames["task_index"]][::2] == ["wood", "a/b ü", "=felt"]
    line = ["import", str(root), "--out", str(tmp_path / "pairs"), "--frames", "2"]
    assert main(line) == 0
    found = read_pairs(tmp_path / "pairs")
    assert (len(found.pairs), found.domains()) == (6, ("My sensor",))
    assert found.modalities() == ("vis", "tac") and len(found.materials()) == 3
    assert info["codebase_version"] == "v3.0" and len({p.object for p in found.pairs}) == 3
