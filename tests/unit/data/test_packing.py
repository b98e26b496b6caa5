"""Labels and object numbers as short text."""

from omnivat.data.packing import compact, digits, unpacked


def test_ascending_runs_are_written_as_their_ends_and_read_again():
    numbers = [3, 4, 5, 9, 9, 1]
    assert compact(numbers) == "3-5 9 9 1" and unpacked("3-5 9 9 1") == numbers


def test_a_class_above_nine_is_a_letter():
    assert digits([0, 9, 10, 61]) == "09aZ"
