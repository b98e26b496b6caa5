"""Splits keep objects whole, classes balanced, and repeat with their seed."""

from pathlib import Path

import numpy as np
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.pairs import Pair
from omnivat.data.splits import hold_out, split_by_object


def pairs(objects, domain="D"):
    """Return pairs of (object, material) tuples."""
    return [
        Pair(vis=Path(f"{i}v"), tac=Path(f"{i}t"), domain=domain, material=material, object=name)
        for i, (name, material) in enumerate(objects)
    ]


owners = st.lists(st.tuples(st.sampled_from("abcdefgh"), st.sampled_from("xyz")), max_size=40)
fractions = st.floats(0.01, 0.95)


@given(owners, fractions, st.integers(0, 5))
def test_no_object_is_on_both_sides_and_no_class_is_held_out_whole(members, fraction, seed):
    """Also where one object, such as a clip, has several classes."""
    objects, labels = [m[0] for m in members], np.array([m[1] for m in members])
    held = hold_out(objects, labels, fraction, seed=seed)
    assert held.shape == (len(members),)
    inside = {name for name, out in zip(objects, held, strict=True) if out}
    outside = {name for name, out in zip(objects, held, strict=True) if not out}
    assert not inside & outside
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


def test_pairs_without_an_object_are_each_their_own():
    held = hold_out([""] * 100, np.zeros(100, dtype=int), 0.2, seed=0)
    assert held.sum() == 20


def test_a_domains_split_does_not_depend_on_the_others():
    one = pairs([(f"a{i}", "wood") for i in range(20)], "A")
    two = pairs([(f"a{i}", "wood") for i in range(30)], "B")
    alone = split_by_object(one, seed=0, test=0.3)
    both = split_by_object([*two, *one], seed=0, test=0.3)
    assert both[30:] == alone
    assert [pair.split for pair in both[:20]] != [pair.split for pair in alone], "drawn apart"
