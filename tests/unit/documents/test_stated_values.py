"""Public defaults and measures have the values that docs/method.md and docs/gaps.md state.

A change of one is a decision: it is made here and in its document, too.
"""

import inspect
from importlib import import_module
from pathlib import Path

import pytest

from omnivat.measure.gaps import calibration, proxy_a

DOCS = Path(__file__).resolve().parents[3] / "docs"
# name: default, and the words that state it
STATED = {
    "omnivat.head.settings:HeadSettings": {
        "width": (512, "D = 512"),
        "expansion": (4, "E = 4"),
        "levels": (3, "R = 3"),
        "order": (0.5, "start 0.5"),
        "logit_scale": (10.0, "cosine classifier times 10"),
    },
    "omnivat.head.reference:Reference": {"expansion": (4, "E = 4"), "levels": (3, "R = 3")},
    "omnivat.training:TrainSettings": {
        "epochs": (20, "20 epochs"),
        "batch": (16, "batches of 16"),
        "lr": (0.05, "SGD 0.9, 0.05"),
        "momentum": (0.9, "SGD 0.9"),
        "weight_decay": (5e-4, "decay 5e-4"),
        "warmup_epochs": (1.0, "one warm-up epoch"),
        "clip": (1.0, "gradient norm clipped to 1"),
        "order_lr_scale": (0.01, "a hundredth of the others'"),
        "order_clip": (1.0, "clipped to ±1"),
        "mma_weight": (10.0, "λ = 10"),
        "nod_weight": (1.0, "λ MMA + NOD + cross-entropy"),
        "lang_drop": (0.5, "half of the pairs train without LANG"),
        "class_token_drop": (0.5, "for half of the training pairs"),
        "noise": (0.0, "`noise`, ours, off by default"),
        "shift": (0.0, "`shift`, ours, off by default"),
    },
    "omnivat.head.losses:joint_loss": {
        "mma_weight": (10.0, "λ = 10"),
        "nod_weight": (1.0, "λ MMA + NOD + cross-entropy"),
    },
}


def stated(document):
    return " ".join((DOCS / document).read_text(encoding="utf-8").split())


@pytest.mark.parametrize("place", STATED)
def test_a_parameter_has_its_stated_default(place):
    module, _, name = place.partition(":")
    parameters = inspect.signature(getattr(import_module(module), name)).parameters
    for parameter, (value, words) in STATED[place].items():
        assert parameters[parameter].default == value
        assert words in stated("method.md")


def test_a_gap_is_measured_as_its_document_states():
    assert calibration.BINS == 15 and "15 equal bins" in stated("gaps.md")
    assert proxy_a.FOLDS == 5 and "over five folds" in stated("gaps.md")
    assert proxy_a.RIDGE == 0.01 and "its penalty 0.01 of" in stated("gaps.md")
