"""Every frame equals the library's result within the u16 error; impossible settings are refused."""

import numpy as np
import pytest
import torch

from omnivat.kit.errors import DataError, SettingsError
from omnivat.maps.frames import build_frames, read_frames, write_frames
from omnivat.maps.frames.builder import spread
from omnivat.maps.frames.records import LEVELS, quantised
from omnivat.maps.projection import pca, torch_umap
from omnivat.maps.projection.torch_umap import aligned
from omnivat.maps.sweep import sweep
from omnivat.measure.gaps.unit import unit

from .small_head import ORDERS, head, pairs


@torch.no_grad()
def features(stage):
    """Unit rows of a stage at every order, through the head's public functions."""
    data, model = pairs(), head()
    for order in ORDERS:
        out = model(torch.from_numpy(data.vis), torch.from_numpy(data.tac), order=order)
        rows = {name: x.movedim(-2, 0) for name, x in getattr(out, stage).items()}
        yield torch.cat([unit(rows["vis"].flatten(1)), unit(rows["tac"].flatten(1))])


def allowed(maps):
    """Half a step of the grid, and the rounding of single precision."""
    return (maps.high[0] - maps.low[0]) / LEVELS / 2 + 1e-5


@pytest.mark.parametrize("stage", ["relu", "f_hat"])
def test_every_pca_frame_is_that_order_s_own_pca_within_the_u16_error(frames, stage):
    found = frames.maps[f"pca/{stage}"]
    assert found.orders == (0, 1, 2, 3, 4)
    before = None
    for stop, points in enumerate(features(stage)):
        flat = pca.project(points)
        flat = flat if before is None else aligned(flat, before)
        assert np.abs(found.places(stop) - flat.numpy()).max() <= allowed(found)
        before = flat


def test_every_umap_frame_is_the_map_that_follows_the_one_before_within_the_u16_error(frames):
    found = frames.maps["umap/f_hat"]
    assert found.orders == (0, 2, 4)
    chosen = [points for stop, points in enumerate(features("f_hat")) if stop in found.orders]
    flat = None
    for place, points in enumerate(chosen):
        flat = torch_umap.project(points, start=flat)
        span = found.high[0] - found.low[0]
        assert np.abs(found.places(place) - flat.numpy()).max() <= span / LEVELS / 2 + 1e-3


def test_the_raw_map_stands_for_every_stop_and_for_the_raw_transform(frames):
    raw, turned = frames.maps["pca/raw"], frames.maps["pca/frft"]
    assert raw.orders == (0,)
    assert raw.points is turned.points
    assert frames.curves["modality_gap/frft"] == frames.curves["modality_gap/raw"]
    wanted = pca.project(next(features("frft")))
    np.testing.assert_allclose(
        np.abs(turned.places(0) - turned.places(0).mean(0)), wanted.abs(), atol=1e-4
    )


def test_predictions_and_curves_are_those_of_the_sweep(frames):
    found = sweep(head(), pairs(), ORDERS, stages=("relu", "f_hat"))
    np.testing.assert_array_equal(frames.prediction, found.probabilities.argmax(2))
    np.testing.assert_allclose(
        frames.confidence / 255, found.probabilities.max(2), atol=0.5 / 255 + 1e-6
    )
    for name, curve in found.curves.items():
        np.testing.assert_allclose(frames.curves[name], curve, atol=1e-6)
    np.testing.assert_array_equal(frames.label, found.label)


def test_maps_that_are_not_asked_for_are_not_made(monkeypatch):
    monkeypatch.setattr(torch_umap, "project", None)
    found = build_frames(head(), pairs(), orders=ORDERS, maps={"pca/f_hat": 2})
    assert set(found.maps) == {"pca/f_hat"}
    assert {name.split("/")[1] for name in found.curves if name.startswith("margin")} == {"f_hat"}


def test_an_order_for_each_modality_moves_the_transform_too(monkeypatch):
    """The gap is that of the photo's own features at p and the touch's own at p / 2."""
    model, data = head(), pairs()
    vis, tac = torch.from_numpy(data.vis), torch.from_numpy(data.tac)

    def mean(name, order):
        with torch.no_grad():
            rows = model(vis, tac, order=order).frft[name].movedim(-2, 0).flatten(1)
        return unit(rows).mean(0)

    wanted = [float((mean("vis", p) - mean("tac", p / 2)).norm()) for p in ORDERS]
    plain = model.from_coefficients

    def lagging(kept, order=None, **options):
        share = [1.0 if name == "vis" else 0.5 for name in kept.names]
        return plain(kept, order * torch.tensor(share, dtype=torch.float64)[:, None], **options)

    monkeypatch.setattr(model, "from_coefficients", lagging)
    found = build_frames(model, data, orders=ORDERS, still=("raw",))
    np.testing.assert_allclose(found.curves["modality_gap/frft"], wanted, atol=1e-5)
    assert len(found.maps["pca/frft"].orders) == len(ORDERS)
    assert found.maps["pca/raw"].orders == (0,)


def test_quantising_is_exact_to_half_a_step_and_says_so():
    maps = [np.random.default_rng(seed).normal(size=(50, 2)) * (1, 40) for seed in range(3)]
    found = quantised(maps, (0, 1, 2), (None,) * 3)
    errors = [np.abs(found.places(k) - maps[k]).max() for k in range(3)]
    assert max(errors) == pytest.approx(found.max_error)
    assert found.max_error <= (found.high[1] - found.low[1]) / LEVELS / 2 * 1.000001
    assert found.high[0] - found.low[0] == pytest.approx(found.high[1] - found.low[1])


@pytest.mark.parametrize(
    ("stops", "count", "places"),
    [(1, 101, (0,)), (5, 3, (0, 1, 2)), (21, 101, tuple(range(0, 101, 5)))],
)
def test_stops_are_spread_evenly(stops, count, places):
    assert spread(stops, count) == places


@pytest.mark.parametrize(
    ("wrong", "error", "sentence"),
    [
        ({"orders": (0.5, 0.5)}, SettingsError, "each above the one before"),
        ({"maps": {"pca/none": 3}}, SettingsError, "No map is called 'pca/none'"),
        ({"maps": {"pca/f_hat": 0}}, SettingsError, "with 0 stops"),
        ({"embeddings": pairs(classes=[*map(str, range(300))])}, DataError, "256 domains and cl"),
        ({"embeddings": pairs(count=0)}, DataError, "no pairs in these embeddings"),
    ],
)
def test_frames_that_cannot_be_are_refused(wrong, error, sentence):
    with pytest.raises(error, match=sentence):
        build_frames(**{"model": head(), "embeddings": pairs(), "orders": (0.0,), **wrong})


def test_a_value_that_does_not_exist_is_none_here_and_in_the_file(tmp_path):
    alone = pairs().in_domain("D0")
    made = build_frames(head(), alone, orders=(0.0, 1.0), maps={"pca/raw": 1, "pca/relu": 2})
    write_frames(tmp_path / "frames.bin", made)
    for curves in (made.curves, read_frames(tmp_path / "frames.bin").curves):
        assert curves["domain_gap/raw"] == curves["domain_gap/relu"] == [None, None]
        assert None not in curves["modality_gap/relu"]
