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
