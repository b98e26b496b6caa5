"""A head with separate encoders for photos and touches: an uploaded image has a vector for each."""

import numpy as np


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


def test_a_head_of_relief_reads_touches_as_relief_and_photos_as_they_are(
    resources, encoder, png, monkeypatch
):
    from omnivat.encoders.base import ReliefDrawn

    relief = ReliefDrawn(encoder, {})
    monkeypatch.setattr(resources, "encoder", lambda: relief)
    ref, found = resources.take_image(png(96), "a.png")
    seen, felt = (resources.embedding(ref, name) for name in ("vis", "tac"))
    plain = encoder.embed(encoder.preprocess(found.image)[None])[0].numpy()
    assert np.array_equal(seen, plain) and not np.array_equal(felt, plain)
