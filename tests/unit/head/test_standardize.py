"""A head standardizes its input by the profile of its source."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.data.profile import STEP_SHIFTED, moved, profile_of
from omnivat.head.checkpoint import load_head
from omnivat.head.head import build_head
from omnivat.head.predict import predict_embeddings
from omnivat.kit.errors import DataError
from omnivat.training import TrainSettings, plan_training, trained_head


@pytest.fixture(scope="module")
def head(head_folder):
    return load_head(head_folder)


def test_a_sensor_that_shifts_channels_gets_the_same_probabilities_with_its_profile(
    head, make_embeddings
):
    source = make_embeddings().in_domain("TAG-sim")
    other = replace(source, vis=source.vis + 4, tac=source.tac - 3)
    profile = profile_of(other)
    vis, tac = torch.from_numpy(other.vis), torch.from_numpy(other.tac)
    plain = predict_embeddings(head, torch.from_numpy(source.vis), torch.from_numpy(source.tac))
    lost = predict_embeddings(head, vis, tac)
    back = predict_embeddings(head, vis, tac, profile=profile)

    def away(records):
        pairs = zip(records, plain, strict=True)
        return max(
            abs(a["probabilities"][name] - b["probabilities"][name])
            for a, b in pairs
            for name in a["probabilities"]
        )

    assert away(back) < 0.4 * away(lost)  # 40 pictures count 40 / 44 of their mean
    assert back[0]["profile"] == {"vis": len(source), "tac": len(source)}


def test_familiarity_is_that_of_the_pictures_before_any_profile(head, make_embeddings):
    if head.familiarity is None:
        pytest.skip("the head holds no familiarity")
    source = make_embeddings().in_domain("TAG-sim")
    away = torch.from_numpy(source.tac + 9)
    profile = profile_of(replace(source, tac=source.tac + 9))
    moved = predict_embeddings(head, None, away, profile=profile)[0]["familiarity"]["tac"]
    plain = predict_embeddings(head, None, away)[0]["familiarity"]["tac"]
    assert moved["cosine"] == plain["cosine"]


def test_a_head_without_a_profile_takes_embeddings_as_they_come(head):
    bare = build_head(replace(head.settings, standardize=False))
    rows = torch.randn(2, 24)
    assert torch.equal(bare.standardised("vis", rows), rows)
    with pytest.raises(DataError, match="has no profile of its source"):
        replace(head, profile=None).moved("vis", rows, head.source_profile)


def test_a_head_trained_with_imitated_sensors_takes_a_shorter_step(make_embeddings):
    pairs, settings = make_embeddings(), TrainSettings(epochs=1, lang=False, shift=1.0)
    plan = plan_training(pairs, "TAG-sim", head={"width": 8}, training=settings)
    made = trained_head(plan, calibrate=False)
    assert made.source_profile.step == STEP_SHIFTED


def test_moved_rows_of_the_head_are_those_of_the_arrays(head, make_embeddings):
    pairs = make_embeddings()
    profile = profile_of(pairs, pairs.rows_of("OF Real-sim"))
    rows = pairs.vis[:3]
    whole, part = (
        replace(head, profile=replace(head.source_profile, step=step)).moved(
            "vis", torch.from_numpy(rows), profile
        )
        for step in (1.0, 0.75)
    )
    channels = profile.channels["vis"], head.source_profile.channels["vis"]
    np.testing.assert_allclose(whole, moved(rows, *channels), rtol=1e-6)
    np.testing.assert_allclose(part, moved(rows, *channels, 0.75), rtol=1e-6)
    assert (part - whole).abs().max() > 1e-3


def test_rows_have_half_the_root_of_their_width_as_length_and_for_teaching_one_side_by_side(
    head, make_embeddings
):
    source = make_embeddings().in_domain("TAG-sim")
    raw = {name: torch.from_numpy(getattr(source, name)) for name in ("vis", "tac")}
    length = head.model.standardised("tac", raw["tac"]).norm(dim=1)
    torch.testing.assert_close(length, torch.full_like(length, 0.5 * 24**0.5))
    rows = [head.model.standing(name, values) for name, values in raw.items()]
    torch.testing.assert_close(torch.cat(rows, dim=1).norm(dim=1), torch.ones(len(length)))
