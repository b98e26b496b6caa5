"""Touch drawn as its relief: lamps of each domain, mirrored copies, headers, profiles, heads."""

import json
from itertools import pairwise

import numpy as np
import pytest
from PIL import Image

from omnivat.data.dots import FILLED
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.profile import profile_of
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.relief import drawn, lamps
from omnivat.data.relief.files import RELIEF, packed, spread, unpacked
from omnivat.data.rest import RESTED, with_rest
from omnivat.data.store import load_embeddings
from omnivat.encoders.base import DotsFilled, ReliefDrawn, made_by
from omnivat.encoders.cache import embed_image
from omnivat.encoders.embed import embed_pairs
from omnivat.head.profile_pictures import pictures_in, profile_of_pictures
from omnivat.kit.errors import DataError, SettingsError
from tests.unit.data.reliefs import touches

from .small_pairs import MeanColour, embed, make_pairs

pytestmark = pytest.mark.usefixtures("mean_encoder")
COUNT = 8


@pytest.fixture
def pairs(tmp_path):
    """Touches of "gel", with a dirty spot, and of "few", which has two."""
    found = []
    dirt = 128 + np.eye(112)[..., None] * 60
    for k, touch in enumerate(touches(1, COUNT + 2, light=dirt)):
        domain = "gel" if k < COUNT else "few"
        files = {name: tmp_path / domain / "wood" / f"{k}_{name}.png" for name in ("vis", "tac")}
        files["vis"].parent.mkdir(parents=True, exist_ok=True)
        Image.fromarray(touch).save(files["tac"])
        Image.new("RGB", (32, 32), (k, 90, 90)).save(files["vis"])
        found.append(Pair(**files, domain=domain, material="wood", object=str(k)))
    return PairSet(pairs=tuple(found))


def picture(pair):
    return np.asarray(Image.open(pair.tac))


def test_touch_is_drawn_by_the_lamps_of_its_domain_or_by_itself_with_the_reason(pairs, tmp_path):
    report = embed(pairs, tmp_path / "set.safetensors", touch="relief")
    loaded = load_embeddings(report.out)
    assert loaded.header.preprocessing == "none" + FILLED + RELIEF
    own = lamps([picture(pair) for pair in pairs.pairs[:COUNT]], dots="keep")
    assert packed(loaded.header.lamps["gel"]) == packed(own) and own.background is not None
    assert "there are 2; add 1" in loaded.header.lamps["few"]
    assert loaded.header.lit_by == {"gel": COUNT}
    relief = drawn(picture(pairs.pairs[3]), own, dots="keep")
    assert np.array_equal(loaded.tac[3], embed_image(MeanColour(), Image.fromarray(relief)))
    alone = drawn(picture(pairs.pairs[-1]), dots="keep")
    assert np.array_equal(loaded.tac[-1], embed_image(MeanColour(), Image.fromarray(alone)))
    assert np.array_equal(loaded.vis[3], embed_image(MeanColour(), pairs.pairs[3].vis))


def test_known_lamps_are_used_in_place_of_those_found(pairs, tmp_path):
    known = lamps([picture(pair) for pair in pairs.pairs[:5]], dots="keep")
    out = tmp_path / "set.safetensors"
    few = load_embeddings(embed(pairs, out, touch="relief", lamps={"few": known}).out)
    assert few.header.lit_by == {"gel": COUNT, "few": 5}
    assert made_by(ReliefDrawn(MeanColour(), {"few": known})) != made_by(
        ReliefDrawn(MeanColour(), {"few": few.header.lamps["gel"]})
    )
    relief = drawn(picture(pairs.pairs[-1]), known, dots="keep")
    assert np.array_equal(few.tac[-1], embed_image(MeanColour(), Image.fromarray(relief)))


def test_a_rest_picture_is_subtracted_before_the_relief_is_drawn(pairs, tmp_path):
    Image.fromarray(np.full((112, 112, 3), 120, np.uint8)).save(tmp_path / "gel" / "rest.png")
    loaded = load_embeddings(
        embed(with_rest(pairs, "all"), tmp_path / "set.safetensors", touch="relief").out
    )
    assert loaded.header.preprocessing == "none" + FILLED + RELIEF + RESTED
    assert loaded.header.lit_by == {"gel": COUNT}


