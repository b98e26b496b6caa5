"""Touches of another sensor are turned or recoloured as a head's: the options of `embed`."""

from argparse import Namespace

import numpy as np
import pytest
from PIL import Image

from omnivat.cli import main
from omnivat.cli.predict import _pairs
from omnivat.data.arranged import (
    FLIPS,
    WAYS,
    arranged,
    options_of,
    require_ways,
    ways_from,
    ways_in,
)
from omnivat.data.profile import profile_of
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.store import load_embeddings
from omnivat.kit.errors import DataError, SettingsError
from omnivat.measure.card.changes import ARRANGEMENTS


@pytest.mark.parametrize("way", ARRANGEMENTS, ids=lambda one: one.way)
def test_the_remedy_of_an_arrangement_gives_the_embeddings_of_the_pictures_as_they_were(
    way, tmp_path
):
    rng = np.random.default_rng(0)
    for k in range(2):
        picture = Image.fromarray(rng.integers(0, 255, (48, 48, 3), dtype=np.uint8))
        for folder, touch in (("old", picture), ("new", arranged(picture, way.way))):
            place = tmp_path / folder / "unit" / "wood"
            place.mkdir(parents=True, exist_ok=True)
            picture.save(place / f"{k}_vis.png")
            touch.save(place / f"{k}_tac.png")
    command = ["embed", "--encoder", "strip", "--workers", "1"]
    more = {"old": [], "new": options_of(way.back).split()}
    found = {}
    for name, options in more.items():
        out = tmp_path / f"{name}.safetensors"
        assert main([*command, str(tmp_path / name), "--out", str(out), *options]) == 0
        found[name] = load_embeddings(out)
    assert np.allclose(found["old"].tac, found["new"].tac, atol=1e-6)
    assert found["old"].header.tac_way == {}
    assert found["new"].header.tac_way == {"unit": way.back}
    save_profile(tmp_path / "unit.safetensors", profile_of(found["new"], domain="unit"))
    kept = load_profile(tmp_path / "unit.safetensors").way
    asked = Namespace(pairs=None, images=["a.png", "b.png"], flip=[], channels=[])
    assert _pairs(asked, "none", kept)[0][-1] == way.back  # `predict` then reads touches so


def test_every_way_has_an_option_and_one_domain_may_be_named():
    assert {way.way for way in ARRANGEMENTS} == set(WAYS)
    assert all(options_of(name) == f"--flip {name}" for name in FLIPS)
    assert ways_in(["b=clockwise"], ["bgr", "rgb"][:1], ["a", "b"]) == {
        "a": "bgr",
        "b": "clockwise bgr",
    }
    with pytest.raises(SettingsError, match="--flip names 'left'; give WAY or DOMAIN=WAY"):
        ways_in(["left"], [], ["a"])
    with pytest.raises(SettingsError, match="--channels names 'c'"):
        ways_in([], ["c=bgr"], ["a"])
    with pytest.raises(SettingsError, match="gives 'a' two ways"):
        ways_in(["left-right", "top-bottom"], [], ["a"])


def test_a_head_that_learned_turned_touches_refuses_the_same_domain_otherwise():
    require_ways({}, {"a": "bgr"})  # the pictures of another sensor, made to fit
    require_ways({"a": "bgr"}, {"a": "bgr"})
    with pytest.raises(DataError, match="learned the touches of 'a' with --channels bgr"):
        require_ways({"a": "bgr"}, {})


def test_a_header_with_an_unknown_arrangement_is_refused_in_a_sentence():
    assert ways_from('{"a": "left-right bgr"}') == {"a": "left-right bgr"}
    with pytest.raises(DataError, match="'sideways' is no arrangement; it has words of left-right"):
        ways_from('{"a": "sideways"}')
