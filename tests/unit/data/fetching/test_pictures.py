"""Pictures made of other files: height maps in pickles, moments of clips, parts of stills."""

import io
import os
import pickle

import numpy as np
import pytest
from PIL import Image

from omnivat.data.fetching import _write_picture, heights
from omnivat.data.fetching.heights import drawn, load_heights
from omnivat.kit.errors import DataError
from omnivat.kit.limited import Limited
from omnivat.kit.pickles import LIMITS
from tests.unit.data.films import film


@pytest.mark.parametrize(("protocol", "kind"), [(0, "<f8"), (2, ">f4"), (4, "u2"), (5, "<f8")])
def test_an_array_of_numbers_is_read_from_every_protocol(protocol, kind):
    values = np.arange(80).reshape(8, 10).astype(kind)
    for one in (values, np.asfortranarray(values), values[..., None]):
        np.testing.assert_array_equal(load_heights(pickle.dumps(one, protocol), "x.pkl"), values)


class Runs:
    def __reduce__(self):
        return os.system, ("touch ran",)


def called(name, arguments):
    """Return a pickle that calls a function with arguments, each in the text of protocol 0."""
    return f"c{name}\n({arguments}R.".encode("latin1")


HOSTILE = {
    "a call": pickle.dumps(Runs()),
    "a call inside an array": pickle.dumps(np.array([Runs()], dtype=object)),
    "a name without a call": pickle.dumps(os.system),
    "an array of objects": pickle.dumps(np.full((9, 9), None)),
    "one axis": pickle.dumps(np.zeros(100)),
    "a complex array": pickle.dumps(np.zeros((9, 9), complex)),
    "too short": pickle.dumps(np.zeros((9, 9)))[:-40],
    "not finite": pickle.dumps(np.full((9, 9), np.nan)),
    "an array whose bytes are addresses": called(
        "numpy\nndarray", "(I9\nI9\ntV|O8\nc_codecs\nencode\n(V\\u0000\nVlatin1\ntRt"
    ),
    "one number for 400 million": called(
        "numpy\nndarray", "(I20000\nI20000\ntVf8\nVa\nI0\n(I0\nI0\ntt"
    ),
    "an array without values": called("numpy\nndarray", "(I64\nI64\ntt"),
    "a word that takes minutes": called("_codecs\nencode", f"V{'é' * 180_000}\nVpunycode\nt"),
    "words of doubled length": b"c_codecs\nencode\n(" * 30 + b"Va\n" + b"Vhex\ntR" * 30 + b".",
    "an index of four billion": b"\x80\x02I1\nr\xff\xff\xff\x7f.",
    "nested pairs as a key": b"\x80\x02}" + b"I1\n" + b"2\x86" * 60 + b"I1\ns.",
}


@pytest.fixture(scope="module")
def hasty():
    """A reader whose second is over before a hostile pickle is."""
    limited = Limited("omnivat.kit.pickles:array", **{**LIMITS, "seconds": 1})
    yield limited
    limited.close()


@pytest.mark.parametrize("content", HOSTILE.values(), ids=HOSTILE.keys())
def test_any_other_pickle_is_refused_and_runs_nothing(content, tmp_path, monkeypatch, hasty):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(heights, "read_array", hasty)
    with pytest.raises(DataError, match=r"'x\.pkl'"):
        load_heights(content, "x.pkl")
    assert not list(tmp_path.iterdir())


def test_a_slope_is_bright_in_the_lamp_that_it_faces():
    ramp = np.tile(np.arange(32, dtype=np.float32), (32, 1))  # rises to the right, so it faces left
    pixel = np.asarray(drawn(ramp))[16, 16].tolist()
    assert pixel == [128, 55, 200], "red is below, along the slope; green right, blue left"


def test_a_height_map_in_a_pickle_becomes_its_picture(tmp_path):
    _write_picture("a.pkl", pickle.dumps(np.zeros((16, 12))), None, tmp_path / "a.png")
    flat = np.asarray(Image.open(tmp_path / "a.png"))
    assert flat.shape == (16, 12, 3) and (flat == 128).all()


def test_a_clip_becomes_its_moment_of_contact(tmp_path):
    film(tmp_path / "a.mov", [220 if k == 13 else 50 + k for k in range(20)], slice(10, 20))
    content = (tmp_path / "a.mov").read_bytes()
    _write_picture("a.mov", content, None, tmp_path / "a.png")
    assert abs(int(np.asarray(Image.open(tmp_path / "a.png"))[15, 15, 0]) - 220) < 12
    assert [path.name for path in tmp_path.iterdir()] == ["a.png"]


def test_a_damaged_clip_is_one_sentence_and_leaves_nothing(tmp_path):
    pytest.importorskip("av")
    with pytest.raises(DataError, match="no video that can be read"):
        _write_picture("a.mov", b"no video", None, tmp_path / "a.png")
    assert not list(tmp_path.iterdir())


def test_a_part_of_a_still_is_cut_by_shares_of_its_sides(tmp_path):
    still = np.zeros((20, 40, 3), np.uint8)
    still[:, 20:] = 255
    content = io.BytesIO()
    Image.fromarray(still).save(content, "PNG")
    _write_picture("s.png", content.getvalue(), (0.5, 0.0, 1.0, 0.5), tmp_path / "s.png")
    part = np.asarray(Image.open(tmp_path / "s.png"))
    assert part.shape == (10, 20, 3) and (part == 255).all()
