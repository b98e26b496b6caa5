"""Settings: every field declares its range, and other values give one sentence."""

from argparse import ArgumentTypeError
from typing import get_type_hints

import pytest

from omnivat.head.settings import HeadSettings
from omnivat.kit.config import OneOf, Within, declared, parse_assignments, settings_from, whole
from omnivat.kit.errors import SettingsError
from omnivat.kit.stages import checked_order, fitting
from omnivat.training import TrainSettings
from simulator.chirps import ChirpSettings

WANTED = {
    HeadSettings: {"classes": ("wood", "steel"), "input_width": 24},
    TrainSettings: {},
    ChirpSettings: {},
}
LIMITS = {int: Within, float: Within, str: OneOf}


@pytest.mark.parametrize("kind", WANTED)
def test_every_number_declares_a_range_and_every_text_its_choices(kind):
    """Reads the fields themselves, so a new one without a range fails here."""
    hints = {name: LIMITS[hint] for name, hint in get_type_hints(kind).items() if hint in LIMITS}
    found = {name: type(limit) for name, limit in declared(kind).items()}
    assert found == {name: limit for name, limit in hints.items() if name != "seed"}


FIELDS = [(kind, name) for kind in WANTED for name in declared(kind)]


@pytest.mark.parametrize(("kind", "name"), FIELDS)
def test_what_a_field_does_not_take_is_refused_with_what_it_takes(kind, name):
    limit = declared(kind)[name]
    values = ["nonsense"]
    if isinstance(limit, Within):
        values = [float("nan"), float("inf"), limit.low - 1, limit.high + 1, -limit.high - 1]
    for value in values:
        with pytest.raises(SettingsError, match=f"{name} is .*; (choose|give)"):
            kind(**{**WANTED[kind], name: value})


@pytest.mark.parametrize("kind", WANTED)
def test_the_ends_of_a_range_are_in_it(kind):
    for name, limit in declared(kind).items():
        if isinstance(limit, Within):
            assert limit.allows(limit.low) and limit.allows(limit.high), name


def test_a_file_of_settings_is_held_to_the_same_ranges():
    with pytest.raises(SettingsError, match="logit_scale is -1.0; choose 0.001 to 10000"):
        settings_from(HeadSettings, {**WANTED[HeadSettings], "logit_scale": -1})


@pytest.mark.parametrize(("name", "value"), [("width", [16]), ("classes", "wood"), ("maps", 1)])
def test_a_value_of_another_kind_is_refused(name, value):
    with pytest.raises(SettingsError, match=f"Setting '{name}' is .*; it must be"):
        settings_from(HeadSettings, {**WANTED[HeadSettings], name: value})


@pytest.mark.parametrize("order", [True, "0.5", float("nan"), 10**50, -4.01])
def test_an_order_that_is_no_number_in_range_is_refused(order):
    with pytest.raises(SettingsError, match="p is .*; give a number of quarter turns from -4 to 4"):
        checked_order(order, name="p")


def test_an_order_beyond_the_range_has_its_equal_named():
    assert [checked_order(p) for p in (-4, 0, 4.0)] == [-4.0, 0.0, 4.0]
    with pytest.raises(SettingsError, match=r"period 4, so use 1\.5\."):
        checked_order(5.5)
    with pytest.raises(SettingsError, match="a whole number of more than 40 digits"):
        checked_order(10**40)


def test_a_wider_head_fits_a_narrower_range_about_its_own_order():
    """The phases turn by D times the change of p: by 2 at each end, whatever the width."""
    for width in (16, 512):
        assert [(p - 0.5) * width for p in fitting(0.5, width)] == pytest.approx([-2, 2])


def test_an_unknown_setting_has_its_neighbour_named_or_else_all_that_there_are():
    with pytest.raises(SettingsError, match="no setting 'ordr'. Did you mean 'order'"):
        parse_assignments(ChirpSettings, ["ordr=1"])
    with pytest.raises(SettingsError, match="no setting 'zzz'. There are order, strength, shift"):
        parse_assignments(ChirpSettings, ["zzz=1"])


def test_a_whole_number_is_taken_from_its_range_with_both_ends():
    assert [whole(2, 9)(text) for text in ("2", "9")] == [2, 9]
    for text in ("1", "10", "2.0", ""):
        with pytest.raises(ArgumentTypeError, match=f"'{text}'; give a whole number, 2 to 9"):
            whole(2, 9)(text)


def test_a_search_and_a_random_order_exclude_each_other():
    with pytest.raises(SettingsError, match="order_search and order_draw exclude each other"):
        TrainSettings(order_search=True, order_draw=True)
