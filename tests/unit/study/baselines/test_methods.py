"""Every baseline learns a source, repeats itself, and says when it cannot run."""

from dataclasses import replace

import pytest
import torch

from omnivat.kit.errors import DataError
from omnivat.kit.tables import load
from omnivat.study.baselines import BASELINES, LABELS, OPTIONAL, spg
from omnivat.study.baselines.contract import Source
from omnivat.study.baselines.contrastive import contrastive_loss
from omnivat.study.baselines.descent import Descent, descend, rate
from omnivat.study.baselines.robust_vish import fit as fit_robust_vish
from omnivat.study.baselines.text import PAPER

# The optional methods have a file of their own, test_contract.py.
QUICK = [n for n in BASELINES if n not in (*OPTIONAL, "promptstyler", "zero_shot")]
CLASSES = ("wood", "steel", "plastic", "ceramic", "glass")


@pytest.fixture(scope="module")
def source(make_embeddings):
    return as_source(make_embeddings(domains=("TAG-sim",), per_class=8))


def as_source(pairs, **changes):
    values = {
        "vis": torch.from_numpy(pairs.vis),
        "tac": torch.from_numpy(pairs.tac),
        "vis_flip": torch.from_numpy(pairs.vis_flip),
        "tac_flip": torch.from_numpy(pairs.tac_flip),
        "labels": torch.from_numpy(pairs.label),
        "objects": tuple(pairs.rows["object"]),
        "classes": CLASSES,
        "lang": torch.randn(5, 6, 7, generator=torch.Generator().manual_seed(0)),
    }
    return Source(**(values | changes))


def right(fitted, source):
    answers = fitted.predict(source.vis, source.tac)["fused"].argmax(-1)
    return (answers == source.labels).double().mean().item()


@pytest.fixture(scope="module")
def fitted(source):
    return {name: load(BASELINES, name, kind="baseline")(source) for name in QUICK}


@pytest.mark.parametrize("name", QUICK)
def test_it_learns_its_source_and_gives_probabilities(name, source, fitted):
    answers = fitted[name].predict(source.vis, source.tac)
    for values in answers.values():
        assert values.shape == (len(source), 5)
        torch.testing.assert_close(values.sum(-1), torch.ones(len(source)))
    assert right(fitted[name], source) > 0.9
    assert fitted[name].parameters > 0


def depends_on_the_other_image(predict, source, name):
    """True when a reading of one modality changes with the other modality's images."""
    other = "tac" if name == "vis" else "vis"
    pairs = {"vis": source.vis, "tac": source.tac}
    changed = pairs | {other: pairs[other].flip(0) * 2 + 1}
    return not torch.equal(predict(*pairs.values())[name], predict(*changed.values())[name])


@pytest.mark.parametrize("name", QUICK)
@pytest.mark.parametrize("modality", ["vis", "tac"])
def test_a_reading_of_one_modality_does_not_see_the_other_image(name, modality, source, fitted):
    assert not depends_on_the_other_image(fitted[name].predict, source, modality)


@pytest.mark.parametrize("name", QUICK)
def test_features_have_a_row_a_pair_for_each_modality_and_the_pair(name, source, fitted):
    found = fitted[name].features(source.vis, source.tac)
    assert set(found) == {"vis", "tac", "pair"}
    assert all(len(rows) == len(source) and rows.ndim == 2 for rows in found.values())


def test_a_method_of_text_names_the_true_reason_where_the_bank_lacks_the_classes(source):
    bare = replace(source, lang=None, why_no_lang="The LANG bank has no text for felt.")
    with pytest.raises(DataError, match="Zero-shot prediction needs .* no text for felt"):
        load(BASELINES, "zero_shot", kind="baseline")(bare)


@pytest.mark.parametrize("name", QUICK)
def test_a_pair_is_answered_alike_alone_and_among_others(name, source, fitted):
    every = fitted[name].predict(source.vis, source.tac)["fused"]
    alone = fitted[name].predict(source.vis[3:4], source.tac[3:4])["fused"]
    torch.testing.assert_close(alone, every[3:4], atol=1e-5, rtol=1e-4)


