"""Results in unseen domains: test pairs, shares, their intervals, retrieval."""

from dataclasses import replace
from functools import partial

import numpy as np
import pytest
import torch
from scipy.stats import binomtest
from torch.nn.functional import normalize

from omnivat.head.checkpoint import ENCODER, Head
from omnivat.head.head import build_head
from omnivat.maps.frames.builder import NAMES, build_frames
from omnivat.maps.frames.records import with_learned
from omnivat.measure import unseen
from omnivat.measure.known import measured
from omnivat.measure.shares import counted, mean_over_domains, of_domains, wilson
from omnivat.measure.unseen import nearest_touch, retrieval_rows, unseen_summary
from tests.builders import head_settings

SOURCE = "TAG-sim"


def untrained(embeddings):
    """Return a small head that fits embeddings and was trained nowhere."""
    settings = head_settings(embeddings, width=16, lang_width=16)
    encoder = dict(zip(ENCODER, embeddings.header.key, strict=True))
    model = build_head(settings, seed=2).eval()
    return Head(model=model, encoder=encoder, provenance={"source": SOURCE})


@pytest.fixture(scope="module")
def case(make_embeddings):
    embeddings = make_embeddings(domains=(SOURCE, "OF Real-sim", "TQ-sim"), split=True)
    embeddings.rows["looks_like"][:] = [
        "steel" if i % 4 == 2 else "" for i in range(len(embeddings))
    ]
    head = untrained(embeddings)
    return head, embeddings, unseen_summary(head, embeddings)


def test_only_test_pairs_count_where_a_split_is_stated(make_embeddings):
    split = make_embeddings(split=True)
    assert [split.rows["split"][i] for i in np.flatnonzero(counted(split, SOURCE))] == ["test"] * 40


def test_of_a_source_without_a_split_no_pair_counts(make_embeddings):
    plain = make_embeddings()
    keep = counted(plain, SOURCE)
    assert not keep[plain.domain == 0].any()
    assert keep[plain.domain == 1].all()


def test_shares_are_those_that_are_measured(case):
    head, embeddings, summary = case
    for record, own in zip(measured(head, embeddings)["domains"], summary["domains"], strict=True):
        assert own["pairs"] == record["pairs"]
        for reading in ("fused", "vis", "tac"):
            share, measure = own[f"answers/{reading}"], record["scores"][reading]
            assert share == {
                "share": measure["accuracy"],
                "low": measure["low"],
                "high": measure["high"],
            }


def test_however_many_pairs_are_read_at_once_the_record_is_the_same(case, monkeypatch):
    head, embeddings, summary = case
    monkeypatch.setattr(unseen, "blocks", partial(unseen.blocks, size=7))
    monkeypatch.setattr(unseen, "BLOCK", 3)
    again = unseen_summary(head, embeddings)
    assert again["unseen"] == summary["unseen"] and again["domains"] == summary["domains"]
    np.testing.assert_allclose(again["pairs"]["cosine"], summary["pairs"]["cosine"], atol=1e-6)
    vis, tac = (
        normalize(head.model(*images).f_hat[name].detach(), dim=-1)
        for name, images in (
            ("vis", (torch.from_numpy(embeddings.vis), None)),
            ("tac", (None, torch.from_numpy(embeddings.tac))),
        )
    )
    np.testing.assert_allclose(summary["pairs"]["cosine"], (vis * tac).sum(1), atol=1e-5)


def test_the_mean_leaves_the_source_out(case):
    _, _, summary = case
    others = [d["answers/fused"]["share"] for d in summary["domains"] if not d["is_source"]]
    assert summary["unseen"]["answers/fused"]["share"] == pytest.approx(np.mean(others))
    total = np.array(summary["confusion"]["fused"]["unseen"])
    assert total.sum() == sum(d["pairs"] for d in summary["domains"] if not d["is_source"])


