"""Profiles: the statistics of a domain, without labels, and what they move."""

import json
import struct
import zlib
from base64 import b64encode
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data import profile
from omnivat.data.profile import (
    Profile,
    channels_of,
    domain_of,
    joined,
    moved,
    profile_of,
    profiled,
    shrunk,
    standardised,
)
from omnivat.data.profile_file import load_profile, save_profile
from omnivat.data.relief.files import packed, unpacked
from omnivat.data.relief.lamps import Lamps
from omnivat.kit.errors import DataError


def rows(count, seed, width=6, offset=0.0, scale=1.0):
    random = np.random.default_rng(seed)
    return (offset + scale * random.normal(size=(count, width))).astype(np.float32)


@given(st.integers(1, 40), st.floats(-100, 100))
def test_statistics_are_those_of_numpy_far_from_zero_too(count, offset):
    some = rows(count, 3, offset=offset)
    found = channels_of(some)
    wide = some.astype(np.float64)
    np.testing.assert_allclose(found.mean, wide.mean(0), rtol=1e-6, atol=1e-6)
    np.testing.assert_allclose(found.variance, wide.var(0), rtol=1e-5, atol=1e-6)
    assert found.count == count


@given(st.integers(1, 30), st.integers(1, 30), st.floats(-9, 9))
def test_the_statistics_of_two_sets_together_are_those_of_all_rows(few, more, offset):
    first, other = rows(few, 1), rows(more, 2, offset=offset)
    found, whole = joined(channels_of(first), channels_of(other)), np.vstack([first, other])
    np.testing.assert_allclose(found.mean, whole.mean(0), rtol=1e-4, atol=1e-5)
    np.testing.assert_allclose(found.variance, whole.var(0), rtol=1e-4, atol=1e-5)
    assert found.count == few + more


@given(st.integers(0, 500), st.integers(0, 500))
def test_more_pictures_weigh_more_and_a_mean_is_trusted_before_a_variance(few, more):
    source, target = channels_of(rows(50, 0)), channels_of(rows(50, 1, offset=4, scale=3))
    near, far = (shrunk(replace(target, count=n), source) for n in sorted((few, more)))
    assert (np.abs(far.mean - target.mean) <= np.abs(near.mean - target.mean) + 1e-6).all()
    share = (near.mean - source.mean) / (target.mean - source.mean)
    stretch = (near.variance - source.variance) / (target.variance - source.variance)
    assert (share >= stretch - 1e-4).all() and (share < 1).all()
    none = shrunk(replace(target, count=0), source)
    assert (none.mean == source.mean).all() and (none.variance == source.variance).all()


def test_standardising_moved_rows_equals_standardising_by_the_target_profile():
    source, target = channels_of(rows(500, 0)), channels_of(rows(10**3, 1, offset=2, scale=2))
    target = replace(target, count=10**9)  # nothing is drawn towards the source
    some = rows(5, 2, offset=2, scale=2)
    floor = np.sqrt(source.variance).mean()
    wanted = np.tanh((some - target.mean) / (np.sqrt(target.variance) + floor))
    np.testing.assert_allclose(standardised(moved(some, target, source), source), wanted, atol=1e-5)
    still = replace(source, variance=0 * source.variance)
    np.testing.assert_allclose(standardised(some, still), np.tanh(some - still.mean), atol=1e-6)


def test_a_head_moves_a_set_by_its_own_step(make_embeddings):
    pairs = make_embeddings(domains=("A", "B"))
    whole = profile_of(pairs, pairs.rows_of("A"))
    other = profile_of(pairs, pairs.rows_of("B"), domain="B")
    none, half, full = (
        profiled(pairs, {"B": other}, replace(whole, step=step)).vis for step in (0.0, 0.5, 1.0)
    )
    np.testing.assert_allclose(none, pairs.vis, atol=1e-5)
    assert 0.3 < np.abs(half - none).mean() / np.abs(full - none).mean() < 0.7


def test_only_the_profiled_domain_moves_and_mirrored_rows_move_with_it(
    make_embeddings, monkeypatch
):
    pairs = make_embeddings(domains=("A", "B", "C"))
    pairs = replace(pairs, vis_flip=pairs.vis, tac_flip=pairs.tac)
    source = profile_of(pairs, pairs.rows_of("A"))
    other = profile_of(pairs, pairs.rows_of("B"), domain="B")
    found = profiled(pairs, {"B": other}, source)
    monkeypatch.setattr(profile, "LARGE_BYTES", 0)  # larger arrays are filled in a file
    large = profiled(pairs, {"B": other}, source)
    still = pairs.domain != 1
    for name in ("vis", "tac", "vis_flip", "tac_flip"):
        before, after = getattr(pairs, name), getattr(found, name)
        assert isinstance(getattr(large, name), np.memmap)
        np.testing.assert_array_equal(getattr(large, name), after)
        np.testing.assert_array_equal(after[still], before[still])
        assert np.abs(after[~still] - before[~still]).max() > 0.01
    np.testing.assert_array_equal(found.vis_flip, found.vis)
    np.testing.assert_array_equal(found.tac_flip, found.tac)


