"""Which pictures a folder has, their modality and rest, and the profile that they give."""

from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.data.naming import modality_of
from omnivat.data.rest import RESTED
from omnivat.encoders.wrapping import TorchEncoder
from omnivat.head.profile_pictures import pictures_in, profile_of_pictures


def picture(path, value):
    path.parent.mkdir(parents=True, exist_ok=True)
    pixels = np.random.default_rng(value).integers(0, 255, (40, 40, 3), np.uint8)
    Image.fromarray(pixels).save(path)
    return path


@pytest.fixture
def by_name(tmp_path):
    for k in range(3):
        picture(tmp_path / "new" / f"press{k}_tac.png", k)
    picture(tmp_path / "new" / "vis" / "a.png", 9)
    picture(tmp_path / "new" / "other.png", 10)
    (tmp_path / "new" / "notes_tac.txt").write_text("no picture")
    (tmp_path / "new" / "folder_tac.png").mkdir()
    return tmp_path / "new"


@pytest.mark.parametrize(
    ("name", "modality"),
    [("a/x_vis.png", "vis"), ("a/tac.png", "tac"), ("tac/7.png", "tac"), ("a/b.png", "")],
)
def test_the_name_or_the_folder_gives_the_modality(name, modality):
    assert modality_of(Path(name)) == modality


def test_a_folder_without_pairs_is_read_by_name(by_name):
    found = pictures_in(by_name)

    assert sorted((p.modality, Path(str(p.source)).name) for p in found) == [
        ("tac", "press0_tac.png"), ("tac", "press1_tac.png"), ("tac", "press2_tac.png"),
        ("vis", "a.png"),
    ]  # fmt: skip
    assert all(p.crop == 0 and p.rest is None for p in found)


def test_a_rest_picture_is_of_touches_alone(by_name, tmp_path):
    rest = picture(tmp_path / "rest.png", 20)
    found = pictures_in(by_name, rest=str(rest))

    assert {(p.modality, p.rest) for p in found} == {("vis", None), ("tac", rest)}


class FirstPixels(torch.nn.Module):
    def forward(self, images):
        return images.flatten(1)[:, :6]


def encoder():
    return TorchEncoder(FirstPixels(), side=40)


def test_a_profile_is_the_mean_of_whole_pictures_and_names_a_subtracted_rest(by_name, tmp_path):
    own = encoder()
    found = pictures_in(by_name)
    profile, skipped = profile_of_pictures(own, found, domain="new")
    wanted = [
        own.embed(own.preprocess(Image.open(str(p.source)).convert("RGB"))[None])[0].numpy()
        for p in found
        if p.modality == "tac"
    ]

    assert skipped == () and profile.counts == {"vis": 1, "tac": 3}
    np.testing.assert_allclose(profile.channels["tac"].mean, np.mean(wanted, axis=0), rtol=1e-5)
    assert profile.key[2] == own.preprocessing
    rest = picture(tmp_path / "rest.png", 20)
    rested, _ = profile_of_pictures(own, pictures_in(by_name, rest=str(rest)))
    assert rested.key[2] == own.preprocessing + RESTED


def test_a_broken_picture_is_skipped_and_named(by_name):
    (by_name / "broken_tac.png").write_bytes(b"no picture")
    profile, skipped = profile_of_pictures(encoder(), pictures_in(by_name))

    assert profile.counts["tac"] == 3
    assert [one.what.endswith("broken_tac.png") for one in skipped] == [True]
