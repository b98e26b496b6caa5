"""A part of a large set drawn at random, and mapped pages given back."""

import numpy as np

from omnivat.data.arrays import released
from omnivat.data.store import load_embeddings, save_embeddings


def test_a_sample_is_drawn_once_and_for_all_in_order_and_says_so(make_embeddings):
    whole = make_embeddings()
    drawn = whole.sampled(10)
    assert len(drawn) == 10
    assert np.array_equal(drawn.vis, whole.sampled(10).vis)
    places = [whole.rows["vis"].index(name) for name in drawn.rows["vis"]]
    assert places == sorted(places)
    assert f"10 of {len(whole)} pairs, drawn at random" in drawn.header.origin
    assert whole.sampled(0) is whole
    assert whole.sampled(10**6) is whole
    assert not np.array_equal(whole.sampled(10, seed=1).vis, drawn.vis)


def test_a_mapped_array_whose_pages_were_given_back_reads_the_same(make_embeddings, tmp_path):
    save_embeddings(tmp_path / "a.safetensors", make_embeddings())
    loaded = load_embeddings(tmp_path / "a.safetensors")
    before = np.array(loaded.vis)
    released(loaded.vis)
    released(np.zeros(3))  # an array that is not mapped stays as it is
    assert np.array_equal(loaded.vis, before)
