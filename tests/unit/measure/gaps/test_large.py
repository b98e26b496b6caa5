"""Gaps of sets that are not held in memory: moments equal rows, and stated errors hold."""

import json

import numpy as np
import pytest
import torch

from omnivat.cli import gaps as command
from omnivat.cli import main
from omnivat.kit.tables import load
from omnivat.measure.gaps import GAPS, large, mmd
from omnivat.measure.gaps.large import ESTIMATES, MOMENT_GAPS, drawn, moments_of, parts_of
from omnivat.measure.gaps.unit import unit

NAMES = ("a", "b", "none", "c")


def made(count=900, width=24):
    random = np.random.default_rng(0)
    domain = random.choice([0, 1, 3], count, p=[0.7, 0.2, 0.1])
    rows = random.standard_normal((2, count, width)) * random.random(width) + 3
    rows[1] += 0.3
    rows[:, domain == 1] += random.standard_normal(width) / 3
    return unit(torch.tensor(rows.reshape(2 * count, width), dtype=torch.float32)), domain


@pytest.mark.parametrize("measure", MOMENT_GAPS)
def test_gaps_from_moments_of_blocks_are_those_of_the_rows(measure):
    points, domain = made()
    vis, tac = points.chunk(2)
    sets, every = parts_of(points, domain, NAMES)
    some = [slice(k, k + 100) for k in range(0, len(domain), 100)]
    blocks = ((one, {"vis": vis[one], "tac": tac[one]}) for one in some)
    found, whole, halves = moments_of(blocks, domain, NAMES, squares=measure == "frechet")
    gap, by_moments = load(GAPS, measure, kind="gap"), MOMENT_GAPS[measure]
    assert list(found["vis"]) == list(sets["vis"]) == ["a", "b", "c"]
    for a, b in (("a", "b"), ("b", "c")):
        exact = float(gap(sets["tac"][a].double(), sets["tac"][b].double()))
        assert float(by_moments(found["tac"][a], found["tac"][b])) == pytest.approx(exact, rel=1e-4)
    exact = float(gap(every["vis"].double(), every["tac"].double()))
    assert float(by_moments(whole["vis"], whole["tac"])) == pytest.approx(exact, rel=1e-4)
    assert [a.count + b.count for a, b in halves["tac"]] == np.bincount(domain)[[0, 1, 3]].tolist()


def test_a_draw_keeps_small_domains_whole_and_the_rest_in_proportion(monkeypatch):
    monkeypatch.setattr(large, "DRAWN", 300)
    monkeypatch.setattr(large, "LEAST", 50)
    _, domain = made()
    rows, alike = drawn(domain)
    sizes = np.bincount(domain)
    assert np.bincount(domain[rows]).tolist() == [min(100, size) for size in sizes]
    shares = np.bincount(domain[rows][alike])[[0, 1, 3]] / sizes[[0, 1, 3]]
    assert shares == pytest.approx(100 / sizes[0], rel=0.05)


@pytest.mark.parametrize("measure", ESTIMATES)
def test_the_stated_error_covers_the_draw_of_rows_too(measure, monkeypatch):
    monkeypatch.setattr(mmd, "SAMPLE", 40)
    random = np.random.default_rng(1)
    a, b = (torch.tensor(random.standard_normal((20_000, 8)) + move) for move in (0, 0.25))
    exact = float(load(GAPS, measure, kind="gap")(a[:2000], b[:2000]))
    inside = 0
    for seed in range(12):
        some = np.random.default_rng(seed).choice(20_000, 800, replace=False)
        found = ESTIMATES[measure](a[some], b[some])
        inside += abs(float(found.value) - exact) <= 2.2 * float(found.error)
    assert inside >= 10


def test_the_command_states_what_it_drew_and_agrees_with_all_pairs(
    head_folder, capsys, monkeypatch
):
    file = head_folder.parent / "set.safetensors"
    words = ["gaps", "--embeddings", str(file), "--stage", "raw", "--json", "--measure"]

    def said(measure):
        assert main([*words, measure]) == 0
        return json.loads(capsys.readouterr().out)

    exact = {measure: said(measure) for measure in ("frechet", "mmd_rbf")}
    monkeypatch.setattr(command, "LARGE", 5)
    monkeypatch.setattr(mmd, "MOST_ROWS", 5)
    found = {measure: said(measure) for measure in exact}
    assert found["frechet"]["modality_gap"] == pytest.approx(
        exact["frechet"]["modality_gap"], rel=1e-3
    )
    assert (
        "drawn" not in found["frechet"] and found["mmd_rbf"]["drawn"] == found["mmd_rbf"]["pairs"]
    )
    gap, own = (one["mmd_rbf"]["modality_gap"]["all"] for one in (exact, found))
    assert abs(gap - own) < 4 * found["mmd_rbf"]["standard_error"]
