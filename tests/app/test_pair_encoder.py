"""A head with separate encoders for photos and touches: an uploaded image has a vector for each."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from PIL import Image

from app.shared.state import ref_from


def test_a_sent_image_is_read_by_the_encoder_of_the_modality_it_is_used_for(
    resources, encoder, png, monkeypatch
):
    from omnivat.encoders.base import PairEncoder

    class Doubled(type(encoder)):
        def embed(self, images):
            return 2 * super().embed(images)

    pair = PairEncoder(encoder, Doubled())
    monkeypatch.setattr(resources, "encoder", lambda: pair)
    ref, _ = resources.take_image(png(), "a.png")
    seen, felt = (resources.embedding(ref, name) for name in ("vis", "tac"))
    assert seen.shape == felt.shape == (encoder.width,)
    assert seen.any() and np.array_equal(felt, 2 * seen)


@pytest.mark.parametrize(
    ("picture", "mend", "passes"), [("plain", "", 1), ("plain", "fill", 1), ("dots", "", 2)]
)
def test_a_picture_without_dots_is_embedded_once_and_every_vector_is_the_encoders_own(
    resources, encoder, monkeypatch, picture, mend, passes
):
    from app.shared.decoder import Picture
    from app.shared.mend import mended
    from omnivat.encoders.base import DotsFilled
    from tests.unit.data.odd_pictures import gel, printed
    from tests.unit.data.odd_pictures import picture as of

    filled = DotsFilled(encoder)
    monkeypatch.setattr(resources, "encoder", lambda: filled)
    shown = Image.fromarray(of(gel() * (1 - printed()[..., None] * (picture == "dots"))))
    expected = {
        "vis": encoder.embed(encoder.preprocess(shown)[None])[0],
        "tac": filled.tac.embed(filled.tac.preprocess(mended(shown, mend))[None])[0],
    }
    runs = []
    embed = type(encoder).embed
    monkeypatch.setattr(type(encoder), "embed", lambda *a: runs.append(1) or embed(*a))
    found = resources._embedded(Picture(image=shown, width=1, height=1), mend)
    assert len(runs) == len(found) == passes
    assert np.array_equal(found[0], expected["vis"]) and np.array_equal(found[-1], expected["tac"])


@pytest.mark.parametrize("touch", ["relief", "both"])
def test_an_own_touch_is_read_by_the_lamps_of_the_profile_and_the_reply_says_so(
    resources, encoder, monkeypatch, touch
):
    from app.pair.pictures import taken
    from app.pair.sensor import _kept
    from app.pair.tab import touch_words
    from omnivat import lamps
    from omnivat.encoders.base import ReliefDrawn
    from omnivat.head.heads import EXAMPLES

    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))
    gel = lamps([np.asarray(Image.open(file).convert("RGB")) for file in files[1:]])
    relief, head = ReliefDrawn(encoder, {}, touch), resources.head()
    wide = SimpleNamespace(
        settings=replace(head.settings, input_width=relief.width),
        encoder={**head.encoder, "preprocessing": relief.preprocessing},
    )
    named = {}
    for name, held in (("lit", gel), ("unlit", None)):
        reply = _kept(resources, replace(head.source_profile, lamps=held))
        named[name] = {"profile": reply["profile"]}
        assert not reply["lit"]  # of a head that reads colours
    monkeypatch.setattr(resources, "encoder", lambda: relief)
    monkeypatch.setattr(resources, "head", lambda: wide)
    assert _kept(resources, replace(head.source_profile, lamps=gel))["lit"]
    plain, unlit, lit = (
        taken(resources, files[0], question)["ref"]
        for question in ({}, named["unlit"], named["lit"])
    )
    wanted = ReliefDrawn(encoder, {"own": gel}, touch).of["own"]
    shown = wanted.embed(wanted.preprocess(Image.open(files[0]).convert("RGB"))[None])[0].numpy()
    assert plain == unlit != lit
    assert np.array_equal(resources.embedding(ref_from(lit), "tac"), shown)
    assert "by the lamps that each touch gives alone" in touch_words(resources, {"tac": plain})
    words = touch_words(resources, {"tac": lit, **named["lit"]})
    assert f"lamps from {len(files) - 1} touches of your profile" in words
    assert touch_words(resources, {"tac": "row:1", **named["lit"]}) == ""


def test_a_profile_made_for_a_head_of_relief_is_of_touches_under_the_lamps_that_they_give(
    resources, encoder, monkeypatch
):
    from app.pair.pictures import with_pictures
    from app.pair.sensor import profile
    from app.shared.requests import FILES
    from omnivat.encoders.base import ReliefDrawn
    from omnivat.head.heads import EXAMPLES

    relief, head = ReliefDrawn(encoder, {}, "relief"), resources.head()
    lit = SimpleNamespace(
        settings=head.settings,
        source_profile=head.source_profile,
        encoder={**head.encoder, "preprocessing": relief.preprocessing},
    )
    monkeypatch.setattr(resources, "encoder", lambda: relief)
    monkeypatch.setattr(resources, "head", lambda: lit)
    files = sorted((EXAMPLES / "pairs" / "TAG-sim").glob("*/*_tac.jpg"))[:6]
    question = {"touches": [f"file:{k}" for k in range(6)], FILES: [f.read_bytes() for f in files]}
    made = resources.profiles.get(with_pictures(profile, resources, question)["profile"])
    rows = [
        resources.embedding(resources.take_image(f, "", "", made.lamps)[0], "tac") for f in files
    ]
    assert set(made.channels) == {"tac"}
    np.testing.assert_allclose(made.channels["tac"].mean, np.mean(rows, 0), rtol=1e-5, atol=1e-6)
