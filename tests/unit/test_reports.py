"""Tables, intervals and plots rebuilt from records, against figures worked out by hand."""

import json
import math
from xml.etree import ElementTree

import numpy as np
import pytest

from omnivat.ablations import ABLATIONS, method_name
from omnivat.encoders import ENCODERS
from omnivat.reports.ablation_report import write_ablations
from omnivat.reports.bootstrap import (
    complete_rows,
    draws_for,
    percentile,
    resampled,
    simultaneous,
)
from omnivat.reports.evidence_report import evidence_report
from omnivat.reports.intervals import (
    Interval,
    Spread,
    bootstrap_interval,
    paired_differences,
    spread,
    t_interval,
)
from omnivat.reports.paper import BACKBONES, MARK, not_comparable, paper, paper_rows
from omnivat.reports.plot import line_plot
from omnivat.reports.protocol_report import interval_table, main_table, protocol_report
from omnivat.reports.reading import by_run, by_seed, changed_settings
from omnivat.reports.text_table import interval_text, markdown, percent, spread_text

DATA = {
    "encoder": "efficientnet-lite0",
    "weights_hash": "0" * 16,
    "simulated": True,
    "origin": "made by a test",
}


def record(method, source, seed, values, *, fold=None, **changes):
    """Return a record with one target for each value of ACC; Macro-F1 is 0.1 lower."""
    scores = [
        {"accuracy": v, "macro_f1": v - 0.1, "macro_f1_union": v - 0.2, "ece": 0.05} for v in values
    ]
    return {
        "method": method,
        "label": {"omnivat": "OmniVaT"}.get(method, method),
        "note": "",
        "source": source,
        "part": "",
        "seed": seed,
        "fold": fold,
        "data": DATA,
        "versions": {"torch": "2"},
        "parameters": 10,
        "seconds": 1.0,
        "missing_targets": [],
        "targets": {
            f"target {i}": {"part": "", "pairs": 9, "scores": {"fused": s, "vis": s, "tac": s}}
            for i, s in enumerate(scores)
        },
    } | changes


@pytest.fixture
def records():
    found = []
    for source, base in (("TAG-sim", 0.5), ("OF Real-sim", 0.6)):
        for seed in (0, 1, 2):
            found.append(record("omnivat", source, seed, [base + 0.1, base + 0.01 * seed]))
            found.append(record("linear_probe", source, seed, [base, base]))
    return found


def test_a_spread_has_n_minus_one_in_its_deviation():
    found = spread([1.0, 2.0, 4.0])
    assert found.mean == pytest.approx(7 / 3)
    assert found.std == pytest.approx(np.std([1, 2, 4], ddof=1))
    assert math.isnan(spread([1.0]).std)
    assert spread([]).n == 0


def test_the_t_interval_is_students_for_ten_known_values():
    """Sleep data of Student (1908): mean 1.58, 95 % interval 0.70 to 2.46."""
    sleep = [1.2, 2.4, 1.3, 1.3, 0.0, 1.0, 1.8, 0.8, 4.6, 1.4]
    found = t_interval(sleep)
    assert (round(found.mean, 2), round(found.low, 2), round(found.high, 2)) == (1.58, 0.7, 2.46)
    wide = t_interval([-1.0, 1.0, 0.5])
    assert wide.low < 0 < wide.high


def test_the_bootstrap_takes_sources_as_the_unit():
    """Many seeds that agree do not make two sources that disagree certain."""
    agreeing = {"A": [0.1] * 50, "B": [-0.05] * 50}
    found = bootstrap_interval(agreeing)
    assert found.mean == pytest.approx(0.025)
    assert (found.low, found.high) == (pytest.approx(-0.05), pytest.approx(0.1))
    assert t_interval([v for values in agreeing.values() for v in values]).low > 0


def test_the_bootstrap_repeats_and_needs_two_sources():
    values = {"A": [0.1, 0.2], "B": [0.3, 0.1]}
    assert bootstrap_interval(values) == bootstrap_interval(values)
    assert math.isnan(bootstrap_interval({"A": [0.1, 0.2]}).low)


