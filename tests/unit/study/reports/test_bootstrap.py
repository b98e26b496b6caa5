"""Resampled objects, simultaneous intervals and the tables made from them."""

import pytest

from omnivat.study.reports.bootstrap import (
    _objects,
    complete_rows,
    draws_for,
    percentile,
    resampled,
    simultaneous,
)
from omnivat.study.reports.protocol_report import protocol_report

from .made_records import grid


def test_the_headline_names_the_best_other_row_whichever_modality_it_uses():
    found = grid("omnivat", 0.8) + grid("linear_maps", 0.6, reading_shares={"vis": 0.9})
    text = protocol_report(found)
    assert "OmniVaT 80.0; best of 3 other rows: linear_maps, photo only, 90.0" in text
    assert "Difference -10.0" in text


def test_test_objects_that_are_reused_count_once():
    """Six runs that share 40 objects are as uncertain as one: sd of a mean of 40 at 0.75."""
    found = grid("omnivat", 0.75)
    draws = resampled(found, ("omnivat", "fused"), draws_for(found))["accuracy"].draws
    assert draws.std() == pytest.approx((0.75 * 0.25 / 40) ** 0.5, rel=0.1)


def test_simultaneous_intervals_are_wider_than_single_ones_and_grow_with_the_rows():
    found = grid("omnivat", 0.8)
    for number in range(12):
        found += grid(f"other {number}", 0.5 + 0.02 * number)
    drawn = draws_for(found)
    rows = complete_rows(found, ("fused", "tac"))
    values = {row: resampled(found, row, drawn)["accuracy"] for row in rows}
    ours = values.pop(("omnivat", "fused"))
    others = {row: v for row, v in values.items() if row[0] != "omnivat"}
    one = ("other 3", "fused")
    many, few = simultaneous(ours, others)[one], simultaneous(ours, {one: others[one]})[one]
    alone = percentile(ours, others[one])
    assert many.mean == few.mean == pytest.approx(0.25)
    assert many.high - many.low >= few.high - few.low
    assert few.high - few.low == pytest.approx(alone.high - alone.low, rel=0.15)


def test_a_row_without_every_source_and_seed_is_in_no_comparison():
    found = grid("omnivat", 0.8) + grid("slow", 0.9)[:1]
    assert ("slow", "fused") not in complete_rows(found, ("fused",))
    assert ("omnivat", "fused") in complete_rows(found, ("fused",))


def test_side_tables_show_confidence_and_margins():
    text = protocol_report(grid("omnivat", 0.8))
    assert "| OmniVaT | 10.0 | 0.10 | 10.0 |" in text
    assert "20.0 / 10.0 / –" in text


def test_every_draw_holds_as_many_objects_of_each_class_as_the_domain():
    drawn = draws_for(found := grid("omnivat", 0.75))
    for domain, classes in _objects(found).items():
        for label in set(classes.values()):
            columns = [
                drawn.objects[domain].index(one) for one, name in classes.items() if name == label
            ]
            assert 0 < len(columns) < len(classes)
            assert (drawn.weights[domain][:, columns].sum(1) == len(columns)).all()
