"""A sheet that changes from one set-up to the next: its scatter has an order."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.worlds.cases import THOROUGH
from benchmarks.worlds.registry import world
from model.discrepancy import diagnose
from model.discrepancy.search.order_of_positions import positions_in_order
from model.identification.data.data_vector import data_vector_of
from model.measurements import Condition, Measurements
from tests.model.discrepancy.sessions import Case, Extras, base_fit, session


@pytest.mark.slow
def test_a_stiffness_that_changes_between_the_runs_is_named_not_called_scatter():
    """Its straight line leaves scatter of 2 % of B, where 1 % is usual, and was not fitted."""
    measured = world("moving").measure(THOROUGH, {"stiffer_with_time": 0.8}, 11)
    found = diagnose(measured)
    assert [one.name for one in found.effects] == ["stiffness_drift"]
    assert found.unknown is None
    p = found.effects[0].parameters
    assert p["since_wetting"].value == 2.0
    assert p["relative_change"].value == pytest.approx(0.8, abs=0.1)
    assert found.scatter["stiffness"] < 0.02


def test_positions_are_in_order_unless_one_is_measured_again_or_amid_others():
    assert positions_in_order(base_fit().problem.forward.data_vectors)
    for extras in (Extras(remounts=2), Extras(random_order=True)):
        measured = session(Case(seed=1, extras=extras))
        assert not positions_in_order([data_vector_of(measured, "long")]), extras


def test_a_run_begins_at_one_time_for_all_of_its_readings():
    measured = timed(session())
    seen = data_vector_of(measured, "long").seen
    own = [s.clock for s in seen if s.run == seen[-1].run]
    began = np.concatenate([np.atleast_1d(clock.run_began) for clock in own])
    assert np.ptp(began) < 1e-9
    assert np.ptp(np.concatenate([clock.session for clock in own])) > 1e-3


def timed(measured: Measurements) -> Measurements:
    """Return measurements whose runs are a minute apart."""
    runs = list(dict.fromkeys(map(_run, measured.conditions)))

    def when(c: Condition) -> Condition:
        begun_s = 60.0 * runs.index(_run(c))
        return replace(c, readings=tuple(
            replace(r, time_s=0.6 * r.index, session_s=begun_s + 0.6 * r.index) for r in c.readings
        ))  # fmt: skip

    return replace(measured, conditions=tuple(map(when, measured.conditions)))


def _run(c: Condition) -> tuple[object, ...]:
    return c.configuration, c.position_m, c.mounting, c.run
