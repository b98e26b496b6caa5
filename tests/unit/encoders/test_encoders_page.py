"""The worked page docs/encoders.md: its three wrappers are run, from the command line to a
prediction.
"""

import re
import sys
from pathlib import Path
from types import ModuleType

import numpy as np
import pytest
import torch
from PIL import Image
from torch import nn

from omnivat.cli import main
from omnivat.data.store import load_embeddings
from omnivat.encoders import load_encoder

PAGE = Path(__file__).parents[3] / "docs" / "encoders.md"
BLOCKS = re.findall(r"```python\n# (my_\w+)\.py[^\n]*\n(.*?)```", PAGE.read_text("utf-8"), re.S)


class Tokens(nn.Module):
    """The interface of Sparsh, AnyTouch and T3: images in, tokens out, a sensor where it takes
    one.
    """

    def __init__(self, channels):
        super().__init__()
        self.patch = nn.Conv2d(channels, 6, 32, 32)
        self.sensors = nn.Embedding(2, 6)

    def forward(self, images, sensor=None):
        tokens = self.patch(images).flatten(2).mT
        return tokens if sensor is None else tokens + self.sensors.weight[sensor]


class Pooled(Tokens):
    def forward(self, images, sensor=None):
        return super().forward(images, sensor).mean(1)


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A folder with the page's files, a stand-in for the authors' code and weights."""
    stand_in = ModuleType("touch_model")
    makers = {
        "build_touch_model": lambda: Tokens(3),
        "build_two_frame_model": lambda: Pooled(6),
        "build_sensor_model": lambda: Pooled(3),
    }
    for name, maker in makers.items():
        setattr(stand_in, name, maker)
    monkeypatch.setitem(sys.modules, "touch_model", stand_in)
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path / "cache"))
    monkeypatch.chdir(tmp_path)
    for name, code in BLOCKS:
        (tmp_path / f"{name}.py").write_text(code)
    torch.manual_seed(0)
    torch.save({"model": Tokens(3).state_dict()}, "my_touch.pt")
    torch.save(Pooled(6).state_dict(), "my_background.pt")
    torch.save(Pooled(3).state_dict(), "my_sensor.pt")
    return tmp_path


@pytest.mark.parametrize(
    ("name", "function", "channels"),
    [("my_touch", "load", 3), ("my_background", "load", 6), ("my_sensor", "load@GelSight", 4)],
)
def test_each_wrapper_of_the_page_is_an_encoder(folder, name, function, channels):
    encoder = load_encoder(f"{name}.py:{function}", weights=folder / f"{name}.pt")
    grey = Image.new("RGB", (50, 60), "grey")
    given = {"before": grey, "rest": grey, "sensor": encoder.sensor}
    pixels = encoder.preprocess(grey, **{name: given[name] for name in encoder.takes})
    assert encoder.width == 6 and pixels.shape == (channels, 224, 224)
    assert encoder.embed(pixels[None]).shape == (1, 6)


def test_a_wrapped_touch_goes_from_the_command_line_to_a_prediction(folder, capsys):
    """Photos by the default encoder, touch by the page's first wrapper; the head finds both
    again.
    """
    random = np.random.default_rng(0)
    for material in ("wood", "steel"):
        for i in range(3):
            for half in ("vis", "tac"):
                file = folder / "pairs" / "lab" / material / f"{i}_{half}.png"
                file.parent.mkdir(parents=True, exist_ok=True)
                pixels = random.integers(0, 256, (16, 16, 3), dtype=np.uint8)
                Image.fromarray(pixels).save(file)
    given = ["--tac-encoder", "my_touch.py:load", "--tac-weights", "my_touch.pt", "--no-flips"]
    assert main(["embed", "pairs", *given, "--workers", "1", "--out", "set.safetensors"]) == 0
    header = load_embeddings("set.safetensors").header
    assert header.encoder == "efficientnet-lite0 | my_touch.py:load"
    assert "mean of tokens" in header.preprocessing
    settings = ["--set", "lang=false", "--set", "epochs=1", "--set", "width=8"]
    trained = ["train", "--embeddings", "set.safetensors", "--source", "lab", "--out", "head"]
    assert main([*trained, *settings, "--no-calibration"]) == 0
    pair = [f"pairs/lab/wood/0_{half}.png" for half in ("vis", "tac")]
    capsys.readouterr()
    assert main(["predict", *pair, "--head", "head", "--no-cache"]) == 0
    assert "wood" in capsys.readouterr().out