def test_only_runs_that_both_have_are_paired():
    ours = {("A", 0): 0.5, ("A", 1): 0.7, ("B", 0): 0.9}
    theirs = {("A", 0): 0.4, ("B", 0): 0.8, ("C", 0): 0.1}
    found = paired_differences(ours, theirs)
    assert found == {"A": [pytest.approx(0.1)], "B": [pytest.approx(0.1)]}


def test_an_average_over_sources_waits_for_all_of_them(records):
    values = by_run(records[:-2], "omnivat", "accuracy")
    assert len(by_seed(values, ["TAG-sim", "OF Real-sim"])) == 2


def test_the_main_table_has_means_over_targets_and_deviations_over_seeds(records):
    row = next(line for line in main_table(records).splitlines() if line.startswith("| OmniVaT"))
    assert "56.0" not in row
    assert "55.5 ± 0.5 / 45.5 ± 0.5" in row  # TAG: (0.6 + 0.5 + 0.01 seed) / 2
    assert row.rstrip(" |").endswith("60.5 ± 0.5 / 50.5 ± 0.5")


def test_printed_figures_are_marked_where_the_data_differ(records):
    table = main_table(records)
    assert "printed: OmniVaT, ViT-B/16 *not comparable* (other data: ours are simulated)" in table
    assert "57.3 / 54.0" in table
    assert "other encoder" in not_comparable({"simulated": False, "encoder": "efficientnet-lite0"})


@pytest.mark.parametrize("encoder", BACKBONES)
def test_real_results_of_the_papers_encoders_are_comparable(encoder):
    """By the names that the project gives its encoders, not by names made up here."""
    assert encoder in ENCODERS
    data = {"simulated": False, "encoder": encoder}
    assert not_comparable(data) == ""
    assert (not_comparable(data, ablations=True) == "") == (encoder == "clip-vit-b16")
    rows = paper_rows(["TAG"], data)
    assert all(MARK not in row[0] and BACKBONES[encoder] in row[0] for row in rows)
    assert ["printed: OmniVaT, ViT-B/16", "56.2 / 53.7"] in [r[:2] for r in rows] or (
        encoder != "clip-vit-b16"
    )


def test_printed_single_targets_average_to_the_main_table():
    """All 48 rows of the eight tables: their mean is their average, and that is the main table's."""
    main, tables = paper()["main"]["ViT-B/16"], paper()["targets"]["ViT-B/16"]
    assert len(tables) == 8
    for source, methods in tables.items():
        assert len(methods) == 6
        for method, printed in methods.items():
            assert printed["average"] == main[method][source]
            for metric in (0, 1):
                values = [pair[metric] for name, pair in printed.items() if name != "average"]
                assert printed["average"][metric] == pytest.approx(np.mean(values), abs=0.06)


def test_the_lead_is_paired_and_its_n_printed(records):
    assert "+5.5 [5.0, 6.0] n=6" in interval_table(records)


def test_the_most_cautious_interval_counts_a_source_once():
    """Leads of 8 and 3 in every seed: Student's t of two means is 5.5 ± 12.706 x 2.5."""
    records = [
        record(method, source, seed, [0.5 + (lead if method == "omnivat" else 0)])
        for method in ("omnivat", "linear_probe")
        for source, lead in (("TAG-sim", 0.08), ("OF Real-sim", 0.03))
        for seed in (0, 1, 2)
    ]
    (row,) = (line for line in interval_table(records).splitlines() if "linear_probe" in line)
    assert row.count("+5.5 [-26.3, 37.3]") == 2


def test_a_record_run_again_replaces_the_older(records):
    newer = record("omnivat", "TAG-sim", 0, [1.0, 1.0])
    assert "| TAG-sim | 73.3 / 63.3 |" in protocol_report([*records, newer])  # (1 + .6 + .6) / 3


def test_what_did_not_run_is_told_with_its_reason(records):
    missing = {k: v for k, v in record("promptstyler", "TAG-sim", 0, []).items() if k != "targets"}
    text = protocol_report([*records, missing | {"skipped": "No text.", "parameters": 0}])
    assert "- promptstyler did not run: No text." in text


def test_evidence_and_targets_never_mix(records):
    folds = [
        record("omnivat", "TAG-sim", 0, [], fold=0)
        | {"targets": {"held out": target(0.9), "axes 0": target(0.5), "spread 0": target(0.7)}}
    ]
    assert "90.0" not in protocol_report([*records, *folds])
    text = evidence_report([*records, *folds])
    assert "| OmniVaT | 90.0 | 80.0 | 60.0 | 50.0 |" in text
    assert evidence_report(records) == "No evidence yet.\n"


