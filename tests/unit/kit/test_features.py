"""Arrays at the library's door: any numbers are taken, and a bad one is named by row and column."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat import (
    Lesson,
    centroid_gap,
    default_embeddings,
    default_head,
    frechet,
    load_embeddings,
    load_head,
    measured,
    mmd_rbf,
    modality_gap,
    predict_embeddings,
    profile_of,
    proxy_a,
)
from omnivat.kit.errors import OmniVatError
from omnivat.kit.shapes import SUMMED, features
from omnivat.maps.projection import pca, quality, torch_umap
from omnivat.maps.projection.neighbours import nearest, placed

WIDTH = 1280
ROWS = torch.rand(40, WIDTH, generator=torch.Generator().manual_seed(0))


@pytest.fixture(scope="module")
def doors():
    head = load_head(default_head())
    data = load_embeddings(default_embeddings()).select(np.arange(40))
    data = replace(data.unsplit, vis_flip=None, tac_flip=None)

    def whole(rows):
        return replace(data, vis=np.asarray(rows) if not isinstance(rows, torch.Tensor) else rows)

    return {
        "centroid": lambda x: centroid_gap(x, ROWS),
        "modality": lambda x: modality_gap(x, ROWS),
        "frechet": lambda x: frechet(x, ROWS),
        "mmd": lambda x: mmd_rbf(x, ROWS),
        "proxy-A": lambda x: proxy_a(x, ROWS),
        "PCA": pca.project,
        "UMAP": torch_umap.project,
        "neighbours": lambda x: nearest(x, 3),
        "placed": lambda x: placed(x, ROWS, ROWS[:, :2]),
        "quality": lambda x: quality.quality(x, ROWS[:, :2], k=5),
        "prediction": lambda x: predict_embeddings(head, x, ROWS),
        "one image": lambda x: predict_embeddings(head, None, x),
        "head": lambda x: head.model(x, ROWS),
        "lesson": lambda x: Lesson(label="a", vis=x, tac=None),
        "profile": lambda x: profile_of(whole(x)),
        "measured": lambda x: measured(head, whole(x)),
    }


NAMES = ("centroid", "modality", "frechet", "mmd", "proxy-A", "PCA", "UMAP", "neighbours", "placed",
         "quality", "prediction", "one image", "head", "lesson", "profile", "measured")  # fmt: skip
SCALED = (*NAMES[:5], *NAMES[10:14], "measured")  # which scale rows first


def spoilt(value):
    rows = ROWS.clone()
    rows[3, 7] = value
    return rows.numpy()


@pytest.mark.parametrize("name", NAMES)
def test_a_bad_number_is_named_and_other_kinds_are_taken_or_refused_in_a_sentence(doors, name):
    for value in (np.nan, np.inf, -np.inf, *(() if name in SCALED else (1e25, 3e38))):
        with pytest.raises(OmniVatError, match="in row 3, column 7"):
            doors[name](spoilt(value))
    array = ROWS.numpy()
    for odd in (array.astype("O"), array.astype("U4"), array + 1j, array[0], array[None]):
        with pytest.raises(OmniVatError, match=r"\.$"):
            doors[name](odd)
    if name not in ("profile", "measured"):  # of a set, which says what it holds
        for good in (ROWS.half(), ROWS.bfloat16(), (9 * ROWS).int(), ROWS > 0.5, ROWS.double()):
            doors[name](good)
        doors[name](array.astype(">f8")[::-1])
        doors[name](array.astype("u2") if name != "UMAP" else array.astype("f2"))


@pytest.mark.parametrize("name", NAMES[:9])
def test_what_holds_no_rows_of_numbers_is_refused_in_a_sentence(doors, name):
    for odd in (None, 3.0, {"a": 1}, [[1.0, 2.0], [3.0]], ROWS.to_sparse(), ROWS.to("meta")):
        with pytest.raises(OmniVatError, match=r"\.$"):
            doors[name](odd)


def test_no_query_has_no_neighbours():
    found = nearest(ROWS, 3, queries=ROWS[:0])
    assert found.index.shape == found.distance.shape == (0, 3)


def test_rows_keep_their_values_gradient_and_precision():
    (rows,) = features(rows=ROWS.half())
    assert rows.dtype == torch.float32 and torch.equal(rows, ROWS.half().float())
    rows, wide = features(rows=ROWS, wide=ROWS.double())
    assert rows.dtype == wide.dtype == torch.float64
    learned = ROWS.clone().requires_grad_()
    centroid_gap(learned, ROWS.flip(0) + 1).backward()
    assert learned.grad is not None
    assert features(most=SUMMED, rows=ROWS * 1e14)[0].max() > 1e13
