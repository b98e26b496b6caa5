"""The card of a sensor: one known part of a simulated gel is changed, and the card names it."""

import json
from dataclasses import replace

import numpy as np
import pytest
from PIL import Image

from benchmarks import sensor
from omnivat import embed_pairs, load_embeddings, read_pairs, sensor_card
from omnivat.cli import main
from omnivat.data.arranged import with_ways
from omnivat.kit.errors import DataError
from omnivat.measure.card import of_set
from omnivat.measure.card.card import card_of
from omnivat.measure.card.changes import COSTS, changes_between, cost_of
from omnivat.measure.card.traits import traits_of
from simulator.sensors import SENSORS, Lamp

GEL = SENSORS["DIGIT"]


@pytest.fixture(scope="module")
def pressed():
    """Presses of eight objects, and of eight others, to be imaged by gels of one shape."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(sensor, "SIZE", 160)  # drawn small
        return [sensor.Pressed(GEL, folder, 8) for folder in (0, 1)]


@pytest.fixture(scope="module")
def old(pressed):
    return pressed[0].seen(GEL)


@pytest.fixture(scope="module")
def before(old):
    return card_of(old)


@pytest.fixture(scope="module")
def after(pressed):
    return pressed[1].seen(GEL)


def parts(old, pictures):
    return [change.part for change in changes_between(old, card_of(pictures))]


def test_other_objects_alone_are_no_change(before, after):
    assert parts(before, after) == []


@pytest.mark.parametrize(
    ("part", "turn"),
    [
        ("channels", lambda a: a[..., ::-1]),
        ("mirrored", lambda a: a[:, ::-1]),
        ("turned", lambda a: np.rot90(a)),
    ],
)
def test_swapped_channels_mirrored_and_turned_pictures_are_named_alone(before, after, part, turn):
    assert parts(before, [np.ascontiguousarray(turn(one)) for one in after]) == [part]


CHANGED = {
    "lamps": replace(
        GEL, lamps=tuple(Lamp(a + 50, colour, spill) for a, colour, spill in GEL.lamps)
    ),
    "dots": replace(GEL, markers=SENSORS["GelSight"].markers),
    "tint": replace(GEL, base=(0.58, 0.50, 0.44)),
    "noise": replace(GEL, noise=3 * GEL.noise),
    "sharpness": replace(GEL, blur=4.0),
}


@pytest.mark.slow
@pytest.mark.parametrize("part", CHANGED)
def test_a_changed_part_of_a_gel_is_named_first(before, pressed, part):
    assert parts(before, pressed[1].seen(CHANGED[part]))[0] == part


def test_the_command_names_what_changed_and_writes_pictures_as_the_old_sensor_has_them(
    old, after, tmp_path, capsys
):
    for name, pictures in (("old", old), ("new", [a[:, ::-1] for a in after])):
        (tmp_path / name).mkdir()
        for k, one in enumerate(pictures):
            Image.fromarray(one).save(tmp_path / name / f"{k:02d}_tac.png")
    was, new, mended = (str(tmp_path / name) for name in ("old", "new", "mended"))
    rose = tmp_path / "rose.png"
    command = ["sensor", new, "--against", was, "--mend", mended, "--figure", str(rose)]
    assert main(command) == 0
    assert "1. **mirrored**" in capsys.readouterr().out
    assert rose.read_bytes()[:4] == b"\x89PNG"
    with Image.open(tmp_path / "mended" / "00_tac.png") as image:
        first = np.asarray(image)
    assert np.array_equal(first, after[0])
    assert main(["sensor", mended, "--against", was, "--json"]) == 0
    assert json.loads(capsys.readouterr().out)["changed"] == []


def test_too_few_flat_and_grey_pictures_give_one_sentence(before, after):
    with pytest.raises(DataError, match="needs 5 touch images or more, better 25, and there is 1"):
        sensor_card(after[:1])
    with pytest.raises(DataError, match="there are none"):
        sensor_card([])
    assert changes_between(before, card_of([np.zeros_like(after[0])] * 5))  # black, no warning
    for flat in (np.full((96, 96, 3), 90, np.uint8), np.repeat(after[0][..., :1], 3, -1)):
        card = sensor_card([flat] * 6)
        assert card.lamps is None
        assert card.unlit.count("\n") == 0 and card.unlit.endswith(".")
        assert card.missing == ""  # more such pictures do not help
    noise = np.random.default_rng(0).integers(256, size=(8, 96, 96, 3), dtype=np.uint8)
    assert sensor_card(noise).missing.startswith("About 12 more")


def test_large_pictures_are_read_reduced_and_other_arrays_are_refused(after):
    one = traits_of(np.kron(after[0], np.ones((6, 6, 1), np.uint8)))
    assert one.size == (960, 960)
    assert one.filled.shape == (240, 240, 3)
    with pytest.raises(DataError, match="has shape .160, 160. and type uint8"):
        sensor_card([after[0][..., 0]] * 6)


def test_a_change_of_size_is_stated_beside_grain_and_sharpness(before, after):
    found = changes_between(
        before, card_of([np.kron(a, np.ones((2, 2, 1), np.uint8)) for a in after[:5]])
    )
    told = {
        change.part: "have 320 × 320 pixels and had 160 × 160" in change.evidence
        for change in found
    }
    assert told and told == {part: part in ("noise", "sharpness") for part in told}


def test_what_a_change_costs_is_what_the_twins_record():
    from pathlib import Path

    record = json.loads(Path("docs/benchmarks/twins.json").read_text(encoding="utf-8"))
    every = record["parts"]["every"]
    names = {"dots": "markers", "noise": "camera", "sharpness": "softness", "scale": "field, depth"}
    for part, (kept, filled) in COSTS.items():
        found = every[names.get(part, part)]
        for words, printed in (("as it comes", kept), ("dots filled", filled)):
            assert abs(np.ravel(found[words])[0]) == pytest.approx(printed, abs=0.06)
    assert "touch loses 19 points of accuracy, and 0.5 with the dots" in cost_of("dots")
    assert cost_of("mirrored") == ""


def test_the_domains_of_a_set_whose_sensors_differ_are_named_in_a_sentence(
    old, after, tmp_path, monkeypatch, capsys
):
    place = tmp_path / "set"
    mirrored = [np.ascontiguousarray(one[:, ::-1]) for one in after]
    for unit, pictures in (("unit-a", old), ("unit-b", mirrored)):
        (place / unit / "wood").mkdir(parents=True)
        for k, one in enumerate(pictures[:6]):
            for half in ("vis", "tac"):
                Image.fromarray(one).save(place / unit / "wood" / f"{k:02d}_{half}.png")
    monkeypatch.setattr(of_set, "recall", lambda _: place)
    pairs, out = read_pairs(place), tmp_path / "set.safetensors"

    def lines(ways):
        embed_pairs(with_ways(pairs, ways), "strip", out, flips=False)
        made = load_embeddings(out)
        return of_set.differences(replace(made, header=replace(made.header, encoder="a network")))

    assert lines({}) == [
        "unit-b against unit-a: pictures are mirrored from left to right; the rest is as before."
    ]
    assert lines({"unit-b": "left-right"}) == []
    monkeypatch.setattr(of_set, "differences", lambda _: ["The line of the card."])
    assert main(["report", str(out), "--out", str(tmp_path / "report")]) == 0
    assert "The line of the card." in capsys.readouterr().out
