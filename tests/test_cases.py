"""Of a few cases the others are still there, for the thorough run."""

from __future__ import annotations

import pytest

from tests.cases import PARAM, few


def thorough(cases):
    """Values of those that only the thorough run tries."""
    return [
        case.values
        for case in cases
        if isinstance(case, PARAM) and pytest.mark.thorough in case.marks
    ]


def test_all_but_the_first_or_those_that_are_named_are_thorough():
    assert few("abc")[0] == "a"
    assert thorough(few("abc")) == [("b",), ("c",)]
    assert thorough(few("abc", first=2)) == [("c",)]
    assert thorough(few("abc", "c")) == [("a",), ("b",)]


def test_cases_of_several_values_and_with_marks_of_their_own_keep_them():
    marked = pytest.param(3, 4, marks=pytest.mark.slow, id="three")
    one, two = few([(1, 2), marked])
    assert one == (1, 2)
    assert two.values == (3, 4)
    assert two.id == "three"
    assert {mark.name for mark in two.marks} == {"slow", "thorough"}


def test_a_case_that_is_kept_must_be_one():
    with pytest.raises(AssertionError, match="is no case"):
        few("abc", "d")
