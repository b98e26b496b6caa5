"""Names of materials: one spelling, and what other names count as."""

from itertools import product

import pytest
from hypothesis import given
from hypothesis import strategies as st

from omnivat.data.materials import MATERIALS, class_key, in_order, ruled, rules, rules_in_text


@pytest.mark.parametrize("name", ["Wood", "wood ", " WOOD", "\twood\n", "ｗｏｏｄ"])
def test_case_blanks_and_look_alikes_make_no_new_class(name):
    assert class_key(name) == "wood"


@given(st.text(st.sampled_from("Wo -\t\u00a0\u200b\u0301éßſİıǅﬁｗ℀ΐ①한\ud800\U0001f600")))
def test_a_spelling_is_its_own_spelling(name):
    assert class_key(class_key(name)) == class_key(name)


def test_the_five_come_first_and_the_others_sorted():
    assert in_order({"felt", "glass", "bark", "wood"}) == ("wood", "glass", "bark", "felt")


@pytest.mark.parametrize("source", ["touch_and_go", "objectfolder", "tacquad"])
def test_every_rule_leads_to_one_of_the_five_and_says_why(source):
    assert rules(source)
    for raw, rule in rules(source).items():
        assert rule.raw == raw == class_key(raw)
        assert rule.material in (*MATERIALS, "")
        assert rule.grade in ("read", "inferred", "chosen")
        assert rule.why


def test_strict_leaves_out_what_is_merged():
    iron = rules("objectfolder")["iron"]
    assert ruled(iron, "iron", strict=False) == ("steel", "")
    assert ruled(iron, "iron", strict=True) == ("", "strict: iron is not steel itself")
    assert ruled(None, "rubber", strict=False) == ("", "rubber: none of the five materials")


def found(text, glued=False):
    return {rule.material for rule in rules_in_text(text, "tacquad", glued=glued)}


@pytest.mark.parametrize(
    "text", ["galss", "lgass", "glasss", "Glass", "glass3", "a_glass_cup", "GLASS."]
)
def test_a_slip_of_the_keyboard_is_forgiven(text):
    assert found(text) == {"glass"}


@pytest.mark.parametrize(
    "text", ["grass", "class", "brass", "glasses", "glasscup", "medal", "wod", ""]
)
def test_another_word_is_not_a_slip(text):
    assert found(text) == set()


def test_a_word_glued_to_another_is_found_on_request():
    assert found("glasscup", glued=True) == {"glass"}
    assert found("teaglass", glued=True) == {"glass"}


def test_steel_itself_counts_before_what_is_merged_with_it():
    (rule,) = rules_in_text("an iron and steel rail", "tacquad")
    assert rule.named == "steel"


def test_no_word_is_a_slip_of_a_word_for_another_material():
    words = rules("tacquad")
    for one, other in product(words, words):
        if words[one].material != words[other].material:
            assert words[other] not in rules_in_text(one, "tacquad")
