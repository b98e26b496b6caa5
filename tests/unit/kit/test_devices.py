"""One place decides where to compute. Without a GPU: every tensor that is made lies on the
device.
"""

import os
import subprocess
import sys

import pytest
import torch

from omnivat.encoders import load_encoder
from omnivat.fractional import dfrft
from omnivat.head.checkpoint import load_head
from omnivat.head.heads import default_head
from omnivat.kit.devices import VARIABLE, computing_on, current, device_from, named, precise
from omnivat.kit.errors import SettingsError
from omnivat.training.batches import Batch

META = torch.device("meta")


def test_a_device_holds_inside_its_block_and_in_processes_started_there(monkeypatch):
    monkeypatch.delenv(VARIABLE, raising=False)
    assert named() == "cpu"
    with computing_on("meta"):
        assert current() == META
        code = "from omnivat.kit.devices import named; print(named())"
        child = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
        assert child.stdout.strip() == "meta"
    assert VARIABLE not in os.environ


@pytest.mark.parametrize("name", ["gpu", "cuda:99"])
def test_a_device_that_is_not_there_is_refused(name):
    with pytest.raises(SettingsError, match=f"Device '{name}' is not usable here .*; use auto"):
        device_from(name)


def test_single_precision_stands_in_where_double_does_not_exist():
    assert precise(torch.device("mps")) == torch.float32
    assert precise(torch.device("cuda")) == precise(torch.device("cpu")) == torch.float64


def test_a_loaded_head_and_the_transform_lie_on_the_device():
    with computing_on("meta"):
        model = load_head(default_head()).model
    assert {tensor.device for tensor in (*model.parameters(), *model.buffers())} == {META}
    turned = dfrft(torch.zeros(3, 16, device=META), torch.zeros(3, device=META))
    assert turned.device == META and turned.shape == (3, 16)


def test_a_batch_moves_whole():
    rows = torch.zeros(2, 4)
    on = torch.ones(2, dtype=torch.bool)
    batch = Batch(images={"vis": rows}, lang=rows, labels=on.long(), lang_on=on, token_on=on)
    moved = batch.to(META)
    assert list(moved.images) == ["vis"] and moved.order is None
    parts = moved.images["vis"], moved.lang, moved.labels, moved.lang_on, moved.token_on
    assert all(part.device == META for part in parts)


def test_clip_computes_on_the_device(clips, tmp_path):
    place = clips.write("transformers folder", tmp_path, clips.small_model())
    encoder = load_encoder("clip", weights=place, device="meta")
    found = encoder.embed(torch.zeros(2, 3, 96, 96))
    assert found.device == META and found.shape == (2, 24)


def test_the_default_encoder_computes_on_the_device():
    found = load_encoder("efficientnet-lite0", device="meta").embed(torch.zeros(1, 3, 224, 224))
    assert found.device == META and found.shape == (1, 1280)