def test_look_alikes_are_counted_among_unseen_pairs_alone(case):
    _, embeddings, summary = case
    marked = [bool(name) for name in embeddings.rows["looks_like"]]
    expected = counted(embeddings, SOURCE) & (embeddings.domain > 0) & np.array(marked)
    assert summary["look_alikes"]["pairs"] == expected.sum() > 0


def test_a_class_that_the_head_lacks_is_left_out(case):
    head, embeddings, _ = case
    names = (*embeddings.header.classes[:-1], "rubber")
    other = replace(embeddings, header=replace(embeddings.header, classes=names))
    summary = unseen_summary(head, other)
    assert all(own["pairs"] == 16 for own in summary["domains"])
    assert sum(summary["pairs"]["counts"]) == 48


@pytest.mark.parametrize(("right", "total"), [(0, 10), (10, 10), (3, 10), (700, 1000)])
def test_the_interval_of_one_domain_is_wilsons(right, total):
    wanted = binomtest(right, total).proportion_ci(method="wilson")
    assert wilson(right, total) == pytest.approx((wanted.low, wanted.high), abs=1e-12)


def test_the_interval_over_domains_counts_their_objects_and_how_they_differ():
    """Of equal domains only objects vary, 600 together; else also which domains are drawn."""
    for shares, spread in (([0.5] * 6, 0.0), ([0.2, 0.8] * 3, 0.3)):
        low, high = of_domains([(100 * share, 100) for share in shares])
        within = np.mean([share * (1 - share) for share in shares]) / 100
        assert high - low == pytest.approx(2 * 1.96 * ((within + spread**2) / 6) ** 0.5, rel=0.15)
        assert (low + high) / 2 == pytest.approx(0.5, abs=0.02)


def test_a_photo_finds_the_touch_nearest_in_direction_within_its_domain():
    vis = np.array([[1.0, 0.0], [0.0, 1.0], [1.0, 0.0]])
    tac = np.array([[0.0, 2.0], [9.0, 0.1], [0.0, 1.0]])
    domain, rows = np.array([0, 0, 1]), np.array([0, 1, 2])
    assert nearest_touch(vis[rows], tac, domain, rows).tolist() == [1, 0, 2]
    assert nearest_touch(vis[rows[::-2]], tac, domain, rows[::-2]).tolist() == [2, 1]


def test_of_large_domains_an_even_part_is_judged(monkeypatch):
    domain = np.array([0] * 10 + [1] * 3)
    keep = np.arange(13) != 12
    monkeypatch.setattr("omnivat.measure.unseen.MOST", 4)
    assert retrieval_rows(keep, domain).tolist() == [0, 3, 6, 9, 10, 11]
    assert retrieval_rows(np.zeros(13, dtype=bool), domain).tolist() == []


def test_the_curve_of_frames_is_the_mean_over_unseen_domains(case):
    head, embeddings, summary = case

    here = {"orders": [head.model.order], "maps": {}, "measures": ["accuracy"]}
    curves = build_frames(head.model, embeddings, **here, provenance={"source": SOURCE}).curves
    for reading, name in (("fused", "accuracy/unseen"), ("tac", "accuracy:tac/unseen")):
        assert curves[name] == pytest.approx([summary["unseen"][f"answers/{reading}"]["share"]])
    assert not set(NAMES.values()) & set(build_frames(head.model, embeddings, **here).curves)


def test_without_unseen_pairs_there_is_no_mean(make_embeddings):
    one = make_embeddings(domains=(SOURCE,))
    right = np.ones(len(one), dtype=bool)
    assert mean_over_domains(right, one, SOURCE, right) is None
    assert mean_over_domains(right, one, "elsewhere", right) is None


def test_the_slider_stops_at_exactly_the_learned_order():
    rounds = [k / 100 for k in range(101)]
    stops = with_learned(rounds, 0.50137)
    assert 0.50137 in stops
    assert len(stops) == 102
    assert len(with_learned(rounds, 0.5002)) == 101
    assert with_learned(rounds, 1.5) == tuple(rounds)
    assert with_learned(rounds, None) == tuple(rounds)
