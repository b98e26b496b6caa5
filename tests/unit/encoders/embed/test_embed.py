"""Embedding a set of pairs: bad images are skipped, settings are checked, files are complete."""

import os
from pathlib import Path

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.data.dots import FILLED, fill_dots
from omnivat.data.images import read_image
from omnivat.data.pairs import Pair, PairSet
from omnivat.data.rest import RESTED, minus_rest, with_rest
from omnivat.data.store import load_embeddings
from omnivat.encoders.cache import embed_image, embed_views
from omnivat.kit.errors import DataError, MissingNameError, SettingsError

from .small_pairs import MeanColour, embed, make_pairs, png

pytestmark = pytest.mark.usefixtures("mean_encoder")


def test_every_pair_has_the_embeddings_of_its_images(tmp_path):
    pairs = make_pairs(tmp_path)
    report = embed(pairs, tmp_path / "set.safetensors")
    loaded = load_embeddings(report.out)
    assert (report.embedded, report.resumed, report.skipped) == (10, 0, ())
    for i, pair in enumerate(pairs.pairs):
        for name, file in (("vis", pair.vis), ("tac", pair.tac)):
            wanted, mirrored = embed_views(MeanColour(), file)
            assert np.array_equal(getattr(loaded, name)[i], wanted)
            assert np.array_equal(getattr(loaded, f"{name}_flip")[i], mirrored)
        assert loaded.header.domains[loaded.domain[i]] == pair.domain
        assert loaded.header.classes[loaded.label[i]] == pair.material
    assert loaded.header.classes == ("wood", "glass", "cork")
    assert loaded.rows["object"] == [pair.object for pair in pairs.pairs]
    assert loaded.rows["vis"][1] == "OF Real/wood/1_vis.png"
    assert loaded.header.origin == "made by a test"
    assert not (tmp_path / "set.safetensors.parts").exists()


def printed(seed):
    """A gel (128, 128, 3) with a grid of dots."""
    y, x = np.mgrid[:128, :128]
    gel = np.random.default_rng(seed).integers(100, 180, 3) + 0.2 * x[..., None]
    gel[np.hypot(x % 18 - 9, y % 18 - 9) < 3] *= 0.3
    return np.asarray(gel, np.uint8)


def test_dots_are_filled_in_touch_alone_unless_they_are_kept(tmp_path):
    pairs = make_pairs(tmp_path / "set", 4)
    for file in (pairs.pairs[1].vis, pairs.pairs[1].tac):
        Image.fromarray(printed(1)).save(file)
    kept = load_embeddings(embed(pairs, tmp_path / "kept.safetensors", dots="keep").out)
    filled = load_embeddings(embed(pairs, tmp_path / "filled.safetensors").out)
    assert filled.header.preprocessing == kept.header.preprocessing + FILLED
    assert np.array_equal(filled.vis, kept.vis) and np.array_equal(filled.vis_flip, kept.vis_flip)
    others = [0, 2, 3]
    assert np.array_equal(filled.tac[others], kept.tac[others])
    clean = Image.fromarray(fill_dots(printed(1))[0])
    assert np.array_equal(filled.tac[1], embed_image(MeanColour(), clean))
    assert (filled.tac[1] > kept.tac[1]).all() and (filled.tac_flip[1] > kept.tac_flip[1]).all()


def test_a_rest_picture_changes_touch_alone_and_is_named_in_the_header(tmp_path):
    pairs = make_pairs(tmp_path / "set", 4)
    (tmp_path / "set" / "OF Real" / "rest.png").write_bytes(png(99))
    plain = load_embeddings(embed(pairs, tmp_path / "plain.safetensors").out)
    rested = with_rest(pairs, "all")
    loaded = load_embeddings(embed(rested, tmp_path / "set.safetensors").out)

    own = loaded.domain == loaded.header.domains.index("OF Real")
    assert np.array_equal(loaded.vis, plain.vis)
    assert np.array_equal(loaded.tac[~own], plain.tac[~own])
    assert (loaded.tac[own] != plain.tac[own]).all(axis=1).all()
    assert set(loaded.header.tac_rest) == {"OF Real"}
    assert loaded.header.preprocessing == plain.header.preprocessing + RESTED
    # The expected value, by hand: mean colours add up where nothing is clipped.
    wanted = np.asarray(minus_rest(read_image(rested.pairs[1].tac), read_image(png(99))), float)
    assert np.allclose(loaded.tac[1][:3], wanted[:, :10].mean((0, 1)), atol=1e-4)


