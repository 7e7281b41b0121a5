"""Effects in the words of others, between the values that the catalogue tries, keep their name."""

from __future__ import annotations

import pytest

from benchmarks.wordings import WORDINGS, asked
from tests.fits_unchecked import fits_unchecked


@pytest.mark.slow
@pytest.mark.parametrize(
    ("effect", "words"),
    [
        # each with what it was before
        # with an error of the arc besides
        pytest.param("camera_perspective", "along 157 degrees", marks=pytest.mark.thorough),
        # something unknown: an error of the arc explained as much, and failed a check
        ("camera_perspective", "along -31 degrees"),
        # with an error of the arc besides
        pytest.param("camera_scale", "x longer, y shorter", marks=pytest.mark.thorough),
        ("force_drift", "tared a quarter into it"),  # something unknown
        pytest.param("roll_friction", "one way", marks=pytest.mark.thorough),  # something unknown
    ],
)
def test_its_name_stands_alone(effect: str, words: str):
    (wording,) = (one for one in WORDINGS if (one.effect, one.words) == (effect, words))
    with fits_unchecked():
        outcome, said = asked(wording, d=40.0, seed=7)
    assert outcome == "its name alone", said
