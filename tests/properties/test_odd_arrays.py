"""Every public function that takes arrays gives a result or one sentence for any odd one."""

import inspect
import re
import warnings
from dataclasses import replace
from itertools import product

import numpy as np
import pytest
import torch

import omnivat
from omnivat.data.relief import Lamps
from omnivat.head.checkpoint import Head
from omnivat.head.head import build_head
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError, OmniVatError

ROWS = torch.rand(12, 8, generator=torch.Generator().manual_seed(0))
ARRAY = ROWS.numpy()


class Broken:
    def __array__(self, *_, **__):
        raise RuntimeError("broken")


def deep(levels):
    return [deep(levels - 1)] if levels else []


ODD = {
    "COO": lambda: ROWS.to_sparse(),
    "oneDNN": lambda: ROWS.to_mkldnn(),
    "meta": lambda: ROWS.to("meta"),
    "quantised": lambda: torch.quantize_per_tensor(ROWS, 0.1, 0, torch.quint8),
    "nested": lambda: torch.nested.nested_tensor([ROWS[:2], ROWS[:3]]),
    "complex half": lambda: ROWS.to(torch.complex32),
    "8 bits": lambda: ROWS.to(torch.float8_e4m3fn),
    "bfloat16": lambda: ROWS.bfloat16(),
    "uint16": lambda: ROWS.to(torch.uint16),
    "booleans": lambda: ROWS > 0.5,
    "not numbers": lambda: ROWS * float("nan"),
    "no rows": lambda: ROWS[:0],
    "no axes": lambda: torch.tensor(1.0),
    "five axes": lambda: ROWS[None, None, None],
    "storage": lambda: ROWS.untyped_storage(),
    "backwards": lambda: ARRAY[::-1, ::-1],
    "masked": lambda: np.ma.array(ARRAY, mask=ARRAY > 0.5),
    "matrix": lambda: np.matrix(ARRAY),
    "objects": lambda: ARRAY.astype(object),
    "dates": lambda: np.zeros((12, 8), "M8[s]"),
    "texts": lambda: ARRAY.astype(str),
    "complex": lambda: ARRAY.astype("c8"),
    "a number": lambda: 3.0,
    "nothing": lambda: None,
    "a mapping": lambda: {"a": 1},
    "a generator": lambda: (row for row in ARRAY),
    "unequal rows": lambda: [[1.0], [1.0, 2.0]],
    "a list of tensors": lambda: list(ROWS),
    "huge numbers": lambda: [[10**400] * 8] * 12,
    "a deep list": lambda: deep(200),
    "an object": object,
    "a broken array": Broken,
}


@pytest.fixture(scope="module")
def doors():
    settings = HeadSettings(classes=("a", "b"), input_width=8, lang_width=4, width=8)
    key = {"name": "e", "weights_hash": "w", "preprocessing": "p"}
    head = Head(model=build_head(settings), encoder=key, provenance={}, familiarity=None)
    some = omnivat.load_embeddings(omnivat.default_embeddings()).select(np.arange(12))
    lit = Lamps(colours=np.eye(3, 2), background=None, ratio=0.1, confidence=0.9, pictures=5)

    def lesson(x):
        return omnivat.Lesson(label="a", vis=None, tac=x)

    one, kept = lesson(ROWS[:1]), omnivat.coefficients(ROWS)
    return {
        "dfrft": [lambda x, p=p: omnivat.dfrft(x, p) for p in (0.3, 1)],
        "dfrft, order": [lambda x: omnivat.dfrft(ROWS, x)],
        "coefficients": [omnivat.coefficients],
        "synthesise": [lambda x: omnivat.synthesise(x, 0.3), lambda x: omnivat.synthesise(kept, x)],
        "FractionalTransform": [omnivat.FractionalTransform, omnivat.FractionalTransform(0.3)],
        "OmniVaT": [lambda x: head.model(x, ROWS), lambda x: head.model(ROWS, ROWS, order=x)],
        "centroid_gap": [lambda x: omnivat.centroid_gap(ROWS, x)],
        "modality_gap": [lambda x: omnivat.modality_gap(ROWS, x)],
        "frechet": [lambda x: omnivat.frechet(ROWS, x)],
        "mmd_rbf": [lambda x: omnivat.mmd_rbf(ROWS, x)],
        "proxy_a": [lambda x: omnivat.proxy_a(ROWS, x)],
        "predict_embeddings": [lambda x: omnivat.predict_embeddings(head, ROWS, x)],
        "prediction, order": [lambda x: omnivat.predict_embeddings(head, ROWS, ROWS, order=x)],
        "journey": [lambda x: omnivat.journey(head, [], ROWS, x)],
        "Lesson": [lesson],
        "taught": [lambda x: omnivat.taught(head, [lesson(x), one])],
        "slopes": [lambda x: omnivat.slopes(x, lit)],
        "heights": [lambda x: omnivat.heights(x, lit)],
        "with_known_height": [lambda x: omnivat.with_known_height(lit, x, pixel=0.1, height=1.0)],
        "lamps": [lambda x: omnivat.lamps([x] * 5), omnivat.lamps],
        "sensor_card": [lambda x: omnivat.sensor_card([x] * 5), omnivat.sensor_card],
        "Embeddings": [lambda x: replace(some, tac=x)],
        "profile_of": [lambda x: omnivat.profile_of(some, x)],
        "sweep": [lambda x: omnivat.sweep(head.model, some, x)],
    }


def raw_errors(doors, odd):
    """Return what is no result and no sentence, by name."""
    found = {}
    for name, door in doors:
        try:
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                door(odd())
        except OmniVatError as error:
            if not re.fullmatch(r".*[.?]", str(error)):
                found[name] = str(error)
        except Exception as error:
            found[name] = repr(error)[:200]
    return found


@pytest.mark.parametrize("odd", ODD)
def test_an_odd_array_gives_a_result_or_one_sentence(doors, odd):
    each = [(name, door) for name, some in doors.items() for door in some]
    assert raw_errors(each, ODD[odd]) == {}


NAMING = ("centroid_gap", "frechet", "mmd_rbf", "proxy_a", "predict_embeddings", "OmniVaT")


def test_a_bad_number_is_named_by_row_and_column(doors):
    for name, value in product(NAMING, (np.nan, -np.inf)):
        spoilt = ROWS.clone()
        spoilt[3, 7] = value
        with pytest.raises(DataError, match="in row 3, column 7"):
            doors[name][0](spoilt)


def test_every_public_function_of_arrays_is_in_the_table(doors):
    arrays = re.compile("Tensor|NDArray|ndarray")
    public = {name: getattr(omnivat, name) for name in omnivat.__all__}
    taking = {
        name
        for name, one in public.items()
        if callable(one) and arrays.search(str(inspect.signature(one)).partition(" -> ")[0])
    }
    outside = {"TorchEncoder", "gap_record"}  # these take functions that give tensors
    assert len(taking) > 15 and taking - outside - {*doors} == set()
