"""Which of the fits of an effect's shapes is taken."""

from __future__ import annotations

import pytest

from model.discrepancy.search.refinement import preferred

GOOD, BETTER, BEST = 103.0, 100.0, 80.0  # deviances: the first two are about as good


@pytest.mark.parametrize(
    ("one", "other"),
    [
        ((GOOD, 0.01), (BETTER, 0.3)),  # what needs no deviation from its form
        ((BETTER, 0.1), (GOOD, 0.3)),
        ((BEST, 0.3), (BETTER, 0.01)),  # what explains more
        ((BETTER, 0.7), (BEST, 0.8)),  # what is not mostly deviation
    ],
)
def test_of_shapes_that_explain_as_much_the_one_nearest_to_its_form_is_taken(one, other):
    assert preferred(one, other)
    assert not preferred(other, one)
