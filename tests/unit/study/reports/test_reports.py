"""Tables rebuilt from records, and the printed figures beside them."""

import pytest

from omnivat.encoders import ENCODERS
from omnivat.study.reports.paper import BACKBONES, MARK, not_comparable, paper_rows
from omnivat.study.reports.protocol_report import main_table, protocol_report
from omnivat.study.reports.reading import by_run, by_seed, changed_settings, completed
from omnivat.study.reports.reproduced import cost_report

from .made_records import grid, record


@pytest.fixture
def records():
    found = []
    for source, base in (("TAG-sim", 0.5), ("OF Real-sim", 0.6)):
        for seed in (0, 1, 2):
            found.append(record("omnivat", source, seed, [base + 0.1, base + 0.01 * seed]))
            found.append(record("linear_maps", source, seed, [base, base]))
    return found


def test_an_average_over_sources_waits_for_all_of_them(records):
    values = by_run(completed(records[:-2], "omnivat"), "accuracy")
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


def test_what_did_not_run_is_told_with_its_reason(records):
    missing = {k: v for k, v in record("promptstyler", "TAG-sim", 0, []).items() if k != "targets"}
    text = protocol_report([*records, missing | {"skipped": "No text.", "parameters": 0}])
    assert "- promptstyler did not run: No text." in text


def test_no_records_give_a_sentence():
    assert protocol_report([]) == "No runs yet.\n"


def test_only_settings_that_differ_from_the_defaults_are_named():
    head = {"classes": ["a", "b"], "input_width": 8, "width": 64, "levels": 3}
    one = record("omnivat", "TAG-sim", 0, [0.5], settings={"head": head, "train": {"epochs": 60}})
    assert changed_settings(one) == "width=64 epochs=60"
    assert "settings width=64 epochs=60." in protocol_report([one])


def test_costs_are_millions_of_parameters_seconds_of_a_fit_and_pairs_a_second(records):
    text = cost_report(records, {"encoder, s a pair": 0.5, "machine": "one CPU"})
    assert "| OmniVaT | 0.00 | 1.0 | 2.0 | – |" in text


def test_the_guard_of_lang_has_both_accuracies_and_their_gap():
    one = record("omnivat", "TAG-sim", 0, [0.5], lang_guard={"with": 0.9, "without": 0.7})
    assert "| OmniVaT | 90.0 | 70.0 | +20.0 |" in protocol_report([one])


def test_without_omnivat_nothing_is_compared_with_it():
    text = protocol_report(grid("linear_maps", 0.8) + grid("erm_mlp", 0.6))
    assert "| linear_maps |" in text and "best other row" not in text


def test_a_record_run_again_replaces_the_older(records):
    newer = record("omnivat", "TAG-sim", 0, [1.0, 1.0])
    assert "| TAG-sim | 73.3 / 63.3 |" in protocol_report([*records, newer])  # (1 + .6 + .6) / 3