def test_a_modality_without_pictures_stays(make_embeddings):
    pairs = make_embeddings(domains=("A", "B"))
    source = profile_of(pairs, pairs.rows_of("A"))
    whole = profile_of(pairs, pairs.rows_of("B"), domain="B")
    photos = replace(whole, channels={"vis": whole.channels["vis"]})
    found = profiled(pairs, {"B": photos}, source)
    np.testing.assert_array_equal(found.tac, pairs.tac)


def test_a_profile_of_another_encoder_is_refused(make_embeddings):
    pairs = make_embeddings(domains=("A", "B"))
    mine = profile_of(pairs, domain="B")
    other = replace(mine, key=("clip", "0", "resize"))
    with pytest.raises(DataError, match="comes from clip .* Make the profile with that encoder"):
        profiled(pairs, {"B": other}, mine)


def test_a_profile_without_a_name_is_of_the_only_other_domain():
    nameless = Profile(channels={"vis": channels_of(rows(2, 0))}, key=("e", "w", "p"))
    assert domain_of(nameless, ("A", "B"), "A") == "B"
    with pytest.raises(DataError, match="--domain and one of these names"):
        domain_of(nameless, ("A", "B", "C"), "A")


@pytest.mark.parametrize("spoilt", ["mean", "huge", "variance", "count", "step", "format"])
def test_a_damaged_profile_file_ends_in_one_sentence(tmp_path, make_embeddings, spoilt):
    file = tmp_path / "p.safetensors"
    mine = profile_of(make_embeddings(), domain="B")
    vis = mine.channels["vis"]
    changed = {
        "mean": replace(vis, mean=vis.mean * np.nan),
        "huge": replace(vis, mean=np.full_like(vis.mean, 3e38)),
        "variance": replace(vis, variance=-vis.variance - 1),
        "count": replace(vis, count=-3),
    }.get(spoilt, vis)
    step = float("nan") if spoilt == "step" else 1.0
    save_profile(file, replace(mine, step=step, channels={**mine.channels, "vis": changed}))
    if spoilt == "format":
        file.write_bytes(file.read_bytes().replace(b"omnivat-profile-1", b"omnivat-profile-9"))
    with pytest.raises(DataError) as caught:
        load_profile(file)
    assert str(file) in str(caught.value) and "\n" not in str(caught.value)
    assert ("(format 'omnivat-profile-9')" in str(caught.value)) is (spoilt == "format")


def test_a_missing_profile_is_not_called_damaged(tmp_path):
    with pytest.raises(DataError, match="cannot be read .No such file or directory.; check"):
        load_profile(tmp_path / "none.safetensors")
    with pytest.raises(DataError, match="is a folder, pipe or device; name a file"):
        load_profile(tmp_path)


@pytest.mark.parametrize(
    "odd", [{"pictures": 1e308}, {"pictures": 0}, {"ratio": float("nan")}, {"confidence": -1}]
)
def test_lamps_of_no_share_or_count_are_refused_before_a_set_that_nothing_reads_holds_them(odd):
    numbers = {"ratio": 0.1, "confidence": 0.9, "pictures": 5}
    text = json.loads(packed(Lamps(colours=np.eye(3, 2), background=None, **numbers)))
    assert unpacked(json.dumps(text)).pictures == 5
    with pytest.raises(DataError, match="from 0 to 1, and their pictures 1 to 1e"):
        unpacked(json.dumps(text | odd))


def test_a_background_of_lamps_with_a_huge_header_or_damage_ends_in_one_sentence():
    lamps = Lamps(
        colours=np.eye(3, 2),
        background=np.random.default_rng(0).integers(0, 255, (60, 60, 3), dtype=np.uint8),
        ratio=0.1,
        confidence=0.9,
        pictures=5,
    )
    record = json.loads(packed(lamps))
    whole = unpacked(packed(lamps)).background
    assert whole is not None and (whole == lamps.background).all()

    def png(side, pixels):
        parts = {b"IHDR": struct.pack(">IIBBBBB", side, side, 8, 2, 0, 0, 0), b"IDAT": pixels}
        chunks = (
            struct.pack(">I", len(some)) + name + some + struct.pack(">I", zlib.crc32(name + some))
            for name, some in parts.items()
        )
        return b"\x89PNG\r\n\x1a\n" + b"".join(chunks)

    for content in (png(60_000, b"x"), png(60, b"no deflate"), b"no picture"):
        record["background"] = b64encode(content).decode()
        with pytest.raises(DataError, match=r"background is no PNG .* make them again\.$"):
            unpacked(json.dumps(record))
