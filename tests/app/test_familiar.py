"""Familiarity of an image, and its nearest training pairs."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from app.pair.tab import predicted
from app.shared.familiar import familiar, first, training_pairs
from app.shared.resources import Resources
from omnivat.data.store import save_embeddings
from omnivat.head.calibration import familiarity_of
from omnivat.measure.shares import counted

from .conftest import own_image


@pytest.fixture
def knowing(resources):
    """Return resources with a head that has its training embeddings."""
    embeddings, head = resources.embeddings(), resources.head()
    own = embeddings.in_domain(head.source)
    known = familiarity_of(torch.from_numpy(own.vis), torch.from_numpy(own.tac), own.rows["object"])
    resources.head._made[:] = [replace(head, familiarity=known)]
    return resources


def test_the_nearest_pairs_are_training_pairs_and_never_the_pair_itself(resources):
    got = familiar(resources, {"vis": "row:3", "tac": "row:50"})
    embeddings = resources.embeddings()
    unit = embeddings.vis / np.linalg.norm(embeddings.vis, axis=1, keepdims=True)
    cosines = unit @ unit[3]
    cosines[3] = -1
    cosines[embeddings.domain != 0] = -1
    wanted = np.argsort(-cosines)[:3]
    near = got["images"]["vis"]["nearest"]
    assert [one["pair"] for one in near] == wanted.tolist()
    assert [one["cosine"] for one in near] == pytest.approx(cosines[wanted], abs=1e-3)
    assert got["of"] == "the training pairs of GelSight (TAG)"
    assert all(embeddings.domain[one["pair"]] == 0 for one in got["images"]["tac"]["nearest"])


def test_a_set_in_half_precision_that_stays_in_its_file_has_nearest_pairs(
    resources, tmp_path, monkeypatch
):
    monkeypatch.setattr("app.shared.resources.MAPPED_BYTES", 0)
    save_embeddings(tmp_path / "half.safetensors", resources.embeddings(), dtype="float16")
    half = Resources(replace(resources.where, embeddings=tmp_path / "half.safetensors"))
    assert half.embeddings().vis.dtype == np.float16
    question = {"vis": "row:3", "tac": "row:50"}
    (near, wanted) = (
        [one["pair"] for one in familiar(some, question)["images"]["vis"]["nearest"]]
        for some in (half, resources)
    )
    assert near == wanted
    assert first(half) == first(resources)


def test_a_head_that_does_not_know_its_training_images_makes_no_claim(resources):
    resources.head._made[:] = [replace(resources.head(), familiarity=None)]
    assert predicted(resources, {"vis": "row:3"})["images"] == {}


def test_an_image_nearer_to_the_other_modality_strays_and_one_of_its_own_does_not(resources):
    own = resources.embeddings().in_domain(resources.head().source)
    photo, touch = own_image(resources, own.vis[3]), own_image(resources, own.tac[3])
    swapped = familiar(resources, {"vis": touch, "tac": photo})["images"]
    right = familiar(resources, {"vis": photo, "tac": touch})["images"]
    assert [swapped[name]["strays"] for name in ("vis", "tac")] == [True, True]
    assert [right[name]["strays"] for name in ("vis", "tac")] == [False, False]
    assert "strays" not in familiar(resources, {"vis": "row:3"})["images"]["vis"]


def test_without_a_domain_that_the_head_learned_from_all_pairs_of_the_set_are_compared(resources):
    head, embeddings = resources.head(), resources.embeddings()
    own, _ = training_pairs(resources, head)
    assert own.tolist() == np.flatnonzero(embeddings.domain == 0).tolist()
    elsewhere = replace(head, provenance={**head.provenance, "domains": ["TAG-sim", "TAG"]})
    every, of = training_pairs(resources, elsewhere)
    assert (len(every), of) == (len(embeddings), "the loaded set")


def test_pairs_that_test_the_head_are_not_among_those_it_learned_from(resources, make_embeddings):
    split = make_embeddings(split=True)
    resources.embeddings._made[:] = [split]
    own, _ = training_pairs(resources, resources.head())
    assert own.tolist() == split.rows_of("TAG-sim", split="train").tolist()


def with_quantiles(resources, cosine):
    """Let every image of the set be familiar (a low cosine) or unlike the training images (a
    high one).
    """
    known = resources.head().familiarity
    same = {name: torch.full_like(values, cosine) for name, values in known.quantiles.items()}
    resources.head._made[:] = [
        replace(resources.head(), familiarity=replace(known, quantiles=same))
    ]


def test_the_page_opens_with_a_pair_that_was_not_trained_on_and_is_no_guess(knowing):
    with_quantiles(knowing, -1.0)
    kind, row = first(knowing)["ref"].split(":")
    assert kind == "row"  # the examples of this set are not in it
    embeddings = knowing.embeddings()
    assert counted(embeddings, knowing.head().source)[int(row)]
    images = predicted(knowing, {"vis": f"row:{row}", "tac": f"row:{row}"})["images"]
    assert not any(image["guess"] for image in images.values())


def test_without_a_pair_that_can_be_predicted_no_pair_is_opened_first(knowing):
    with_quantiles(knowing, 2.0)
    assert first(knowing) == {"ref": None}
