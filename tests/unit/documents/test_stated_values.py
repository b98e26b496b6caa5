"""Public defaults and bounds have the values that the paper or a document states.

docs/method.md, docs/fractional.md, docs/gaps.md and docs/order.md give the reasons. A change of one
is a decision: it is made here and in its document, too.
"""

import inspect
from importlib import import_module
from typing import Any

import pytest

from omnivat.head.settings import HeadSettings
from omnivat.kit.config import Within, declared
from omnivat.training import TrainSettings

DEFAULTS = {
    "omnivat.fractional:coefficients": {"dim": -1},
    "omnivat.fractional:dfrft": {"dim": -1},
    "omnivat.fractional:FractionalTransform": {"order": 0.5, "dim": -1},
    "omnivat.head.dtg:DTG": {"levels": 3},
    "omnivat.head.head:build_head": {"seed": 0},
    "omnivat.head.mffa:FrATT": {"ffn_ratio": 4},
    "omnivat.head.mffa:MFFA.update_bank": {"momentum": 0.9},
    "omnivat.head.losses:joint_loss": {"mma_weight": 10.0, "nod_weight": 1.0},
    "omnivat.measure.gaps.calibration:ece": {"bins": 15},
    "omnivat.measure.gaps.proxy_a:proxy_a": {"folds": 5, "ridge": 0.01, "seed": 0},
    "omnivat.training:train": {"seed": 0},
    "omnivat.maps.projection.pca:project": {"seed": 0, "dimensions": 2},
    "omnivat.maps.projection.torch_umap:project": {
        "seed": 0,
        "dimensions": 2,
        "neighbours": 15,
        "steps": 200,
        "rate": 0.5,
    },
    "omnivat.maps.projection.umap:project": {"seed": 0, "dimensions": 2, "neighbours": 15},
}
BOUNDS = {  # field: default, lowest, highest
    HeadSettings: {
        "input_width": (inspect.Parameter.empty, 1, 65_536),
        "lang_width": (384, 1, 65_536),
        "width": (512, 2, 8192),
        "expansion": (4, 1, 64),
        "levels": (3, 1, 6),
        "order": (0.5, -4, 4),
        "ffn_ratio": (4, 1, 16),
        "logit_scale": (10.0, 0.001, 10_000),
    },
    TrainSettings: {
        "epochs": (20, 1, 100_000),
        "batch": (16, 1, 65_536),
        "lr": (0.05, 0, 100),
        "momentum": (0.9, 0, 0.9999),
        "weight_decay": (0.0005, 0, 100),
        "warmup_epochs": (1.0, 0, 100_000),
        "clip": (1.0, 1e-6, 1e6),
        "order_lr_scale": (0.01, 0, 1000),
        "order_clip": (1.0, 0, 1e12),
        "mma_weight": (10.0, 0, 1e6),
        "nod_weight": (1.0, 0, 1e6),
        "lang_drop": (0.5, 0, 1),
        "class_token_drop": (0.5, 0, 1),
        "val_fraction": (0.2, 0, 0.9),
        "order_stops": (21, 2, 1001),
        "order_low": (0.0, -4, 4),
        "order_high": (1.0, -4, 4),
        "order_teachers": (0, 0, 100),
        "noise": (0.0, 0, 100),
        "shift": (0.0, 0, 100),
    },
}


@pytest.mark.parametrize("place", DEFAULTS)
def test_a_parameter_has_its_stated_default(place: str) -> None:
    module, _, path = place.partition(":")
    found: Any = import_module(module)
    for name in path.split("."):
        found = getattr(found, name)
    parameters = inspect.signature(found).parameters
    assert {name: parameters[name].default for name in DEFAULTS[place]} == DEFAULTS[place]


@pytest.mark.parametrize("kind", BOUNDS)
def test_a_setting_has_its_stated_default_and_bounds(kind: type[Any]) -> None:
    parameters = inspect.signature(kind).parameters
    limits = {name: limit for name, limit in declared(kind).items() if isinstance(limit, Within)}
    found = {
        name: (parameters[name].default, limit.low, limit.high) for name, limit in limits.items()
    }
    assert found == BOUNDS[kind]
