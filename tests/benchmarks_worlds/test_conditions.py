"""What is asked about is asked of the session that was recorded."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import pytest

from benchmarks.worlds.cases import PAPER, THOROUGH
from benchmarks.worlds.conditions import unmeasured
from benchmarks.worlds.contract import Design
from model.measurements import Condition, Curve, Measurements, Reading

pytestmark = pytest.mark.thorough

RUN_S = 60.0


@dataclass(frozen=True)
class Clockwork:
    """A world whose forces say, in seconds, when the middle of the session is."""

    lost_m: float = np.inf  # what is farther out slips out of the rolls

    def measure(self, design: Design, _hidden, _seed, *, exact: bool = False) -> Measurements:
        """Return a session."""
        assert exact
        places = [
            (name, at_m, turn)
            for name, positions in design.positions_m.items()
            for turn, own in enumerate(
                ([None] * design.free_shapes + [*positions], positions[: design.remounts])
            )
            for at_m in own
        ]
        middle_s = 0.5 * RUN_S * len(places)
        conditions = tuple(
            self._condition(*place, volts, middle_s)
            for place in places
            for volts in (0.0, *design.voltages_V)
        )
        return Measurements(sheets={}, conditions=conditions)

    def _condition(self, name, at_m, mounting, volts, middle_s) -> Condition:
        held = at_m is None or at_m < self.lost_m
        reading = Reading(index=0, kind="kept", force_N=middle_s + mounting, valid=held)
        s = np.linspace(0.0, 0.05, 5)
        curve = Curve(s_m=s, x_m=s, y_m=0.0 * s) if held else None
        return Condition(
            configuration=name, position_m=at_m, voltage_V=volts, readings=(reading,),
            curve=curve, mounting=mounting,
        )  # fmt: skip


@pytest.mark.parametrize(
    "design", [PAPER, THOROUGH, replace(PAPER, positions_m={"long": (0.0, 0.01, 0.02)})]
)
def test_the_time_asked_about_is_amid_the_session_that_was_recorded(design: Design) -> None:
    runs = sum(len(p) + design.free_shapes + design.remounts for p in design.positions_m.values())
    found = unmeasured(Clockwork(), {}, 1, design)  # type: ignore[arg-type]
    assert found
    assert {one.force_N for one in found} == {0.5 * RUN_S * runs}


def test_what_cannot_be_reached_is_not_asked_about() -> None:
    every, some = (
        unmeasured(Clockwork(lost), {}, 1, PAPER)  # type: ignore[arg-type]
        for lost in (np.inf, 0.026)
    )
    assert len(every) == 20
    lost = [one for one in every if one.position_m >= 0.026]
    assert lost
    assert len(some) == len(every) - len(lost)
