"""A stage whose travel does not hold the protocol is told before the session begins."""

from __future__ import annotations

import math

import pytest

from labrig.experiment.preflight import stage_checks
from protocols import Place, make_schedule
from protocols.kinds.pulse_train import PulseTrain

SCHEDULE = make_schedule(PulseTrain(), [Place("long", (0.0, 0.015, 0.03))])


class Stage:
    """A positioner that knows nothing of its travel."""

    def open(self) -> None:
        pass

    def move_to(self, position_m: float) -> bool:
        return True

    def position(self) -> float | None:
        return None

    def close(self) -> None:
        pass


class Limited(Stage):
    def __init__(self, low_m: float, high_m: float) -> None:
        self.ends_m = low_m, high_m

    def travel_m(self) -> tuple[float, float]:
        return self.ends_m


@pytest.mark.parametrize(
    ("low_m", "high_m", "found", "ok", "warning"),
    [
        (-0.005, 0.05, "-5.00 to 50.00 mm", True, False),
        (0.0, 0.05, "0.00 to 50.00 mm, without -2 mm, from where repeated runs approach",
         True, True),
        (-0.005, 0.02, "-5.00 to 20.00 mm, without 30 mm", False, False),
    ],
)  # fmt: skip
def test_the_travel_holds_all_positions(low_m, high_m, found, ok, warning):
    (check,) = stage_checks(Limited(low_m, high_m), SCHEDULE)
    assert (check.found, check.ok, check.warning) == (found, ok, warning)
    assert check.wanted == "0 to 30 mm (protocol.toml)"


@pytest.mark.parametrize("ends", [None, 0.06, (0.0, 0.03, 0.06), (0.0, math.nan)])
def test_a_travel_that_is_no_two_numbers_is_not_ready_and_says_what_was_returned(ends):
    stage = Limited(0.0, 0.0)
    stage.ends_m = ends
    (check,) = stage_checks(stage, SCHEDULE)
    assert not check.ok
    assert check.found == f"its travel_m returned {ends!r}"
    assert check.wanted == "its lower and its upper end, in m"


def test_a_travel_of_many_metres_is_asked_for_its_unit():
    (check,) = stage_checks(Limited(0.0, 60.0), SCHEDULE)
    assert not check.ok
    assert check.found == "0 to 60 m: is it in mm?"


def test_a_stage_that_does_not_know_its_travel_is_not_asked():
    assert list(stage_checks(Stage(), SCHEDULE)) == []