def target(value):
    scores = {"accuracy": value, "macro_f1": value - 0.1}
    return {"part": "", "pairs": 4, "scores": {"fused": scores}}


def test_no_records_give_a_sentence():
    assert protocol_report([]) == "No runs yet.\n"


def test_the_papers_figures_are_means_of_what_it_prints():
    """Every printed average is the plain mean of the eight sources, rounding apart."""
    for methods in paper()["main"].values():
        for printed in methods.values():
            for metric in (0, 1):
                values = [pair[metric] for name, pair in printed.items() if name != "average"]
                assert len(values) == 8
                assert printed["average"][metric] == pytest.approx(np.mean(values), abs=0.16)


def test_figures_are_written_with_one_digit_and_bars_escaped():
    assert percent(0.5) == "50.0"
    assert percent(math.nan) == "–"
    assert spread_text(Spread(mean=0.5, std=0.012, n=3)) == "50.0 ± 1.2"
    assert interval_text(Interval(mean=0.021, low=-0.004, high=0.046, n=6)) == "+2.1 [-0.4, 4.6]"
    assert markdown(["a"], [["x|y"]]).endswith("| x\\|y |")


def test_a_plot_is_a_picture_with_a_name_and_a_point_for_every_value():
    series = {"ACC": [Spread(mean=50, std=2, n=3), Spread(mean=60, std=math.nan, n=1)]}
    root = ElementTree.fromstring(line_plot("p & q", "p", ["0", "0.5"], series))
    names = [element.tag.rsplit("}", 1)[1] for element in root.iter()]
    assert root.find("{http://www.w3.org/2000/svg}title").text == "p & q"
    assert names.count("circle") == 2
    heights = [float(e.get("cy")) for e in root.iter() if e.tag.endswith("circle")]
    assert heights[1] < heights[0]  # more is higher


def test_a_plot_without_values_is_still_a_picture():
    nothing = Spread(mean=math.nan, std=math.nan, n=0)
    assert ElementTree.fromstring(line_plot("t", "p", ["0"], {"ACC": [nothing]})) is not None


def _layout(*names):
    """Return ablations as the command hands them to the report."""
    return {
        name: {
            "title": ABLATIONS[name].title,
            "axis": ABLATIONS[name].axis,
            "sources": ABLATIONS[name].sources,
            "rows": {
                row: (method_name(row), one.label, one.value)
                for row, one in ABLATIONS[name].rows.items()
            },
        }
        for name in names
    }


def test_only_settings_that_differ_from_the_defaults_are_named():
    head = {"classes": ["a", "b"], "input_width": 8, "width": 64, "levels": 3}
    one = record("omnivat", "TAG-sim", 0, [0.5], settings={"head": head, "train": {"epochs": 60}})
    assert changed_settings(one) == "width=64 epochs=60"
    assert "settings width=64 epochs=60." in protocol_report([one])


def test_an_ablation_over_several_sources_has_their_average_and_no_empty_columns(tmp_path):
    """Spread over seeds of the mean over sources: 50 and 60 at seed 0, 2 more at seed 1."""
    table = ABLATIONS["fixed_order"]
    found = [
        record(method_name(row), f"{source}-sim", seed, [0.5 + 0.1 * (index % 2) + 0.02 * seed])
        for row in table.rows
        for index, source in enumerate(table.sources)
        for seed in (0, 1)
    ]
    text = write_ablations(found, _layout("fixed_order"), tmp_path)
    line = next(x for x in text.splitlines() if x.startswith("| p = 0.3 (fixed)"))
    assert line.endswith("| 56.0 ± 1.4 / 46.0 ± 1.4 | 10 |")
    assert "printed" not in text
    points = json.loads((tmp_path / "fixed_order.json").read_text())
    assert points["0.3"] == [0.51, 0.0141]  # of TAG alone
    assert list(points) == [f"{tenth / 10:g}" for tenth in range(11)]
    assert "mean of 2 sources" in (tmp_path / "fixed_order.svg").read_text()


