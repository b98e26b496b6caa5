"""No-contact pictures: what is subtracted, and which picture belongs to which image."""

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from PIL import Image

from omnivat.data.pairs import Pair, PairSet
from omnivat.data.readers import read_pairs
from omnivat.data.rest import has_markers, minus_rest, with_rest
from omnivat.kit.errors import DataError


def grey(value, side=8):
    return Image.new("RGB", (side, side), (value, value, value))


@given(st.integers(0, 255), st.integers(0, 255))
def test_the_difference_lies_around_mid_grey_and_is_clipped(touched, calm):
    wanted = np.clip((touched - calm) / 255 + 0.5, 0, 1) * 255
    found = np.asarray(minus_rest(grey(touched), grey(calm, side=16)), float)
    assert np.abs(found - wanted).max() <= 0.5 + 1e-9


def a_set(root):
    for name in ("TAG/wood/a", "TQ-DIGIT/wood/unit 2/b", "TQ-DIGIT/steel/c"):
        for half in ("vis", "tac"):
            file = root / f"{name}_{half}.png"
            file.parent.mkdir(parents=True, exist_ok=True)
            grey(hash(name) % 256).save(file)


def test_the_nearest_rest_picture_above_an_image_is_its_own_and_none_is_a_pair(tmp_path):
    a_set(tmp_path)
    places = [tmp_path / name / "rest.png" for name in ("TAG", "TQ-DIGIT", "TQ-DIGIT/wood/unit 2")]
    for place in places:
        grey(100).save(place)
    found = read_pairs(tmp_path)
    assert len(found.pairs) == 3 and not found.skipped

    every = {pair.tac.stem: pair.tac_rest for pair in with_rest(found, "all").pairs}
    assert every == {"a_tac": places[0], "b_tac": places[2], "c_tac": places[1]}
    auto = {pair.tac.stem: pair.tac_rest for pair in with_rest(found, "auto").pairs}
    assert auto == every | {"a_tac": None}  # a marker gel
    one = {pair.tac_rest for pair in with_rest(found, str(places[1])).pairs}
    assert one == {places[1]}
    assert with_rest(found, "none") == found


def test_a_rest_picture_outside_the_set_is_not_taken(tmp_path):
    folder = tmp_path / "set"
    a_set(folder)
    grey(100).save(tmp_path / "rest.png")
    pair = Pair(vis=Path("x"), tac=folder / "a/b/c_tac.png", domain="a", material="wood")
    with pytest.raises(DataError, match=r"No 'rest\.png' lies in the folders"):
        with_rest(PairSet(pairs=(pair,)), "all")


def test_a_rest_picture_that_is_not_there_is_refused(tmp_path):
    a_set(tmp_path)
    with pytest.raises(DataError, match="nothing.png"):
        with_rest(read_pairs(tmp_path), str(tmp_path / "nothing.png"))


def test_the_sensors_with_printed_markers_are_known_in_simulated_domains_too():
    names = ("TAG", "TAG-sim", "TQ-T3D-sim", "TQ-DIGIT-sim", "OF 2.0 A", "lab")
    assert [has_markers(name) for name in names] == [True, True, True, False, False, False]