@pytest.mark.parametrize("name", QUICK)
def test_the_same_seed_gives_the_same_answers_and_leaves_the_global_stream(name, source, fitted):
    before = torch.random.get_rng_state()
    again = load(BASELINES, name, kind="baseline")(source)
    assert torch.equal(torch.random.get_rng_state(), before)
    first, second = (m.predict(source.vis, source.tac)["fused"] for m in (fitted[name], again))
    assert torch.equal(first, second)


def test_every_baseline_loads_and_has_a_label():
    assert set(LABELS) == set(BASELINES)
    for name in BASELINES:
        assert callable(load(BASELINES, name, kind="baseline"))


def test_robustvish_fits_a_few_steps(source):
    few = source.select(torch.arange(0, len(source), 4))
    fitted = fit_robust_vish(few, Descent(lr=1e-3, epochs=1, batch=8, method="adam"))
    answers = fitted.predict(few.vis, few.tac)["fused"]
    torch.testing.assert_close(answers.sum(-1), torch.ones(len(few)))


@pytest.mark.parametrize("name", ["promptstyler", "zero_shot"])
def test_methods_that_live_on_text_refuse_texts_of_another_encoder(name, source):
    with pytest.raises(DataError, match="needs texts in the image encoder's own space"):
        load(BASELINES, name, kind="baseline")(source)


@pytest.mark.parametrize("name", ["promptstyler", "zero_shot"])
def test_methods_that_live_on_text_answer_images_of_the_same_space(name, make_embeddings):
    pairs = make_embeddings(domains=("TAG-sim",), per_class=8)
    means = torch.stack([torch.from_numpy(pairs.vis[pairs.label == k]).mean(0) for k in range(5)])
    texts = means[:, None] + 0.1 * torch.randn(5, 6, pairs.width)
    source = as_source(pairs, lang=texts, lang_of_images=True, plain=means)
    assert right(load(BASELINES, name, kind="baseline")(source), source) > 0.8


def test_the_contrastive_loss_is_small_for_pairs_that_belong_together():
    rows = torch.eye(4)
    assert contrastive_loss(rows, rows).item() == pytest.approx(0, abs=1e-4)
    assert contrastive_loss(rows, rows.roll(1, 0)).item() > 10


def test_the_rate_rises_then_falls_to_almost_nothing():
    rates = [rate(step, 100, 0.1) for step in range(100)]
    assert rates[9] == 1.0
    assert rates[0] == pytest.approx(0.1)
    assert rates[-1] < 0.01
    assert rates[10:] == sorted(rates[10:], reverse=True)


def test_spg_has_the_size_and_the_clips_of_its_code():
    """4,708,225 parameters at D = 512 fix the layers; the clips differ by layer."""
    prompt = torch.randn(4, 512)
    nets = spg.Generator(512, (4, 512)), spg.Discriminator(512, (4, 512))
    assert sum(p.numel() for net in nets for p in net.parameters()) == 4_708_225
    optimisers = [torch.optim.AdamW(net.parameters(), lr=0.0) for net in nets]
    images = 1e3 * torch.randn(2, 8, 512)
    spg._gan_step(*nets, optimisers, *images, prompt)
    norms = {name: float(p.grad.norm()) for name, p in nets[0].named_parameters()}
    assert norms["layers.2.weight"] == pytest.approx(5e-3, rel=1e-2)
    assert norms["layers.2.bias"] <= 5.1e-8 < norms["layers.11.bias"] <= 1.01


def test_spg_warms_up_and_ends_near_zero():
    rates = [spg.rate(epoch, 2e-4, 70, 4) for epoch in range(70)]
    assert rates[:5] == pytest.approx([1e-5, 5e-5, 1e-4, 1.5e-4, 2e-4])
    assert rates[4:] == sorted(rates[4:], reverse=True)


def test_promptstyler_keeps_the_papers_rate(monkeypatch):
    """No warm-up, cosine, decay or clip, which the paper does not state."""
    seen = []

    def kept(optimiser):
        seen.append((optimiser.param_groups[0]["lr"], float(head.weight.grad.norm())))

    monkeypatch.setattr(torch.optim.SGD, "step", kept)
    head = torch.nn.Linear(4, 2, bias=False)
    descend(head, 300, PAPER, lambda rows: 1e3 * head.weight.sum())
    assert seen == [(0.005, pytest.approx(1e3 * 8**0.5))] * 150
    assert PAPER.weight_decay == 0
