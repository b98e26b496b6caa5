"""References in requests, and the server's memory of images."""

from hypothesis import given
from hypothesis import strategies as st

from app.shared.state import Recent, ref_from
from omnivat.kit.errors import DataError

TEXT = st.text(st.sampled_from("row:image0f-9/ \n\0é\ud800\U0001f600"))


@given(st.one_of(TEXT, st.integers(), st.lists(TEXT), st.dictionaries(TEXT, TEXT)))
def test_whatever_is_sent_as_a_reference_is_read_or_refused_in_a_sentence(value):
    refused = ""
    try:
        ref_from(value)
    except DataError as error:
        refused = str(error)
    assert refused == "" or refused.endswith(".")


def test_the_least_recently_used_value_is_forgotten_first():
    recent = Recent(2)
    recent.keep("a", 1)
    recent.keep("b", 2)
    recent.get("a")
    recent.keep("c", 3)
    assert (recent.get("a"), recent.get("b"), recent.get("c")) == (1, None, 3)


def test_values_are_bounded_by_their_bytes_and_the_newest_stays():
    recent = Recent(9, room=10)
    assert recent.keep("a", "a", 6) == []
    assert recent.keep("b", "b", 6) == ["a"]
    assert recent.keep("c", "c", 99) == ["b"]
    assert recent.get("c") == "c"
