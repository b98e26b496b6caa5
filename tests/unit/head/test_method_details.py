"""Details that the paper leaves open: θ_e at the start, the LANG guide, the bank, MMA's pairs."""

from dataclasses import replace

import numpy as np
import pytest
import torch

from omnivat.encoders.lang.bank import load_bank
from omnivat.head.losses import joint_loss, mma_loss
from omnivat.head.output import TrainingOutput
from omnivat.head.settings import HeadSettings
from omnivat.kit.errors import DataError
from omnivat.training import TrainSettings, train
from omnivat.training.guard import guided_probabilities, lang_guard


def trained(source, lang=True, epochs=2, training=None, **head):
    bank = load_bank().for_classes(source.header.classes) if lang else None
    settings = HeadSettings(
        **{
            "classes": source.header.classes,
            "input_width": source.width,
            "lang_width": bank.width if bank else 1,
            "width": 16,
            **head,
        }
    )
    given = TrainSettings(epochs=epochs, lang=lang, **(training or {}))
    return train(source, settings, given, bank=bank).model


@pytest.fixture(scope="module")
def source(make_embeddings):
    return make_embeddings(domains=("TAG-sim",), per_class=6)


@torch.no_grad()
def predicted(model, source):
    return model(torch.from_numpy(source.vis), torch.from_numpy(source.tac)).readings["fused"]


def test_four_tokens_are_not_four_copies_of_one(source):
    """With θ_e = ones E = 4 is E = 1; the default start breaks the symmetry."""
    for init, differs in (("ones", False), ("spread", True)):
        one, four = (trained(source, expansion=e, theta_init=init) for e in (1, 4))
        apart = (predicted(one, source) - predicted(four, source)).abs().max()
        assert bool(apart > 1e-3) is differs
        assert (four.mffa.theta["vis"].detach().std() > 1e-3) == differs


def test_the_default_start_of_theta_is_spread_around_one(make_head):
    assert HeadSettings(classes=("a", "b"), input_width=4).theta_init == "spread"
    theta = make_head(theta="spread").mffa.theta["vis"].detach()
    torch.testing.assert_close(theta.float(), torch.tensor([0.5, 5 / 6, 7 / 6, 1.5]))
    assert make_head(theta="spread", expansion=1).mffa.theta["vis"].tolist() == [1.0]


def test_mma_acts_on_the_chosen_pairs_alone():
    features = {n: torch.randn(4, 6, dtype=torch.float64) for n in ("lang", "vis", "tac")}
    some, labels = torch.tensor([True, False, True, False]), torch.zeros(4, dtype=torch.long)
    root = [torch.zeros(4, 1, 6, dtype=torch.float64)]
    logits = {"vis": torch.zeros(4, 3)}
    output = TrainingOutput(features=features, layers=root, logits=logits, tokens={})
    wanted = mma_loss(**{n: x[some] for n, x in features.items()})
    torch.testing.assert_close(joint_loss(output, labels, aligned=some).mma, wanted)


def bank_distance(source, kind):
    """Return how far the bank's mean lies from the mean token of unguided pairs, relatively."""
    model = trained(source, epochs=30, training={"bank_from": kind})
    with torch.no_grad():
        given = {"vis": torch.from_numpy(source.vis), "tac": torch.from_numpy(source.tac)}
        own = model.mffa.expand(
            ("vis", "tac"), model.mffa.parts(("vis", "tac"), model.embedded(given))
        )
        mean = model.mffa.mean_tokens(own).mean(1)
        found = model.mffa.class_agnostic_tokens(("vis", "tac"))
    return float((found - mean).norm() / mean.norm())


def test_a_bank_of_unguided_pairs_lies_near_what_prediction_sees(source):
    assert bank_distance(source, "unguided") < 0.6 * bank_distance(source, "all")


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


def test_text_of_another_class_changes_a_guided_prediction(source):
    model, bank = trained(source), load_bank().for_classes(source.header.classes)
    labels = torch.from_numpy(source.label)
    own, other = (
        guided_probabilities(model, source, torch.from_numpy(bank.embeddings[rows, 0]), labels)
        for rows in (source.label, (source.label + 1) % 5)
    )
    assert not torch.allclose(own, other, atol=1e-3)


def test_a_guard_without_pairs_is_refused(source):
    bank = load_bank().for_classes(source.header.classes)
    with pytest.raises(DataError, match="needs pairs of the head's classes"):
        lang_guard(trained(source), source.select(source.label < 0), bank, seed=0)
