"""Of sessions analysed together each has its own beginning: drifts begin anew, or go on."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from labrig.analysis.together import BETWEEN_S, together
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.effects import effect
from model.effects.conformance import faults
from model.identification.data.data_vector import DataVector, data_vector_of
from model.locations.examples import example_clock, example_weighed
from model.parameter import Parameter
from model.sheet.applied_effects import effect_of
from model.sheet.beam_problem import ActiveEffect
from tests.model.discrepancy.sessions import means_of, session

DRIFTS = ("force_drift", "stiffness_drift", "eibm_drift")


def two(measured=None) -> DataVector:
    """The same session twice, the second time only its first three runs."""
    whole = measured or session()
    runs = list(dict.fromkeys((c.configuration, c.position_m) for c in whole.conditions))[:3]
    some = (c for c in whole.conditions if (c.configuration, c.position_m) in runs)
    second = replace(whole, conditions=tuple(some), series=())
    return data_vector_of(together([(Path("a.h5"), whole), (Path("b.h5"), second)]), "long")


def times(of: DataVector, number: int) -> np.ndarray:
    """Return [time in its session, time over all] of all readings of a session."""
    clocks = [one.clock for one in of.seen if one.session == number]
    return np.concatenate([[c.session, np.broadcast_to(c.overall, c.session.shape)]
                           for c in clocks], axis=1)  # fmt: skip


@pytest.mark.slow
def test_the_time_in_a_session_begins_anew_and_that_over_all_goes_on():
    first, second = (times(two(), number) for number in (1, 2))
    assert first[0].min() == second[0].min() == 0.0
    n = second.shape[1]
    np.testing.assert_allclose(second[0], first[0][:n], atol=1e-12)  # as fast, though shorter
    assert first[1].max() < second[1].min() < second[1].max() <= 1.0


@pytest.mark.slow
def test_the_length_of_a_session_is_that_of_the_longest_one():
    assert two().session_s == pytest.approx(data_vector_of(session(), "long").session_s)
    assert two().session_s > BETWEEN_S / 10.0


def test_without_times_the_runs_of_each_session_are_counted_from_its_beginning():
    first, second = (times(two(means_of(session())), number) for number in (1, 2))
    n = second.shape[1]
    np.testing.assert_allclose(second[0], first[0][:n])
    assert first[1].max() < second[1].min() < second[1].max() < 1.0


@pytest.mark.slow
def test_a_session_without_times_has_the_order_of_its_runs_beside_one_with_times():
    for first, second in ((means_of(session()), session()), (session(), means_of(session()))):
        both = data_vector_of(together([(Path("a.h5"), first), (Path("b.h5"), second)]), "long")
        (one, whole), (other, later) = (times(both, number) for number in (1, 2))
        for own in (one, other):
            assert own.min() >= 0.0
            assert 0.3 < np.ptp(own) < 0.6  # of the long sheet, which is measured first
        assert whole.max() < later.min()
        assert later.max() <= 1.0


def test_of_one_session_both_times_are_the_same():
    for one in data_vector_of(session(), "long").seen:
        np.testing.assert_allclose(one.clock.overall, one.clock.session, atol=1e-12)


@pytest.mark.thorough
@pytest.mark.slow
def test_readings_of_a_later_session_come_after_all_of_the_first():
    whole = together([(Path("a.h5"), session()), (Path("b.h5"), session())])
    forward = prepare(whole, DiagnoseOptions()).problem.forward
    block, seen = forward.row_block(0), forward.data_vectors[0].seen
    day = np.array([seen[int(k)].session for k in block.reading_of[block.in_time]])
    assert np.all(np.diff(day) >= 0)


@pytest.mark.slow
@pytest.mark.parametrize("name", DRIFTS)
def test_a_drift_of_several_sessions_begins_anew_or_goes_on(name: str):
    assert "goes_on" not in {one.name for one in effect(name).parameters}
    both = effect(name).for_sessions(2)
    assert faults(both) == []
    assert both.parameters[-1].starting_values == (0.0, 1.0)
    assert effect(name).for_sessions(1) is effect(name)


def test_a_zero_that_drifts_on_is_that_of_the_time_over_all_sessions():
    weighed, drift = example_weighed(), effect("force_drift").for_sessions(2)
    later = replace(weighed, overall=0.5 + 0.5 * weighed.session)
    p = {"force_mN": 2.0, "settles": 0.0, "tared_at": 0.0}
    np.testing.assert_allclose(drift.force(later, {**p, "goes_on": 0.0}), 2e-3 * weighed.session)
    np.testing.assert_allclose(drift.force(later, {**p, "goes_on": 1.0}), 2e-3 * later.overall)


def test_a_stiffness_that_drifts_since_the_last_wetting_knows_no_session():
    clock, drift = example_clock(), effect("stiffness_drift").for_sessions(2)
    later = replace(clock, overall=0.5 + 0.5 * clock.session)
    p = {"relative_change": 0.2, "settles": 0.0}
    anew, on = (
        drift.course(later, {**p, "since_wetting": 0.0, "goes_on": goes})[1] for goes in (0.0, 1.0)
    )
    np.testing.assert_allclose(anew, 0.2 * (clock.session - 0.5))
    np.testing.assert_allclose(on, 0.2 * (later.overall - 0.5))
    wetted = [
        drift.course(later, {**p, "since_wetting": 1.0, "goes_on": goes})[1] for goes in (0.0, 1.0)
    ]
    np.testing.assert_array_equal(*wetted)


def test_a_model_file_keeps_that_a_drift_goes_on():
    own = {"force_mN": 1.0, "settles": 0.0, "tared_at": 0.0}
    on = ActiveEffect(name="force_drift", parameters=as_parameters({**own, "goes_on": 1.0}))
    assert effect_of(on).parameters[-1].name == "goes_on"
    once = ActiveEffect(name="force_drift", parameters=as_parameters(own))
    assert effect_of(once) is effect("force_drift")


def as_parameters(values: dict[str, float]) -> dict[str, Parameter]:
    return {name: Parameter(value=value, sigma=0.0, unit="") for name, value in values.items()}
