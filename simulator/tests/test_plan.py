"""The plan of a set, before anything is drawn."""

from hashlib import sha256

from omnivat.data.domains import DOMAINS
from simulator.domains import NUMBERS, SIMULATED
from simulator.plan import PAIRS, classes, planned
from simulator.sensors import SENSORS

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