def test_ablation_tables_stand_beside_the_printed_figures(tmp_path):
    table = ABLATIONS["class_token"]
    found = [
        record(method_name(row), source, seed, [0.5 + 0.01 * seed])
        for row in table.rows
        for source in ("TAG-sim", "OF 2.0 A-sim")
        for seed in (0, 1)
    ]
    order = ABLATIONS["order"]
    found += [record(method_name(row), "TAG-sim", 0, [0.5]) for row in order.rows]
    layout = _layout("class_token", "order")
    text = write_ablations(found, layout, tmp_path)
    line = next(x for x in text.splitlines() if x.startswith("| OmniVaT (without class token)"))
    assert "50.5 ± 0.7 / 40.5 ± 0.7 | 55.8 / 53.5" in line
    assert "58.3 / 57.7" in line
    assert "printed, ViT-B/16 *not comparable*" in text
    assert (tmp_path / "order.svg").read_text().count("<circle") == 14


def answered_record(method, source, seed, share, *, reading_shares=None):
    """Return a record with kept predictions: of 40 objects of two classes, a share is right."""
    truth = "0" * 20 + "1" * 20

    def answers(right):
        count = round(20 * right)
        return ("0" * count + "1" * (20 - count)) + ("1" * count + "0" * (20 - count))

    readings = {"fused": share, "vis": share, "tac": 0.5} | (reading_shares or {})
    scores = {
        n: {"accuracy": v, "macro_f1": v, "macro_f1_union": v, **dict.fromkeys(MEASURES, 0.1)}
        for n, v in readings.items()
    }
    target = {
        "part": "",
        "pairs": 40,
        "scores": scores,
        "fusions": {"mean": {"accuracy": share, "macro_f1": share}},
        "margins": {"vis": 0.1, "tac": None, "pair": 0.2},
        "truth": truth,
        "objects": "0-39",
        "answers": {n: answers(v) for n, v in readings.items()},
    }
    found = record(method, source, seed, [], targets={"t": target}, classes=["a", "b"])
    return found | {"chosen": {}, "temperature": {"fused": 1.5}, "settings": {"calibrate": True}}


MEASURES = ("ece", "nll", "aurc", "ece_raw", "nll_raw", "aurc_raw")


def grid(method, share, **changes):
    return [
        answered_record(method, source, seed, share, **changes)
        for source in ("A", "B", "C")
        for seed in (0, 1)
    ]


def test_the_headline_names_the_best_other_row_whichever_modality_it_uses():
    found = grid("omnivat", 0.8) + grid("linear_probe", 0.6, reading_shares={"vis": 0.9})
    text = protocol_report(found)
    assert "OmniVaT 80.0; best of 3 other rows: linear_probe, photo only, 90.0" in text
    assert "Difference -10.0" in text


def test_resampled_metrics_are_those_of_the_records():
    found = grid("omnivat", 0.75)
    drawn = draws_for(found, draws=200)
    values = resampled(found, ("omnivat", "fused"), drawn)
    assert values["accuracy"].value == pytest.approx(0.75)
    assert values["macro_f1"].value == pytest.approx(0.75)
    assert values["accuracy"].draws.mean() == pytest.approx(0.75, abs=0.02)


def test_test_objects_that_are_reused_count_once():
    """Six runs that share 40 objects are as uncertain as one: sd of a mean of 40 at 0.75."""
    found = grid("omnivat", 0.75)
    draws = resampled(found, ("omnivat", "fused"), draws_for(found, draws=2000))["accuracy"].draws
    assert draws.std() == pytest.approx((0.75 * 0.25 / 40) ** 0.5, rel=0.1)


def test_simultaneous_intervals_are_wider_than_single_ones_and_grow_with_the_rows():
    found = grid("omnivat", 0.8)
    for number in range(12):
        found += grid(f"other {number}", 0.5 + 0.02 * number)
    drawn = draws_for(found, draws=500)
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


def test_side_tables_show_confidence_margins_and_fusions():
    text = protocol_report(grid("omnivat", 0.8))
    assert "10.0 → 10.0 | 0.10 → 0.10 | 10.0 → 10.0 | 1.50" in text
    assert "20.0 / 10.0 / –" in text
    assert "| OmniVaT | 80.0 / 80.0 |" in text
