"""Pairs on the map of a set at every stop."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat import EXAMPLES
from omnivat.data.store import load_embeddings
from omnivat.head.checkpoint import load_head
from omnivat.kit.errors import DataError
from omnivat.maps.frames import read_frames
from omnivat.maps.journey import journey, map_stops
from omnivat.maps.projection.neighbours import affine, placed_by
from omnivat.measure.gaps.unit import unit


@pytest.fixture(scope="module")
def shipped():
    """Return the shipped head, its set and frames, and three stops of their maps."""
    head, pairs = load_head(EXAMPLES / "head"), load_embeddings(EXAMPLES / "simulated.safetensors")
    frames = read_frames(EXAMPLES / "frames.bin")
    return head, pairs, frames, list(map_stops(head, pairs, frames, most=3))


def rows_of(pairs, *index):
    """Return the embeddings of some pairs."""
    return tuple(
        torch.from_numpy(np.array(rows[list(index)], np.float32)) for rows in (pairs.vis, pairs.tac)
    )


def strangers(pairs):
    """Return two pairs that are not of the set: mixtures of some that are."""
    return tuple((rows[:2] + rows[2:]) / 2 for rows in rows_of(pairs, 3, 700, 1200, 1900))


@torch.no_grad()
def test_images_and_nodes_lie_where_the_map_places_them_at_every_stop(shipped):
    head, pairs, frames, stops = shipped
    vis, tac = strangers(pairs)
    found = journey(head, stops, vis, tac)
    assert found.orders == (0.0, 0.5, 1.0) and found.exact == {"umap": False, "pca": True}
    whole = rows_of(pairs, *range(len(pairs)))
    for at, (stop, order) in enumerate(zip(found.stops, found.orders, strict=True)):
        out = head.model(vis, tac, order=order, nodes=True)
        rows = unit(torch.cat(list(head.model(*whole, order=order).f_hat.values())))
        tree = out.f_bar["vis"] + out.f_bar["tac"]
        stars = unit(tree[:, None] / 2 + out.nodes)
        for method in ("umap", "pca"):
            drawn = frames.maps[f"{method}/f_hat"]
            flat = torch.from_numpy(drawn.places(drawn.orders.index(stop))).to(rows.dtype)
            known = affine(rows.double(), flat.double())
            for name, of in out.f_hat.items():
                wanted = placed_by(known, unit(of), rows, flat)
                assert (found.places[method][name][at] - wanted).abs().max() < 1e-3
            wanted = placed_by(known, stars.flatten(0, 1), rows, flat).unflatten(0, (2, 7))
            assert (found.nodes[method][at] - wanted).abs().max() < 1e-3
        torch.testing.assert_close(found.readings["fused"][at], out.probabilities)
        torch.testing.assert_close(
            found.node_probabilities[at], head.model.classify(out.nodes).softmax(-1)
        )


def test_a_pair_of_the_set_keeps_its_own_points_at_every_stop(shipped):
    head, pairs, frames, stops = shipped
    index = [*range(0, len(pairs), 240)]
    for pair in index:  # alone, as a visitor's is: rounded otherwise than within the whole set
        found = journey(head, stops, *rows_of(pairs, pair))
        for at, stop in enumerate(found.stops):
            drawn = frames.maps["umap/f_hat"]
            own = torch.from_numpy(drawn.places(drawn.orders.index(stop)))[
                [pair, pair + len(pairs)]
            ]
            got = torch.cat([found.places["umap"][name][at] for name in ("vis", "tac")])
            torch.testing.assert_close(got, own)


def test_a_pair_does_not_depend_on_its_batch_and_one_image_alone_has_no_other(shipped):
    head, pairs, _, stops = shipped
    vis, tac = strangers(pairs)
    both, one = journey(head, stops, vis, tac), journey(head, stops, vis[1:], tac[1:])
    for method in ("umap", "pca"):
        torch.testing.assert_close(both.nodes[method][:, 1:], one.nodes[method], atol=1e-4, rtol=0)
    touch = journey(head, stops, None, tac)
    assert set(touch.places["pca"]) == {"tac"} and set(touch.readings) == {"fused", "tac"}
    assert touch.nodes["pca"].shape == (3, 2, 7, 2)


def test_frames_of_other_pairs_or_without_a_map_of_the_output_are_refused(shipped):
    head, pairs, frames, _ = shipped
    with pytest.raises(DataError, match="frames are of 2160 pairs and the embeddings of 50"):
        next(map_stops(head, pairs.sampled(50), frames))
    raw = replace(frames, maps={"pca/raw": frames.maps["pca/raw"]})
    with pytest.raises(DataError, match="no map of f_hat by umap or pca"):
        next(map_stops(head, pairs, raw))
