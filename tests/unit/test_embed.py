"""Embedding a set of pairs: bad images are skipped, interrupted runs resume, files are complete."""

import os
import subprocess
import sys
from collections.abc import Callable, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.cli import main
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.store import load_embeddings
from omnivat.embed import EmbedReport, embed_pairs
from omnivat.embed import job as job_module
from omnivat.embed.local import in_order
from omnivat.encoders import ENCODERS
from omnivat.encoders.cache import embed_image
from omnivat.errors import DataError, MissingNameError, OmniVatError, SettingsError
from omnivat.progress import Step


class MeanColour:
    """A quick encoder: the mean colour of each half of the image."""

    name, width, preprocessing, precision, weights_hash = "mean", 6, "none", "fp32", "0"

    def preprocess(self, image: Image.Image) -> torch.Tensor:
        return torch.from_numpy(np.array(image)).permute(2, 0, 1).float()

    def embed(self, images: torch.Tensor) -> torch.Tensor:
        half = images.shape[-1] // 2
        halves = (images[..., :half], images[..., half:])
        return torch.cat([part.mean(dim=(2, 3)) for part in halves], dim=1)


def load_mean(**_: Any) -> MeanColour:
    return MeanColour()


@pytest.fixture(autouse=True)
def mean_encoder(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("omnivat.encoders.efficientnet.load_lite0", load_mean)
    assert ENCODERS["efficientnet-lite0"].endswith("load_lite0")


@pytest.fixture
def small_chunks(monkeypatch: pytest.MonkeyPatch) -> None:
    original = job_module.chunks_of
    monkeypatch.setattr("omnivat.embed.pairs.chunks_of", lambda *given: original(*given, size=4))


def png(seed: int) -> bytes:
    pixels = np.random.default_rng(seed).integers(0, 256, (16, 20, 3), dtype=np.uint8)
    buffer = BytesIO()
    Image.fromarray(pixels).save(buffer, "PNG")
    return buffer.getvalue()


def make_pairs(root: Path, count: int = 10, bad: Sequence[int] = ()) -> PairSet:
    """Write `count` pairs; the TAC images numbered in `bad` are no images."""
    pairs = []
    for i in range(count):
        domain, material = ("TAG", "OF Real")[i % 2], ("glass", "wood", "cork")[i % 3]
        folder = root / domain / material
        folder.mkdir(parents=True, exist_ok=True)
        vis, tac = folder / f"{i}_vis.png", folder / f"{i}_tac.png"
        vis.write_bytes(png(2 * i))
        tac.write_bytes(b"no image" if i in bad else png(2 * i + 1))
        pairs.append(
            Pair(vis=vis, tac=tac, domain=domain, material=material, object=f"o{i}", split="train")
        )
    return PairSet(pairs=tuple(pairs), origin="made by a test")


def embed(pairs: PairSet, out: Path, **settings: Any) -> EmbedReport:
    return embed_pairs(pairs, "efficientnet-lite0", out, **settings)


def test_every_pair_has_the_embeddings_of_its_images(tmp_path: Path) -> None:
    pairs = make_pairs(tmp_path)
    report = embed(pairs, tmp_path / "set.safetensors")
    loaded = load_embeddings(report.out)
    assert (report.embedded, report.resumed, report.skipped) == (10, 0, ())
    for i, pair in enumerate(pairs.pairs):
        for name, file in (("vis", pair.vis), ("tac", pair.tac)):
            wanted = embed_image(MeanColour(), file)
            mirrored = embed_image(MeanColour(), file, flip=True)
            assert np.array_equal(getattr(loaded, name)[i], wanted)
            assert np.array_equal(getattr(loaded, f"{name}_flip")[i], mirrored)
        assert loaded.header.domains[loaded.domain[i]] == pair.domain
        assert loaded.header.classes[loaded.label[i]] == pair.material
    assert loaded.header.classes == ("wood", "glass", "cork")
    assert loaded.rows["object"] == [pair.object for pair in pairs.pairs]
    assert loaded.rows["vis"][1] == "OF Real/wood/1_vis.png"
    assert loaded.header.origin == "made by a test"
    assert not (tmp_path / "set.safetensors.parts").exists()


def test_the_crop_of_a_pair_is_cut_from_its_tactile_image_alone(tmp_path: Path) -> None:
    (pair,) = make_pairs(tmp_path, 1).pairs
    cut = Pair(vis=pair.vis, tac=pair.tac, domain="TAG", material="glass", tac_crop=8)
    loaded = load_embeddings(embed(PairSet(pairs=(cut,)), tmp_path / "set.safetensors").out)
    assert np.array_equal(loaded.vis[0], embed_image(MeanColour(), pair.vis))
    assert np.array_equal(loaded.tac[0], embed_image(MeanColour(), pair.tac, crop=8))


def test_pairs_with_an_unreadable_image_are_left_out_and_listed(tmp_path: Path) -> None:
    pairs = make_pairs(tmp_path, bad=(3, 4))
    pairs.pairs[7].vis.unlink()
    report = embed(pairs, tmp_path / "set.safetensors")
    assert report.embedded == 7
    for number, skipped in zip((3, 4, 7), report.skipped, strict=True):
        assert str(pairs.pairs[number].tac) in skipped.what
    assert "is not an image" in report.skipped[0].why
    assert "cannot be read" in report.skipped[2].why
    loaded = load_embeddings(report.out)
    assert loaded.rows["object"] == [f"o{i}" for i in (0, 1, 2, 5, 6, 8, 9)]


def test_a_set_of_which_nothing_can_be_read_is_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="None of 3 pairs could be read"):
        embed(make_pairs(tmp_path, 3, bad=(0, 1, 2)), tmp_path / "set.safetensors")
    assert not list(tmp_path.glob("set*"))


