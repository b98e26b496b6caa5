"""Defaults, bounds and limits have the values that benchmarks chose and documents state.

docs/method.md, docs/fractional.md, docs/gaps.md and docs/order.md give the reasons. A change of one
is a decision: it is made here and in its document, too.
"""

import inspect
from importlib import import_module
from typing import Any

import pytest
from numpy.testing import assert_equal

from omnivat.fractional.double_double import Pair
from omnivat.head.settings import HeadSettings
from omnivat.kit.config import Within, declared
from omnivat.training import TrainSettings

FRACTIONAL = {
    "batches": {"_ELEMENTS": 131_072, "_WORTH_A_LOOP": 16, "_WORTH_WORKERS": 262_144},
    "build": {"_KEPT": 16, "_WORTH_THREADS": 128},
    "eigenvectors": {"_COLUMNS": 128},
    "memory": {"_LARGE": 1_048_576, "_IDLE_LIMIT": 268_435_456, "_GRAIN": 1_048_576},
    "phases": {"_GRID": 1_073_741_824.0},
    "splits": {"_FEW_ROWS": 32, "_FEW_ROWS_UP_TO": 1024},
    "workers": {"_MOST": 8},
    "double_double": {"_SPLITTER": 2.0**27 + 1, "SQRT2": Pair(2.0**0.5, -9.667293313452913e-17)},
}
MODEL = {"factored": {"VECTOR": 16}, "fusion": {"TINY": 1e-12}, "head": {"CHUNK": 512}}
GAPS = {
    "large": {"DRAWN": 20_000, "LEAST": 4096},
    "mmd": {
        "BLOCK": 1024,
        "ACROSS": 16_384,
        "MOST_ROWS": 20_000,
        "GROUPS": 16,
        "FEATURES": 64,
        "SAMPLE": 2048,
    },
    "sums": {"AT_ONCE": 256},
}
TRAIN = {
    "batches": {"SPREAD_ROWS": 512},
    "order_search": {
        "MOST": 256,
        "MOST_STOPS": 2001,
        "RIDGE": 1.0,
        "FINE": tuple(
            k * 0.125 for k in (-8, -7, -6, -5, -4, -3, -2, -1, 0, 1, 2, 3, 4, 5, 6, 7, 8)
        ),
        "VALLEYS": 3,
        "APART": 4.0,
        "DOUBT": 3.0,
    },
    "training": {"TEACHER": TrainSettings(epochs=120), "AFTER": 0.1},
}
PROJECTION = {
    "neighbours": {"BLOCK": 1024, "EXACT": 0.001},
    "pca": {"BLOCK": 16_384},
    "quality": {
        "SAMPLE": 1000,
        "NEIGHBOURS": 15,
        "TRUST_SAMPLE": 200,
        "BLOCK": 16_384,
        "AT_ONCE": 32,
    },
    "torch_umap": {
        "BISECTIONS": 32,
        "DIRECTIONS": 4,
        "ROUNDS": 30,
        "STRAIGHTEN": 5,
        "RADIUS": 10.0,
        "A": 1.5769,
        "B": 0.8951,
        "NEGATIVES": 5,
        "REPELLERS": 16,
        "STEPS": 200,
        "RATE": 0.5,
        "MOST_ROWS": 12_000,
        "PLACED": 8192,
        "CELLS_FROM": 100_000,
        "CELLS": 128,
        "RING": 16,
        "WARM_STEPS": 60,
        "WARM_RATE": 0.1,
        "PULL_LIMIT": 4.0,
    },
}
LIMITS = {
    f"omnivat.{area}.{module}": values
    for area, modules in {
        "fractional": FRACTIONAL,
        "head": MODEL,
        "measure.gaps": GAPS,
        "training": TRAIN,
        "maps.projection": PROJECTION,
    }.items()
    for module, values in modules.items()
} | {"omnivat.head.losses": {"EPS": 1e-12}, "omnivat.kit.shapes": {"AT_ONCE": 4096}}
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
    "omnivat.measure.gaps.large:drawn": {"seed": 0},
    "omnivat.measure.gaps.mmd:mmd_rbf_estimate": {"seed": 0},
    "omnivat.measure.gaps.proxy_a:proxy_a": {"folds": 5, "ridge": 0.01, "seed": 0},
    "omnivat.measure.gaps.proxy_a:proxy_a_estimate": {"folds": 5, "ridge": 0.01, "seed": 0},
    "omnivat.training:train": {"seed": 0},
    "omnivat.training:Watch": {"done": 0, "whole": 0},
    "omnivat.training:Trained": {"chosen_epoch": 0},
    "omnivat.maps.projection.torch_umap:chain": {"seed": 0, "neighbours": 15},
    "omnivat.maps.projection.torch_umap:following": {"seed": 0, "neighbours": 15},
    "omnivat.maps.projection.neighbours:place": {"k": 8},
    "omnivat.maps.projection.pca:project": {"seed": 0, "dimensions": 2},
    "omnivat.maps.projection.pca:basis": {"dimensions": 2},
    "omnivat.maps.projection.quality:quality": {"k": 15, "rows": 1000, "seed": 0},
    "omnivat.maps.projection.torch_umap:spectral_map": {"seed": 0, "dimensions": 2},
    "omnivat.maps.projection.torch_umap:project": {
        "seed": 0,
        "dimensions": 2,
        "neighbours": 15,
        "steps": 200,
        "rate": 0.5,
    },
    "omnivat.maps.projection.umap:project": {"seed": 0, "dimensions": 2, "neighbours": 15},
    "omnivat.head.profile_pictures:Picture": {"crop": 0},
}
BOUNDS = {  # field: default, lowest, highest
    HeadSettings: {
        "input_width": (inspect.Parameter.empty, 1, 65_536),
        "lang_width": (384, 1, 65_536),
        "width": (512, 2, 8192),
        "taught": (0, 0, 100_000),
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


@pytest.mark.parametrize("module", LIMITS)
def test_a_limit_has_its_stated_value(module: str) -> None:
    for name, value in LIMITS[module].items():
        assert_equal(getattr(import_module(module), name), value, err_msg=name)


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
