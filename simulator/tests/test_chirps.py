"""Chirps: the class shows at p* only, and a picture of a signal gives the signal back."""

import io

import numpy as np
import pytest
import torch
from PIL import Image

from omnivat.data.readers import read_pairs
from omnivat.data.store import load_embeddings
from omnivat.data.strips import STRIPES, strip_picture, strip_signal
from omnivat.encoders import load_encoder
from omnivat.encoders.embed import embed_pairs
from omnivat.fractional import dfrft
from omnivat.kit.errors import SettingsError, ShapeError
from simulator.chirps import DOMAINS, ChirpSettings, interference_orders, places, signals
from simulator.tests.chirp_sets import chirp_embeddings

SMALL = ChirpSettings(pairs_per_class=4)


def nearest_place(settings, rows, order):
    """Return the class whose place has the largest magnitude at an order."""
    seen = dfrft(torch.from_numpy(rows).double(), order).abs().numpy()
    return seen[:, places(settings)].argmax(1)


@pytest.mark.parametrize("order", [0.0, 0.35])
def test_the_class_can_be_read_at_p_star_and_not_elsewhere(order):
    settings = ChirpSettings(order=order, pairs_per_class=40)
    made = chirp_embeddings(settings)
    for rows in (made.vis, made.tac):
        right = (nearest_place(settings, rows, order) == made.label).mean()
        away = (nearest_place(settings, rows, (order + 0.5) % 1) == made.label).mean()
        assert right > 0.9
        assert away < 0.45


@pytest.mark.parametrize("order", [0.0, 0.35, 0.77])
def test_no_interference_lies_near_p_star_and_no_two_share_an_order(order):
    found = interference_orders(ChirpSettings(order=order))
    assert np.abs(found - order).min() >= 0.25 - 1e-9
    assert found.min() >= 0 and found.max() <= 1
    assert np.diff(np.sort(found, axis=None)).min() > 0.02


def test_without_shift_every_domain_has_the_interference_of_the_first():
    found = interference_orders(ChirpSettings(shift=0.0))
    assert (found == found[0]).all()
    halfway = interference_orders(ChirpSettings(shift=0.5))
    whole = interference_orders(ChirpSettings(shift=1.0))
    np.testing.assert_allclose(halfway, (whole + whole[0]) / 2)


def test_the_same_seed_gives_the_same_signals_and_another_seed_others():
    first, again, other = (
        signals(ChirpSettings(pairs_per_class=4, seed=seed))["vis"] for seed in (0, 0, 1)
    )
    np.testing.assert_array_equal(first, again)
    assert np.abs(first - other).max() > 0.1


@pytest.mark.parametrize(
    ("kind", "side", "allowed"), [("PNG", 256, 0.005), ("PNG", 224, 0.2), ("JPEG", 640, 0.05)]
)
def test_a_picture_of_a_signal_gives_the_signal_back(kind, side, allowed):
    signal = signals(SMALL)["tac"][3]
    file = io.BytesIO()
    strip_picture(signal).resize((side, side), Image.Resampling.BICUBIC).save(file, kind)
    back = strip_signal(Image.open(file))
    assert np.abs(back - signal).max() < allowed
    cosine = back @ signal / np.linalg.norm(back) / np.linalg.norm(signal)
    assert cosine > 0.995


def test_a_strip_of_another_length_is_refused():
    with pytest.raises(ShapeError, match=r"A strip shows 64 values, got shape \(32,\)"):
        strip_picture(np.zeros(32))


def test_the_encoder_reads_a_mirrored_picture_backwards():
    encoder = load_encoder("strip")
    signal = signals(SMALL)["vis"][0]
    seen = encoder.preprocess(strip_picture(signal))
    plain, mirrored = encoder.embed(torch.stack([seen, seen.flip(-1)]))
    torch.testing.assert_close(plain, mirrored.flip(-1))
    assert encoder.width == STRIPES


def test_the_encoder_refuses_weights_and_other_precisions(tmp_path):
    with pytest.raises(SettingsError, match="takes no weights"):
        load_encoder("strip", weights=tmp_path / "some.pt")
    with pytest.raises(SettingsError, match="takes no precision"):
        load_encoder("strip", precision="bf16")


def test_a_written_set_is_read_and_embedded_as_its_signals(tmp_path, run):
    said = run("chirps", "--out", tmp_path / "set", "--order", "0.6", "--pairs-per-class", "2")
    assert "40 pairs from made-up chirps" in said.out
    found = read_pairs(tmp_path / "set")
    assert found.simulated and {pair.split for pair in found.pairs} == {"train", "test"}
    embed_pairs(found, "strip", tmp_path / "set.safetensors", flips=False)
    read = load_embeddings(tmp_path / "set.safetensors")
    made = chirp_embeddings(ChirpSettings(order=0.6, pairs_per_class=2))
    assert read.header.domains == DOMAINS
    by_file = {name: row for row, name in enumerate(made.rows["tac"])}
    for row, name in enumerate(read.rows["tac"]):
        own = by_file["/".join(name.split("/")[-3:])]
        np.testing.assert_allclose(read.tac[row], made.tac[own], atol=0.005)


@pytest.mark.slow
def test_the_exported_reader_has_the_signal_of_a_picture_of_any_size(tmp_path):
    runtime = pytest.importorskip("onnxruntime", reason="the extra [onnx] is not installed")
    load_encoder("strip").write_onnx(tmp_path / "strip.onnx")
    session = runtime.InferenceSession(tmp_path / "strip.onnx", providers=["CPUExecutionProvider"])
    random = np.random.default_rng(0)
    for width, height in ((256, 256), (301, 257), (64, 1), (40, 30), (1000, 9)):
        picture = random.integers(0, 256, (height, width, 3), dtype=np.uint8)
        (found,) = session.run(None, {"picture": picture[None]})
        wanted = strip_signal(Image.fromarray(picture))
        np.testing.assert_allclose(found[0], wanted, atol=1e-6)