def test_pairs_with_an_unreadable_image_are_left_out_and_listed(tmp_path):
    pairs = make_pairs(tmp_path, bad=(3, 4))
    pairs.pairs[7].vis.unlink()
    report = embed(pairs, tmp_path / "set.safetensors")
    assert report.embedded == 7
    for number, skipped in zip((3, 4, 7), report.skipped, strict=True):
        assert str(pairs.pairs[number].tac) in skipped.what
    assert "is not an image" in report.skipped[0].why
    assert "cannot be read" in report.skipped[2].why
    loaded = load_embeddings(report.out)
    assert loaded.rows["object"] == [f"o{i}" for i in (0, 1, 2, 5, 6, 8, 9)]


def test_a_set_without_pairs_or_of_which_none_can_be_read_is_refused(tmp_path):
    with pytest.raises(DataError, match="no pairs to embed in here"):
        embed(PairSet(pairs=(), origin="here"), tmp_path / "set.safetensors")
    with pytest.raises(DataError, match="None of 3 pairs could be read"):
        embed(make_pairs(tmp_path, 3, bad=(0, 1, 2)), tmp_path / "set.safetensors")
    assert not list(tmp_path.glob("set*"))


def test_a_photo_shared_by_many_touches_is_encoded_once(tmp_path, monkeypatch):
    pairs = make_pairs(tmp_path, 6)
    for pair in pairs.pairs:
        pair.vis.write_bytes(png(0))
    calls = []
    original = MeanColour.embed
    monkeypatch.setattr(MeanColour, "embed", lambda s, x: calls.append(1) or original(s, x))
    embed(pairs, tmp_path / "set.safetensors", workers=1)
    assert len(calls) == 2 + 2 * 6


def test_the_number_of_workers_changes_nothing(tmp_path):
    pairs = make_pairs(tmp_path)
    before = torch.get_num_threads()
    one, some = tmp_path / "one.safetensors", tmp_path / "some.safetensors"
    embed(pairs, one, workers=1)
    embed(pairs, some, workers=3)
    assert one.read_bytes() == some.read_bytes()
    assert torch.get_num_threads() == before


@pytest.mark.parametrize(
    ("settings", "error"),
    [
        ({"engine": "rai"}, MissingNameError),
        ({"dtype": "int8"}, SettingsError),
        ({"manifest": "xls"}, SettingsError),
        ({"workers": 0}, SettingsError),
    ],
)
def test_settings_are_checked_before_any_work(tmp_path, settings, error):
    with pytest.raises(error):
        embed(make_pairs(tmp_path, 2), tmp_path / "set.safetensors", **settings)
    assert not list(tmp_path.glob("set*"))


def test_names_that_are_no_text_still_give_a_readable_table(tmp_path):
    (pair,) = make_pairs(tmp_path, 1).pairs
    odd = Path(os.fsdecode(os.fsencode(pair.vis.parent) + b"/\xff_vis.png"))
    try:
        pair.vis.rename(odd)
    except OSError:
        pytest.skip("this disk takes no such names")
    strange = Pair(vis=odd, tac=pair.tac, domain="TAG", material="glass")
    report = embed(PairSet(pairs=(strange,)), tmp_path / "set.safetensors")
    assert load_embeddings(report.out).rows["vis"][0].endswith("\\xff_vis.png")


def test_dots_are_filled_before_a_rest_picture_is_subtracted(tmp_path):
    pairs, shots = make_pairs(tmp_path / "set", 2), (printed(1), np.roll(printed(1), 7, (0, 1)))
    for file, shot in zip(
        (pairs.pairs[1].tac, tmp_path / "set" / "OF Real" / "rest.png"), shots, strict=True
    ):
        Image.fromarray(shot).save(file)
    loaded = load_embeddings(embed(with_rest(pairs, "all"), tmp_path / "set.safetensors").out)
    clean = minus_rest(*(Image.fromarray(fill_dots(shot)[0]) for shot in shots))
    assert np.array_equal(loaded.tac[1], embed_image(MeanColour(), clean))
    assert loaded.header.preprocessing == "none" + FILLED + RESTED
