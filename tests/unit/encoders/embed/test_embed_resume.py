"""Interrupted runs resume from their finished parts."""

import numpy as np
import pytest

from omnivat.data.store import load_embeddings
from omnivat.encoders.cache import embed_image
from omnivat.kit.errors import DataError

from .small_pairs import MeanColour, embed, make_pairs, png

pytestmark = pytest.mark.usefixtures("mean_encoder")


@pytest.fixture
def small_chunks(monkeypatch):
    monkeypatch.setattr("omnivat.encoders.embed.job.CHUNK", 4)


class StopError(Exception):
    """Stands for whatever ends a run: Ctrl-C, a full disk, a lost machine."""


def stop_after(count):
    def on_step(step):
        if step.done >= count:
            raise StopError

    return on_step


@pytest.mark.usefixtures("small_chunks")
@pytest.mark.parametrize("stopped_at", [4, 7])
def test_an_interrupted_run_goes_on_and_ends_in_the_same_bytes(tmp_path, stopped_at):
    pairs = make_pairs(tmp_path, bad=(2,))
    whole = embed(pairs, tmp_path / "whole.safetensors")
    out = tmp_path / "set.safetensors"
    out.write_bytes(b"what was there before")
    with pytest.raises(StopError):
        embed(pairs, out, on_step=stop_after(stopped_at))
    assert out.read_bytes() == b"what was there before"
    steps = []
    report = embed(pairs, out, on_step=steps.append)
    assert report.resumed == (stopped_at - 1) // 4 * 4
    assert steps[0].done == report.resumed
    assert report.skipped == whole.skipped
    assert out.read_bytes() == whole.out.read_bytes()
    assert not out.with_name("set.safetensors.parts").exists()


@pytest.mark.usefixtures("small_chunks")
def test_parts_of_changed_images_or_settings_or_damaged_ones_are_made_again(tmp_path):
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


@pytest.mark.usefixtures("small_chunks")
def test_a_part_that_is_removed_meanwhile_is_not_left_out_in_silence(tmp_path):
    pairs, out = make_pairs(tmp_path), tmp_path / "set.safetensors"

    def removed(step):
        if step.done == step.total:
            (tmp_path / "set.safetensors.parts" / "part-0000000.safetensors").unlink()

    with pytest.raises(DataError, match="Of 3 parts 2 can be read"):
        embed(pairs, out, on_step=removed)
    assert not out.exists()
    assert embed(pairs, out).embedded == len(pairs.pairs)
