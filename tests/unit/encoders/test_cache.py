"""The cache: an image is decoded and encoded once, and damage on disk costs time only."""

import numpy as np
import pytest

from omnivat.encoders.cache import (
    EmbeddingCache,
    default_cache,
    embed_image,
    embed_pair,
    embed_views,
)
from omnivat.kit.errors import DataError

from .embed.small_pairs import MeanColour, png


class Counting(MeanColour):
    """It counts its calls."""

    def __init__(self, weights_hash="a"):
        self.weights_hash = weights_hash
        self.calls = 0

    def embed(self, images):
        self.calls += 1
        return super().embed(images)


def entries(folder):
    return sorted(folder.glob("??/*"))


def test_the_same_bytes_are_encoded_once_in_memory_and_once_on_disk(tmp_path):
    encoder, first = Counting(), EmbeddingCache(tmp_path)
    one, two = (embed_image(encoder, png(), first) for _ in range(2))
    three = embed_image(encoder, png(), EmbeddingCache(tmp_path))
    assert encoder.calls == 1 and np.array_equal(one, two) and np.array_equal(one, three)


def test_the_cache_of_predictions_lies_in_the_folder_of_the_variable(tmp_path, monkeypatch):
    monkeypatch.setenv("OMNIVAT_CACHE", str(tmp_path))
    embed_image(Counting(), png(), default_cache())
    assert len(entries(tmp_path / "embeddings")) == 1


def test_whatever_changes_the_embedding_changes_the_key(tmp_path):
    cache = EmbeddingCache(tmp_path)
    encoder, other = Counting(), Counting("b")
    embed_image(encoder, png(), cache)
    embed_views(encoder, png(), cache, flips=(True,))
    embed_image(encoder, png(), cache, crop=8)
    embed_image(encoder, png(1), cache)
    (tmp_path / "rest.png").write_bytes(png(2))
    embed_image(encoder, png(), cache, rest=tmp_path / "rest.png")
    embed_image(other, png(), cache)
    for attribute in ("name", "preprocessing", "precision"):
        changed = Counting()
        setattr(changed, attribute, "changed")
        embed_image(changed, png(), cache)
        assert changed.calls == 1
    assert (encoder.calls, other.calls) == (5, 1)
    assert len(entries(tmp_path)) == 9


def test_a_mirrored_image_has_the_embedding_of_the_mirrored_pixels():
    plain, mirrored = embed_views(Counting(), png())
    np.testing.assert_allclose(mirrored, np.roll(plain, 3))


@pytest.mark.parametrize(
    "damaged",
    [lambda _: b"", lambda good: good[:-1] + bytes([good[-1] ^ 1])],
    ids=["empty", "one bit"],
)
def test_a_damaged_entry_is_computed_again_and_mended(tmp_path, damaged):
    encoder = Counting()
    wanted = embed_image(encoder, png(), EmbeddingCache(tmp_path))
    (entry,) = entries(tmp_path)
    good = entry.read_bytes()
    entry.write_bytes(damaged(good))
    assert np.array_equal(embed_image(encoder, png(), EmbeddingCache(tmp_path)), wanted)
    assert encoder.calls == 2
    assert entry.read_bytes() == good


def test_memory_and_disk_are_bounded(tmp_path):
    encoder, cache = Counting(), EmbeddingCache(tmp_path, in_memory=3)
    for seed in range(8):
        embed_image(encoder, png(seed), cache)
    assert len(cache._held) == 3
    EmbeddingCache(tmp_path, on_disk=5)
    assert len(entries(tmp_path)) == 5


def test_a_folder_that_cannot_be_written_costs_nothing_but_time(tmp_path):
    (tmp_path / "file").write_text("in the way")
    encoder = Counting()
    embed_image(encoder, png(), EmbeddingCache(tmp_path / "file" / "below"))
    assert encoder.calls == 1


def test_only_the_tactile_image_of_a_pair_is_cut_and_either_may_lack():
    vis, tac = embed_pair(Counting(), png(), png(), tac_crop=6)
    assert np.array_equal(vis, embed_image(Counting(), png()))
    assert np.array_equal(tac, embed_image(Counting(), png(), crop=6))
    assert np.array_equal(embed_pair(Counting(), png(), None)[0], vis)
    assert embed_pair(Counting(), None, None) == (None, None)


def test_an_unreadable_upload_is_named_by_its_modality():
    with pytest.raises(DataError, match="the TAC image"):
        embed_pair(Counting(), png(), b"no image")