def test_no_pairs_are_refused(tmp_path: Path) -> None:
    with pytest.raises(DataError, match="no pairs to embed in here"):
        embed(PairSet(pairs=(), origin="here"), tmp_path / "set.safetensors")


class StopError(Exception):
    """Stands for whatever ends a run: Ctrl-C, a full disk, a lost machine."""


def stop_after(count: int) -> Callable[[Step], None]:
    def on_step(step: Step) -> None:
        if step.done >= count:
            raise StopError

    return on_step


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("stopped_at", [1, 4, 7, 10])
def test_an_interrupted_run_goes_on_and_ends_in_the_same_bytes(
    tmp_path: Path, stopped_at: int
) -> None:
    pairs = make_pairs(tmp_path, bad=(2,))
    whole = embed(pairs, tmp_path / "whole.safetensors")
    out = tmp_path / "set.safetensors"
    out.write_bytes(b"what was there before")
    with pytest.raises(StopError):
        embed(pairs, out, on_step=stop_after(stopped_at))
    assert out.read_bytes() == b"what was there before"
    steps: list[Step] = []
    report = embed(pairs, out, on_step=steps.append)
    assert report.resumed == (stopped_at - 1) // 4 * 4
    assert steps[0].done == report.resumed
    assert report.skipped == whole.skipped
    assert out.read_bytes() == whole.out.read_bytes()
    assert not out.with_name("set.safetensors.parts").exists()


@pytest.mark.usefixtures("small_chunks")
def test_parts_of_changed_images_or_settings_or_damaged_ones_are_made_again(tmp_path: Path) -> None:
    pairs = make_pairs(tmp_path)
    out = tmp_path / "set.safetensors"
    with pytest.raises(StopError):
        embed(pairs, out, on_step=stop_after(9))
    pairs.pairs[1].vis.write_bytes(png(99) + b" ")
    part = next(iter(sorted(out.with_name("set.safetensors.parts").glob("*1.safetensors"))))
    part.write_bytes(part.read_bytes()[:-5])
    report = embed(pairs, out)
    assert report.resumed == 0
    assert np.array_equal(load_embeddings(out).vis[1], embed_image(MeanColour(), png(99)))
    with pytest.raises(StopError):
        embed(pairs, out, on_step=stop_after(9))
    assert embed(pairs, out, flips=False).resumed == 0


