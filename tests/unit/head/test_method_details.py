"""Details that the paper leaves open: θ_e at the start, the LANG guide, the bank, MMA's pairs."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.encoders.lang.bank import load_bank
from omnivat.head.predict_set import predicted_probabilities
from omnivat.kit.errors import DataError
from omnivat.measure.guard import lang_guard
from omnivat.training import TrainSettings, train
from tests.builders import head_settings


def trained(source, epochs=2, training=None, width=16, **head):
    settings = head_settings(source, width=width, **head)
    given = TrainSettings(epochs=epochs, **(training or {}))
    return train(source, settings, given, bank=load_bank()).model


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=6)


def test_the_bank_moves_a_tenth_of_the_way_to_a_batch_and_keeps_absent_classes(make_head):
    mffa = make_head().mffa
    mffa.bank_seen.fill_(False)
    before, tokens = mffa.bank.clone(), torch.randn(2, 3, 16, dtype=torch.float64)
    for one in tokens:
        mffa.update_bank({"vis": one}, torch.tensor([0, 0, 3]))
    first, then = (torch.stack((one[:2].mean(0), one[2])) for one in tokens)
    before[1, [0, 3]] = 0.9 * first + 0.1 * then
    torch.testing.assert_close(mffa.bank, before)
    assert mffa.bank_seen.tolist() == [True, False, False, True, False]


def test_the_guard_finds_a_head_that_reads_the_label_off_the_text(source):
    """Always guided, a head of noise is right with text and guesses without."""
    random = np.random.default_rng(0)
    noise = {n: random.normal(size=source.vis.shape).astype(np.float32) for n in ("vis", "tac")}
    blind = replace(source, vis_flip=None, tac_flip=None, **noise)
    fresh = replace(blind, **{n: x[::-1].copy() for n, x in noise.items()})
    bank = load_bank().for_classes(source.header.classes)
    model = trained(blind, epochs=60, training={"lang_drop": 0.0}, width=64, class_token=False)
    leaning = lang_guard(model, fresh, bank, seed=0)
    assert leaning["gap"] > 0.3
    assert leaning["gap"] == pytest.approx(leaning["with"] - leaning["without"])
    said = predicted_probabilities(model, fresh)["fused"].argmax(-1).numpy()
    assert leaning["without"] == pytest.approx((said == fresh.label).mean())


def test_a_guard_without_pairs_is_refused(source):
    bank = load_bank().for_classes(source.header.classes)
    with pytest.raises(DataError, match="needs pairs of the head's classes"):
        lang_guard(trained(source), source.select(source.label < 0), bank, seed=0)
