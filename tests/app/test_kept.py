"""What is saved loads again and is the same, with names in several scripts: over the library and
the server.
"""

import json
from dataclasses import replace
from io import BytesIO
from zipfile import ZipFile

import numpy as np
import pytest
import torch

from app.shared.resources import Resources
from omnivat import load_embeddings, load_head, load_profile, save_embeddings, save_profile
from omnivat.data.profile import profile_of
from omnivat.data.relief import Lamps
from omnivat.head.checkpoint import Head, save_head
from omnivat.head.head import OmniVaT
from tests.builders import head_settings

from .conftest import loaded, served

DOMAINS = ("مستشعر أ", "触覚センサー 1")
CLASSES = ("خشب", "木", "cafe\u0301", "🪵🏽", "кость", 'a|b, "c"; d/e\'')
LAMPS = Lamps(
    colours=np.array([[0.1, -2], [1 / 3, 0], [5, 1e-9]]),
    background=np.arange(8 * 9 * 3, dtype=np.uint8).reshape(8, 9, 3),
    ratio=0.1,
    confidence=0.9,
    pictures=12,
    steepness=1 / 7,
)


@pytest.fixture(scope="module")
def kept(make_embeddings, tmp_path_factory):
    """Return a folder with a set and a head, and both as they were before they were saved."""
    folder = tmp_path_factory.mktemp("kept") / "مجلد 木 🪵 e\u0301"
    some = make_embeddings(domains=DOMAINS, classes=CLASSES, per_class=4)
    lit = {DOMAINS[0]: LAMPS, DOMAINS[1]: "لا صور"}
    some = replace(some, header=replace(some.header, lamps=lit, origin="自作 🪵"))
    folder.mkdir()
    save_embeddings(folder / "触.safetensors", some)
    profile = profile_of(some, some.rows_of(DOMAINS[1]), domain=DOMAINS[1])
    head = Head(
        model=OmniVaT(head_settings(some)).eval(),
        encoder=dict(zip(("name", "weights_hash", "preprocessing"), some.header.key, strict=True)),
        provenance={"source": DOMAINS[0], "note": CLASSES},
        profile=replace(profile, lamps=LAMPS, step=1 / 3),
    )
    save_head(folder / "رأس", head)
    return folder, some, head


def scores(head, some):
    with torch.no_grad():
        vis, tac = (torch.from_numpy(np.array(rows)) for rows in (some.vis, some.tac))
        return head.model(vis, tac).probabilities


def same_profile(one, other):
    for name, own in one.channels.items():
        assert (own.mean == other.channels[name].mean).all()
        assert (own.variance == other.channels[name].variance).all()
    same_lamps(one.lamps, other.lamps)
    assert (one.domain, one.key, one.step, one.counts) == (
        other.domain,
        other.key,
        other.step,
        other.counts,
    )


def same_lamps(one, other):
    assert (one.colours == other.colours).all() and (one.background == other.background).all()
    bare = [replace(lamps, colours=LAMPS.colours, background=None) for lamps in (one, other)]
    assert bare[0] == bare[1]


def test_the_library_keeps_every_name_and_number(kept):
    folder, some, head = kept
    back = load_embeddings(folder / "触.safetensors")
    assert replace(back.header, lamps={}) == replace(some.header, lamps={})
    assert back.header.lamps[DOMAINS[1]] == "لا صور" and back.rows == some.rows
    same_lamps(back.header.lamps[DOMAINS[0]], LAMPS)
    for name, rows in some.vectors.items():
        assert np.abs(back.vectors[name] - rows).max() == 0
    again = load_head(folder / "رأس")
    assert (scores(again, some) - scores(head, some)).abs().max() == 0
    assert again.settings == head.settings and again.provenance["note"] == list(CLASSES)
    same_profile(again.profile, head.profile)


def test_the_server_returns_what_it_was_sent(kept, small_places, monkeypatch, encoder):
    folder, some, head = kept
    monkeypatch.setattr("omnivat.encoders.base.load_encoder", lambda name, **_: encoder)
    with served(Resources(small_places)) as client:
        files = {file.name: file for file in (folder / "رأس").iterdir()}
        files["embeddings.safetensors"] = folder / "触.safetensors"
        own = loaded(client, files).json()["set"]
        about = client.get(f"/omnivat/about?set={own}").text
        assert all(json.dumps(name)[1:-1] in about or name in about for name in DOMAINS)
        read = client.get(f"/omnivat/head.zip?set={own}").content
        same = scores(head_in(read, folder.parent / "downloaded"), some)
        assert (same - scores(head, some)).abs().max() == 0
        lessons = [{"vis": "row:1", "tac": "row:1", "label": CLASSES[3]}]
        zipped = client.post(f"/omnivat/save/set?set={own}", json={"lessons": lessons}).content
        (folder.parent / "mine").mkdir()
        ZipFile(BytesIO(zipped)).extractall(folder.parent / "mine")
        (file,) = (folder.parent / "mine").rglob("*.safetensors")
        mine = load_embeddings(file)
        assert {*mine.header.classes} == {CLASSES[3]}
        assert (mine.vis == some.vis[[1]]).all()
        save_profile(folder.parent / "p", head.profile)
        sent = (folder.parent / "p").read_bytes()
        name = client.post(f"/omnivat/sensor?set={own}", content=sent).json()["profile"]
        saved = client.post(f"/omnivat/save/sensor?set={own}", json={"profile": name}).content
        (folder.parent / "q").write_bytes(saved)
        same_profile(load_profile(folder.parent / "q"), head.profile)


def head_in(content, folder):
    folder.mkdir()
    ZipFile(BytesIO(content)).extractall(folder)
    return load_head(next(folder.rglob("settings.json")).parent)