def test_a_photo_shared_by_many_touches_is_encoded_once(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    pairs = make_pairs(tmp_path, 6)
    for pair in pairs.pairs:
        pair.vis.write_bytes(png(0))
    calls: list[int] = []
    original = MeanColour.embed
    monkeypatch.setattr(MeanColour, "embed", lambda s, x: calls.append(1) or original(s, x))
    embed(pairs, tmp_path / "set.safetensors", workers=1)
    assert len(calls) == 2 + 2 * 6


@pytest.mark.parametrize("workers", [1, 2, 5])
def test_the_number_of_workers_changes_nothing(tmp_path: Path, workers: int) -> None:
    pairs = make_pairs(tmp_path)
    before = torch.get_num_threads()
    one, some = tmp_path / "one.safetensors", tmp_path / "some.safetensors"
    embed(pairs, one, workers=1)
    embed(pairs, some, workers=workers)
    assert one.read_bytes() == some.read_bytes()
    assert torch.get_num_threads() == before


def test_progress_counts_every_pair_with_rate_and_time_left(tmp_path: Path) -> None:
    steps: list[Step] = []
    embed(make_pairs(tmp_path), tmp_path / "set.safetensors", on_step=steps.append)
    assert [step.done for step in steps] == list(range(11))
    assert {step.total for step in steps} == {10}
    assert all("pairs/s" in step.text and "left" in step.text for step in steps[1:])


def test_results_come_in_order_with_few_under_way() -> None:
    from concurrent.futures import ThreadPoolExecutor

    drawn: list[int] = []

    def items() -> Any:
        for i in range(50):
            drawn.append(i)
            yield i

    with ThreadPoolExecutor(3) as pool:
        for i, result in enumerate(in_order(pool, lambda x: x * x, items(), window=5)):
            assert result == i * i
            assert len(drawn) <= i + 5


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        ({"engine": "rai"}, MissingNameError),
        ({"dtype": "int8"}, SettingsError),
        ({"manifest": "xls"}, SettingsError),
        ({"workers": 0}, SettingsError),
    ],
)
def test_settings_are_checked_before_any_work(
    tmp_path: Path, settings: dict[str, Any], error: type[OmniVatError]
) -> None:
    with pytest.raises(error):
        embed(make_pairs(tmp_path, 2), tmp_path / "set.safetensors", **settings)
    assert not list(tmp_path.glob("set*"))


@pytest.mark.parametrize(
    ("device", "sentence"),
    [
        ("gpu", "No device is called 'gpu'; use auto, cpu or cuda."),
        ("cuda", "Device 'cuda' needs a GPU, and none is usable here; use cpu."),
    ],
)
def test_a_device_that_is_not_there_is_refused(
    device: str,
    sentence: str,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    monkeypatch.setattr(torch.cuda, "is_available", lambda: False)
    make_pairs(tmp_path / "pairs", 2)
    out = tmp_path / "set.safetensors"
    assert main(["embed", str(tmp_path / "pairs"), "--out", str(out), "--device", device]) == 1
    assert sentence in capsys.readouterr().err
    assert not list(tmp_path.glob("set*"))


def test_names_that_are_no_text_still_give_a_readable_table(tmp_path: Path) -> None:
    (pair,) = make_pairs(tmp_path, 1).pairs
    odd = Path(os.fsdecode(os.fsencode(pair.vis.parent) + b"/\xff_vis.png"))
    try:
        pair.vis.rename(odd)
    except OSError:
        pytest.skip("this disk takes no such names")
    strange = Pair(vis=odd, tac=pair.tac, domain="TAG", material="glass")
    report = embed(PairSet(pairs=(strange,)), tmp_path / "set.safetensors")
    assert load_embeddings(report.out).rows["vis"][0].endswith("\\xff_vis.png")


KILLED = """
import os, sys
from pathlib import Path
from omnivat.embed import job
job.CHUNK = 4
job.chunks_of.__defaults__ = (4,)
from omnivat.data.pairs import Pair, PairSet
from omnivat.embed import embed_pairs

files = sorted(Path(sys.argv[1]).glob("*/*/*_vis.png"))
pairs = [
    Pair(vis=f, tac=f.with_name(f.name.replace("_vis", "_tac")), domain="TAG", material="wood")
    for f in files
]

def on_step(step):
    if step.done == int(sys.argv[3]):
        os.kill(os.getpid(), 9)

report = embed_pairs(PairSet(pairs=tuple(pairs)), "efficientnet-lite0", sys.argv[2], on_step=on_step)
print(report.resumed)
"""


@pytest.mark.slow
def test_a_process_that_is_killed_leaves_parts_that_the_next_one_uses(tmp_path: Path) -> None:
    """With the real encoder, in processes of their own."""
    make_pairs(tmp_path / "pairs", 9)
    out = tmp_path / "set.safetensors"

    def run(stop: int) -> subprocess.CompletedProcess[str]:
        command = [sys.executable, "-c", KILLED, str(tmp_path / "pairs"), str(out), str(stop)]
        return subprocess.run(command, capture_output=True, text=True, check=False)

    assert run(6).returncode == -9
    assert not out.exists()
    assert run(99).stdout.strip() == "4"
    assert len(load_embeddings(out)) == 9
