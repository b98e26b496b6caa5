"""Building a set: the same bytes for the same seed, resuming, and errors."""

import csv
from dataclasses import replace
from hashlib import sha256
from shutil import copytree

import pytest
from PIL import Image

from omnivat.data.readers import read_pairs
from omnivat.kit.errors import DataError, MissingNameError
from simulator.build import simulate
from simulator.domains import SimulatedDomain
from simulator.photograph import plain
from simulator.plan import COLUMNS
from simulator.scenes import SCENES
from simulator.sensors import GELS

pytestmark = pytest.mark.slow  # draws pairs

SMALL = {"domains": ["TAG", "TQ-T3D"], "pairs_per_class": 2, "size": 48, "renderer": plain}


def hashes(folder):
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    return {str(f.relative_to(folder)): sha256(f.read_bytes()).hexdigest() for f in files}


@pytest.fixture(scope="module")
def built(tmp_path_factory):
    folder = tmp_path_factory.mktemp("set")
    simulate(folder, **SMALL, workers=1)
    return folder


def test_the_set_lists_what_lies_on_disk(built):
    with (built / "pairs.csv").open() as file:
        rows = list(csv.DictReader(file))

    assert tuple(rows[0]) == COLUMNS
    assert len(rows) == 2 * (5 + 4)
    assert all((built / row[kind]).exists() for row in rows for kind in ("vis", "tac"))
    assert {row["domain"] for row in rows} == {"TAG-sim", "TQ-T3D-sim"}
    assert read_pairs(built).simulated


def test_another_seed_gives_other_pictures(built, tmp_path):
    simulate(tmp_path, **(SMALL | {"domains": ["TQ-T3D"], "pairs_per_class": 1}), seed=1, workers=1)

    first, other = hashes(built), hashes(tmp_path)
    drawn = [name for name in other if name.endswith(("_vis.png", "_tac.png"))]
    assert len(drawn) == 8 and all(other[name] != first[name] for name in drawn)


def test_touches_alone_are_those_of_the_whole_set(built, tmp_path):
    made = simulate(str(tmp_path), **SMALL, workers=1, touches=True)

    whole, alone = hashes(built), hashes(tmp_path)
    assert {n for n in alone if "_tac" in n} == {n for n in whole if "_tac" in n}
    assert all(whole[name] == alone[name] for name in alone if name != "pairs.csv")
    assert len(made.pairs) == 18 and all(pair.alone == "tac" for pair in made.pairs)


def test_a_stopped_build_draws_only_what_is_missing_broken_or_of_another_size(built, tmp_path):
    folder, steps = copytree(built, tmp_path / "set"), []
    before = hashes(folder)
    images = sorted((folder / "TAG-sim").rglob("*.png"))
    images[0].unlink()
    images[5].write_bytes(images[5].read_bytes()[:200])
    Image.new("RGB", (8, 8)).save(images[7])
    simulate(folder, **SMALL, workers=1, on_step=steps.append)

    assert hashes(folder) == before
    assert [step.done for step in steps] == [33, 34, 35, 36]


def test_no_second_worker_and_no_domain_of_ones_own_changes_a_byte_of_another(built, tmp_path):
    mine = SimulatedDomain(
        name="Mine",
        sensor=replace(GELS["DIGIT"], gain=2.5),
        scene=SCENES["OF Real"],
        seed_base=90_000,
    )
    pairs = simulate(tmp_path, **(SMALL | {"domains": [mine, "TQ-T3D-sim"]}), workers=2)

    found, shipped = hashes(tmp_path), hashes(built)
    others = [name for name in found if name.startswith("TQ-T3D-sim")]
    assert len(others) == 17 and all(found[name] == shipped[name] for name in others)
    assert sum(pair.domain == "Mine-sim" for pair in pairs.pairs) == 10


@pytest.mark.parametrize(
    ("change", "error", "sentence"),
    [
        (
            {"domains": ["TAGG"]},
            MissingNameError,
            "No domain is called 'TAGG'; there are TAG, OF Real",
        ),
        ({"pairs_per_class": 0}, DataError, "choose 1 to 10,000"),
    ],
)
def test_what_makes_no_pair_is_refused(change, error, sentence, tmp_path):
    with pytest.raises(error, match=sentence):
        simulate(tmp_path, **(SMALL | change), workers=1)