@pytest.mark.parametrize(("name", "dots"), [("efficientnet-lite0", "keep"), ("strip", "fill")])
def test_relief_needs_a_gel_whose_dots_are_filled(name, dots, tmp_path):
    with pytest.raises(SettingsError, match="whose printed dots were filled; leave out"):
        embed_pairs(
            make_pairs(tmp_path), name, tmp_path / "a.safetensors", touch="relief", dots=dots
        )


def test_lamps_of_a_domain_come_from_at_most_fifty_of_its_touches_evenly_spread():
    assert spread(range(9)) == [*range(9)] and spread([]) == []
    index = spread(range(1000))
    assert len(index) == 50 and index[0] == 0 and index[-1] == 999
    assert {b - a for a, b in pairwise(index)} == {20, 21}


@pytest.mark.parametrize(
    "wrong", [{"colours": [[1, None]] * 3}, {"background": "AAAA"}, {"ratio": None}]
)
def test_lamps_that_a_file_holds_damaged_are_refused(wrong):
    whole = json.loads(packed(lamps(touches(1, 3), dots="keep")))
    with pytest.raises(DataError, match=r"lamps.* make them again"):
        unpacked(json.dumps(whole | wrong))


@pytest.mark.parametrize("touch", ["colours", "relief"])
def test_a_profile_holds_the_lamps_by_which_its_touches_are_drawn(touch, pairs, tmp_path):
    made = load_embeddings(embed(pairs, tmp_path / "set.safetensors", touch=touch).out)
    encoder = DotsFilled(MeanColour()) if touch == "colours" else ReliefDrawn(MeanColour(), {})
    profile, skipped = profile_of_pictures(encoder, pictures_in(tmp_path / "gel"), domain="gel")
    assert skipped == () and profile.lamps.pictures == COUNT
    save_profile(tmp_path / "gel.safetensors", profile)
    again = load_profile(tmp_path / "gel.safetensors")
    assert packed(again.lamps) == packed(profile.lamps) and again.key == made.header.key
    of_set = profile_of(made, made.rows_of("gel"), domain="gel")
    assert np.allclose(again.channels["tac"].mean, of_set.channels["tac"].mean, atol=1e-4)
    assert (of_set.lamps is not None) == (touch == "relief")
    assert (again.relief is not None) == (touch == "colours")
    if again.relief:  # it is the profile that an encoder of reliefs makes, too
        drawn = ReliefDrawn(MeanColour(), {})
        other, _ = profile_of_pictures(drawn, pictures_in(tmp_path / "gel"), domain="gel")
        lit = again.read_by((*again.key[:2], drawn.preprocessing))
        assert lit.key == other.key and lit.relief is None
        assert np.array_equal(lit.channels["tac"].mean, other.channels["tac"].mean)
        beside = ReliefDrawn(MeanColour(), {}, "both")
        other, _ = profile_of_pictures(beside, pictures_in(tmp_path / "gel"), domain="gel")
        wide = again.read_by((*again.key[:2], beside.preprocessing))
        assert wide.key == other.key and wide.counts == other.counts
        for name, channels in other.channels.items():
            assert np.array_equal(wide.channels[name].mean, channels.mean)
            assert np.array_equal(wide.channels[name].variance, channels.variance)
        assert again.read_by(again.key) is again


def test_a_profile_of_touches_that_give_no_lamps_states_the_reason(tmp_path, pairs):
    profile, skipped = profile_of_pictures(
        DotsFilled(MeanColour()), pictures_in(tmp_path / "few"), domain="few"
    )
    assert profile.lamps is None and profile.counts == {"vis": 2, "tac": 2}
    assert [(one.what, one.why[:18]) for one in skipped] == [
        ("the lamps of the gel", "Lamps need 3 pictu")
    ]
