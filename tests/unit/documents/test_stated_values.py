"""Public defaults have the values that the paper or a document states.

docs/method.md, docs/gaps.md and docs/order.md give the reasons. A change of one is a decision: it
is made here and in its document, too.
"""

import inspect
from importlib import import_module

import pytest

STATED = {
    "omnivat.head.settings:HeadSettings": {
        "width": 512,
        "expansion": 4,
        "levels": 3,
        "order": 0.5,
        "logit_scale": 10.0,
    },
    "omnivat.training:TrainSettings": {
        "epochs": 20,
        "batch": 16,
        "lr": 0.05,
        "momentum": 0.9,
        "weight_decay": 0.0005,
        "warmup_epochs": 1.0,
        "clip": 1.0,
        "order_lr_scale": 0.01,
        "mma_weight": 10.0,
        "nod_weight": 1.0,
        "lang_drop": 0.5,
        "class_token_drop": 0.5,
        "noise": 0.0,
        "shift": 0.0,
    },
    "omnivat.head.losses:joint_loss": {"mma_weight": 10.0, "nod_weight": 1.0},
    "omnivat.maps.projection.torch_umap:project": {"steps": 200, "rate": 0.5},
}


@pytest.mark.parametrize("place", STATED)
def test_a_parameter_has_its_stated_default(place):
    module, _, name = place.partition(":")
    parameters = inspect.signature(getattr(import_module(module), name)).parameters
    assert {name: parameters[name].default for name in STATED[place]} == STATED[place]


@pytest.mark.parametrize(
    ("module", "name", "value"),
    [("calibration", "BINS", 15), ("proxy_a", "FOLDS", 5), ("proxy_a", "RIDGE", 0.01)],
)
def test_a_gap_is_measured_as_its_document_states(module, name, value):
    assert getattr(import_module(f"omnivat.measure.gaps.{module}"), name) == value
