"""Splits keep objects whole, classes balanced, and repeat with their seed."""

from collections import Counter
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.pairs import Pair, Tally
from omnivat.data.splits import balance, hold_out, split_by_object
from omnivat.kit.errors import DataError


def pairs(objects, domain="D"):
    """Return pairs of (object, material) tuples."""
    return [
        Pair(vis=Path(f"{i}v"), tac=Path(f"{i}t"), domain=domain, material=material, object=name)
        for i, (name, material) in enumerate(objects)
    ]


owners = st.lists(st.tuples(st.sampled_from("abcdefgh"), st.sampled_from("xyz")), max_size=40)
fractions = st.floats(0, 0.95)


@given(owners, fractions, st.integers(0, 5))
def test_no_object_is_on_both_sides(members, fraction, seed):
    objects, labels = [m[0] for m in members], [m[1] for m in members]
    held = hold_out(objects, labels, fraction, seed=seed)
    assert held.shape == (len(members),)
    inside = {name for name, out in zip(objects, held, strict=True) if out}
    outside = {name for name, out in zip(objects, held, strict=True) if not out}
    assert not inside & outside


@given(owners, fractions, st.integers(0, 5))
def test_no_class_is_held_out_whole(members, fraction, seed):
    """Also where one object, such as a clip, has several classes."""
    labels = np.array([m[1] for m in members])
    held = hold_out([m[0] for m in members], labels, fraction, seed=seed)
    assert set(labels[~held]) == set(labels)


@given(
    st.dictionaries(st.sampled_from("xyz"), st.integers(2, 9), min_size=1),
    st.integers(1, 4),
    st.floats(0.05, 0.9),
)
def test_every_class_of_two_objects_is_on_both_sides(classes, size, fraction):
    members = [(f"{c}{i}", c) for c, n in classes.items() for i in range(n) for _ in range(size)]
    labels = np.array([m[1] for m in members])
    held = hold_out([m[0] for m in members], labels, fraction, seed=0)
    assert set(labels[held]) == set(labels[~held]) == set(classes)


def test_each_class_gives_its_share():
    members = [
        (f"{c}{i}", c) for c, n in (("x", 50), ("y", 20)) for i in range(n) for _ in range(3)
    ]
    labels = np.array([m[1] for m in members])
    held = hold_out([m[0] for m in members], labels, 0.3, seed=0)
    assert Counter(labels[held]) == {"x": 45, "y": 18}


def test_objects_of_many_sizes_come_within_one_object_of_the_share():
    random = np.random.default_rng(0)
    members = [
        (f"{c}{i}", c) for c in "xyz" for i in range(20) for _ in range(random.integers(1, 12))
    ]
    labels = np.array([m[1] for m in members])
    held = hold_out([m[0] for m in members], labels, 0.25, seed=3)
    for name in "xyz":
        assert abs((labels[held] == name).sum() - 0.25 * (labels == name).sum()) <= 6


def test_pairs_without_an_object_are_each_their_own():
    held = hold_out([""] * 100, np.zeros(100, dtype=int), 0.2, seed=0)
    assert held.sum() == 20


def test_the_seed_decides_and_nothing_else():
    arguments = ([str(i // 2) for i in range(60)], [i // 2 % 3 for i in range(60)], 0.3)
    first = hold_out(*arguments, seed=1)
    assert (first == hold_out(*arguments, seed=1)).all()
    assert (first != hold_out(*arguments, seed=2)).any()


def test_nothing_is_held_out_of_nothing_or_for_a_fraction_of_zero():
    assert hold_out([], [], 0.5, seed=0).shape == (0,)
    assert not hold_out(["a", "b"], [0, 0], 0, seed=0).any()


@pytest.mark.parametrize("fraction", [-0.1, 1.0, float("nan")])
def test_a_fraction_out_of_range_is_refused(fraction):
    with pytest.raises(DataError, match="choose 0 or more and below 1"):
        hold_out(["a"], [0], fraction, seed=0)


def test_lists_of_two_lengths_are_refused():
    with pytest.raises(DataError, match="2 objects but 1 labels"):
        hold_out(["a", "b"], [0], 0.5, seed=0)


def test_both_splits_have_their_shares_and_share_no_object():
    given_pairs = pairs(
        [(f"{m}{i}", m) for m in ("wood", "glass") for i in range(20) for _ in range(2)]
    )
    made = split_by_object(given_pairs, seed=0, test=0.3)
    counts = Counter((p.split, p.material) for p in made)
    assert {counts[s, "wood"] for s in ("train", "test")} == {28, 12}
    sides = [{p.object for p in made if p.split == s} for s in ("train", "test")]
    assert sum(map(len, sides)) == len(set.union(*sides)) == 40
    assert [p.vis for p in made] == [p.vis for p in given_pairs]


def test_a_domains_split_does_not_depend_on_the_others():
    one = pairs([(f"a{i}", "wood") for i in range(20)], "A")
    two = pairs([(f"a{i}", "wood") for i in range(30)], "B")
    alone = split_by_object(one, seed=0)
    assert split_by_object([*two, *one], seed=0)[30:] == alone


def test_two_domains_of_the_same_objects_are_drawn_apart():
    members = [(f"a{i}", "wood") for i in range(40)]
    made = split_by_object([*pairs(members, "A"), *pairs(members, "B")], seed=0)
    assert [p.split for p in made[:40]] != [p.split for p in made[40:]]


def test_balance_draws_as_many_of_each_class():
    members = pairs([("", "wood")] * 9 + [("", "glass")] * 4 + [("", "steel")] * 5)
    kept = balance(members, left_out := Tally(), seed=0)
    assert Counter(p.material for p in kept) == {"wood": 4, "glass": 4, "steel": 4}
    lost = {s.what: s.count for s in left_out.result("", Path(), kept, "").skipped}
    assert lost == {"D: 5 of 9 wood": 5, "D: 1 of 5 steel": 1}
    assert kept == balance(members, Tally(), seed=0)
    assert kept != balance(members, Tally(), seed=1)


def test_balance_keeps_domains_apart():
    members = pairs([("", "wood")] * 3 + [("", "glass")], "A") + pairs([("", "wood")] * 5, "B")
    kept = balance(members, Tally(), seed=0)
    assert Counter((p.domain, p.material) for p in kept) == {
        ("A", "wood"): 1,
        ("A", "glass"): 1,
        ("B", "wood"): 5,
    }
