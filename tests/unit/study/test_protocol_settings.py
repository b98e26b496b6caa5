"""The eight settings, written out from the paper's table, and what they mean on a set of pairs."""

import numpy as np
import pytest

from omnivat.kit.errors import DataError
from omnivat.study.protocol.settings import SETTINGS, available, task

WHOLE = ("TQ-DIGIT", "TQ-GelMini", "TQ-DuraGel", "TQ-T3D")
TABLE = {
    "TAG": ("", {"OF Real": "", "OF 2.0 A": "", "OF 2.0 B": "", **dict.fromkeys(WHOLE)}),
    "OF Real": ("", {"TAG": "", "OF 2.0 A": "", "OF 2.0 B": "", **dict.fromkeys(WHOLE)}),
    "OF 2.0 A": ("", {"TAG": "", "OF Real": "", **dict.fromkeys(WHOLE)}),
    "OF 2.0 B": ("", {"TAG": "", "OF Real": "", **dict.fromkeys(WHOLE)}),
    "TQ-DIGIT": ("outdoor", {"TQ-GelMini": "indoor", "TQ-DuraGel": "indoor", "TQ-T3D": "indoor"}),
    "TQ-GelMini": ("outdoor", {"TQ-DIGIT": "indoor", "TQ-DuraGel": "indoor", "TQ-T3D": "indoor"}),
    "TQ-DuraGel": ("outdoor", {"TQ-DIGIT": "indoor", "TQ-GelMini": "indoor", "TQ-T3D": "indoor"}),
    "TQ-T3D": ("indoor", {"TQ-DIGIT": "outdoor", "TQ-GelMini": "outdoor", "TQ-DuraGel": "outdoor"}),
}


@pytest.mark.parametrize("source", TABLE)
def test_a_setting_is_the_papers_row(source):
    part, targets = TABLE[source]
    if source.startswith("TQ"):
        targets = {"TAG": "", "OF Real": "", "OF 2.0 A": "", "OF 2.0 B": "", **targets}
    setting = SETTINGS[source]
    assert setting.part == part
    assert setting.targets == {name: wanted or "" for name, wanted in targets.items()}
    assert setting.ceramic != source.startswith("TQ")


@pytest.fixture
def eight(make_embeddings):
    """All eight simulated domains with splits; TacQuad's with parts and without ceramic."""
    pairs = make_embeddings(
        domains=tuple(f"{name}-sim" for name in SETTINGS), per_class=8, split=True
    )
    domains = np.array(pairs.header.domains)[pairs.domain]
    tacquad = np.char.startswith(domains.astype(str), "TQ")
    ceramic = pairs.label == pairs.header.classes.index("ceramic")
    parts = [
        ("indoor" if i % 8 < 4 or "T3D" in name else "outdoor") if name.startswith("TQ") else ""
        for i, name in enumerate(domains)
    ]
    pairs.rows["part"] = parts
    return pairs.select(~(tacquad & ceramic))


def test_simulated_domains_stand_for_the_papers(eight):
    assert available(eight) == tuple(SETTINGS)
    found = task(eight, "TAG-sim")
    assert list(found.targets) == [f"{name}-sim" for name in SETTINGS if name != "TAG"]
    assert found.missing == ()


def test_a_tacquad_source_learns_outdoors_and_is_answered_indoors_without_ceramic(eight):
    found = task(eight, "TQ-DIGIT")
    assert found.classes == ("wood", "steel", "plastic", "glass")
    assert set(found.train.rows["part"]) == {"outdoor"}
    assert set(found.train.rows["split"]) == {"train"}
    assert set(found.targets["TQ-GelMini-sim"].rows["part"]) == {"indoor"}
    for pairs in found.targets.values():
        assert set(pairs.rows["split"]) == {"test"}
        assert pairs.header.classes.index("ceramic") not in pairs.label


def test_no_pair_is_learned_from_and_answered(eight):
    for source in SETTINGS:
        found = task(eight, source)
        learned = set(found.train.rows["tac"])
        answered = [*found.targets.values(), found.source_test]
        assert not any(learned & set(pairs.rows["tac"]) for pairs in answered)


def test_targets_that_the_data_lack_are_named(make_embeddings):
    found = task(make_embeddings(), "TAG")
    assert list(found.targets) == ["OF Real-sim"]
    assert "TQ-T3D" in found.missing


def test_an_unknown_source_is_refused_with_the_nearest(eight, make_embeddings):
    with pytest.raises(DataError, match="'TQ-DIGT' is not one .* Did you mean 'TQ-DIGIT'"):
        task(eight, "TQ-DIGT")
    with pytest.raises(DataError, match="The embeddings have no domain 'TQ-T3D'"):
        task(make_embeddings(), "TQ-T3D")


def test_domains_of_ones_own_learn_from_each_and_answer_all_others(make_embeddings):
    pairs = make_embeddings(domains=("lab", "field", "shop"), per_class=4)
    assert available(pairs) == ("lab", "field", "shop")
    found = task(pairs, "lab")
    assert list(found.targets) == ["field", "shop"]
    assert found.missing == ()


def test_a_target_without_any_class_that_was_learned_is_missing(make_embeddings):
    pairs = make_embeddings(domains=("lab", "field", "shop"), per_class=4)
    steel = pairs.header.classes.index("steel")
    at = [pairs.header.domains.index(name) for name in ("lab", "shop")]
    apart = pairs.select(
        (pairs.label != steel) & (pairs.domain != at[1])
        | (pairs.label == steel) & (pairs.domain != at[0]) & (pairs.domain == at[1])
    )
    found = task(apart, "lab")
    assert list(found.targets) == ["field"]
    assert found.missing == ("shop",)
    assert available(apart) == ("lab", "field")
