"""The eight domains, and which is tested on which (paper, Table of settings)."""

import pytest

from omnivat.data.domains import (
    DOMAINS,
    Place,
    is_simulated,
    paper_name,
    simulated,
    source_place,
    target_places,
)


def targets(name):
    return [f"{place.domain} {place.part}".strip() for place in target_places(name)]


def test_there_are_eight_domains_and_tacquad_has_no_ceramic():
    assert len(DOMAINS) == 8
    assert [name for name, domain in DOMAINS.items() if not domain.ceramic] == [
        "TQ-DIGIT", "TQ-GelMini", "TQ-DuraGel", "TQ-T3D",
    ]  # fmt: skip


def test_other_sources_are_tested_on_all_other_domains():
    assert targets("TAG") == list(DOMAINS)[1:]
    assert len(targets("OF Real")) == 7


@pytest.mark.parametrize(("one", "other"), [("OF 2.0 A", "OF 2.0 B"), ("OF 2.0 B", "OF 2.0 A")])
def test_a_and_b_are_not_tested_on_each_other(one, other):
    assert len(targets(one)) == 6
    assert other not in targets(one)


def test_a_tacquad_camera_trains_outdoors_and_is_tested_indoors():
    assert source_place("TQ-DIGIT") == Place("TQ-DIGIT", "outdoor")
    assert targets("TQ-DIGIT")[4:] == ["TQ-GelMini indoor", "TQ-DuraGel indoor", "TQ-T3D indoor"]


def test_tac3d_trains_indoors_and_is_tested_outdoors():
    assert source_place("TQ-T3D") == Place("TQ-T3D", "indoor")
    assert targets("TQ-T3D")[4:] == ["TQ-DIGIT outdoor", "TQ-GelMini outdoor", "TQ-DuraGel outdoor"]


def test_a_simulated_name_says_so_and_leads_back_to_the_papers():
    for name in DOMAINS:
        assert is_simulated(simulated(name))
        assert paper_name(simulated(name)) == name
        assert not is_simulated(name)
