"""The plan of a set, before anything is drawn."""

from collections import Counter, defaultdict
from hashlib import sha256

import pytest

from omnivat.data.domains import DOMAINS
from omnivat.data.materials import MATERIALS
from omnivat.simulate.domains import NUMBERS, SIMULATED
from omnivat.simulate.plan import IMITATIONS, PAIRS, classes, planned
from omnivat.simulate.sensors import SENSORS

EVERYTHING = [
    pair
    for domain in SIMULATED.values()
    for material in classes(domain)
    for pair in planned(domain, material, pairs=PAIRS)
]


def test_the_shipped_set_has_the_objects_that_it_always_had():
    facts = [
        (p.domain, p.material, p.object, p.number, p.split, p.part, p.looks_like, p.feels_like)
        for p in EVERYTHING
    ]

    assert sha256(repr(facts).encode()).hexdigest()[:16] == "4741f7d89e60eff0"


def test_domains_have_the_sensors_of_the_paper_and_numbers_of_their_own():
    bases = [made.seed_base for made in SIMULATED.values()]

    assert list(SIMULATED) == list(DOMAINS)
    assert len({base // NUMBERS for base in bases}) == len(bases)
    for name, made in SIMULATED.items():
        (sensor,) = (key for key, model in SENSORS.items() if model is made.sensor)
        assert sensor.startswith(DOMAINS[name].sensor)


def test_every_class_of_every_domain_has_40_training_and_20_test_objects():
    counts = Counter((pair.domain, pair.material, pair.split) for pair in EVERYTHING)

    assert len(EVERYTHING) == 2160
    assert len(counts) == 2 * (4 * 5 + 4 * 4)
    for (*_, split), count in counts.items():
        assert abs(count - {"train": 40, "test": 20}[split]) <= 1


def test_an_object_is_in_one_domain_one_split_and_one_part_only():
    places = defaultdict(set)
    for pair in EVERYTHING:
        places[pair.material, pair.number].add((pair.domain, pair.split, pair.part, pair.object))

    assert all(len(where) == 1 for where in places.values())


@pytest.mark.parametrize("split", ["train", "test"])
@pytest.mark.parametrize("material", MATERIALS)
def test_a_quarter_of_every_split_looks_like_another_class(material, split):
    for domain in SIMULATED.values():
        mine = [p for p in EVERYTHING if (p.domain, p.material) == (domain.name, material)]
        alike = [bool(p.looks_like) for p in mine if p.split == split]
        assert not mine or 0.2 <= sum(alike) / len(alike) <= 0.3, domain.name


def test_every_imitation_is_in_both_splits_and_names_another_class_of_its_domain():
    seen = Counter((p.material, p.looks_like, p.split) for p in EVERYTHING if p.looks_like)

    for material, others in IMITATIONS.items():
        for other in others:
            assert seen[material, other, "train"] > seen[material, other, "test"] > 0
    for pair in EVERYTHING:
        there = {*classes(SIMULATED[pair.domain]), ""} - {pair.material}
        assert {pair.looks_like, pair.feels_like} <= there


def test_smooth_classes_feel_alike_and_no_object_imitates_by_both():
    assert not any(pair.looks_like and pair.feels_like for pair in EVERYTHING)
    feels = Counter(pair.material for pair in EVERYTHING if pair.feels_like)

    assert "wood" not in feels
    for material in ("steel", "plastic", "ceramic", "glass"):
        of = sum(pair.material == material for pair in EVERYTHING)
        assert 0.06 <= feels[material] / of <= 0.14, material
