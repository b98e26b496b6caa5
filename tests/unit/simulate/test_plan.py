"""The plan of a set, before anything is drawn."""

from collections import Counter, defaultdict
from hashlib import sha256

from omnivat.data.domains import DOMAINS
from omnivat.simulate.domains import NUMBERS, SIMULATED
from omnivat.simulate.plan import PAIRS, classes, planned
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


def test_an_object_is_in_one_domain_one_split_and_one_part_only():
    places = defaultdict(set)
    for pair in EVERYTHING:
        places[pair.material, pair.number].add((pair.domain, pair.split, pair.part, pair.object))

    assert all(len(where) == 1 for where in places.values())


def test_objects_imitate_classes_of_their_domain_by_sight_or_by_touch_and_smooth_ones_by_touch():
    assert not any(pair.looks_like and pair.feels_like for pair in EVERYTHING)
    for pair in EVERYTHING:
        there = {*classes(SIMULATED[pair.domain]), ""} - {pair.material}
        assert {pair.looks_like, pair.feels_like} <= there
    feels = Counter(pair.material for pair in EVERYTHING if pair.feels_like)

    assert "wood" not in feels
    for material in ("steel", "plastic", "ceramic", "glass"):
        of = sum(pair.material == material for pair in EVERYTHING)
        assert 0.06 <= feels[material] / of <= 0.14, material
