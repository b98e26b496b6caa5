"""The plan: which pairs there are, before anything is drawn."""

from collections import defaultdict

from omnivat.data.domains import DOMAINS
from omnivat.simulate.plan import classes, planned
from omnivat.simulate.surfaces import recipe

EVERYTHING = [
    pair
    for domain in DOMAINS.values()
    for material in classes(domain)
    for pair in planned(domain, material, pairs=40)
]


def test_every_class_of_every_domain_has_the_number_asked_for() -> None:
    counts = defaultdict(int)
    for pair in EVERYTHING:
        counts[pair.domain, pair.material] += 1

    assert set(counts.values()) == {40}
    assert len(counts) == 4 * 5 + 4 * 4


def test_an_object_is_in_one_domain_one_split_and_one_part_only() -> None:
    places = defaultdict(set)
    for pair in EVERYTHING:
        places[pair.material, pair.number].add((pair.domain, pair.split, pair.part, pair.object))

    assert all(len(where) == 1 for where in places.values())


def test_tacquad_has_no_ceramic_and_its_parts_have_both_splits() -> None:
    tacquad = [pair for pair in EVERYTHING if pair.domain.startswith("TQ-")]
    parts = {(pair.domain, pair.part, pair.split) for pair in tacquad}

    assert {pair.material for pair in tacquad} == {"wood", "steel", "plastic", "glass"}
    for domain in (d for d in DOMAINS.values() if d.series):
        assert {p[1:] for p in parts if p[0] == domain.name} == {
            (part, split) for part in domain.series for split in ("train", "test")
        }


def test_about_three_objects_of_ten_are_for_testing() -> None:
    share = sum(pair.split == "test" for pair in EVERYTHING) / len(EVERYTHING)

    assert 0.25 <= share <= 0.35


def test_what_is_asked_about_is_of_the_same_kinds_as_what_was_trained_on() -> None:
    kinds = defaultdict(set)
    for pair in EVERYTHING:
        kinds[pair.domain, pair.material, pair.split].add(
            recipe(pair.material, pair.number, seed=0)
        )

    unknown = sum(
        len(kinds[domain, material, "test"] - kinds[domain, material, "train"])
        for domain, material, split in kinds
        if split == "test"
    )
    assert unknown <= 3
