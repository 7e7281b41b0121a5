"""What comes again and again is found by its period and phase; noise and wander are not."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.identification.data.data_vector import data_vector_of
from model.identification.reading_patterns.contract import ReadingsOf
from model.identification.reading_patterns.kinds.periodic import (
    PeriodicTerm,
    cosine,
    cosines_and_sines,
    periodic_term_in,
    sine,
)
from model.measurements import Measurements
from tests.cases import few
from tests.model.discrepancy.sessions import NOTHING, Case, Hiding, diagnosed, session

BEATING = Case((Hiding("beating_cell", size=0.3),), seed=11)
BREATHING = Case((Hiding("breathing_eibm", size=0.02),), seed=12)
WANDERING = Case(correlated=True, seed=13)


def data_vectors(m: Measurements):
    return [data_vector_of(m, name) for name in m.sheets]


def beating(m: Measurements, size_N: float, period_s: float, since: str) -> Measurements:
    """With a wave in all forces, by one of the clocks."""

    def more(reading):
        at = getattr(reading, since)
        return replace(
            reading, force_N=reading.force_N + size_N * np.sin(2 * np.pi * at / period_s)
        )

    conditions = [replace(c, readings=tuple(map(more, c.readings))) for c in m.conditions]
    return replace(m, conditions=tuple(conditions))


@pytest.mark.slow
@pytest.mark.parametrize(
    ("since", "clock"), few([("time_s", "run"), ("session_s", "session")], first=2)
)
@pytest.mark.parametrize("period_s", few([1.9, 3.3, 5.1], first=2))
def test_a_wave_in_the_forces_is_found_with_its_period_and_size(since, clock, period_s):
    found = periodic_term_in(data_vectors(beating(session(), 2e-4, period_s, since)))
    assert found is not None
    assert (found.what, found.since) == ("force", clock)
    assert found.period_s == pytest.approx(period_s, rel=0.01)
    assert np.hypot(*found.amplitudes) == pytest.approx(2e-4, rel=0.15)


@pytest.mark.slow
@pytest.mark.parametrize("size_N", few([1.5e-5, 6e-5]))
def test_what_is_no_more_than_a_load_cell_s_wander_is_not_told(size_N):
    """A wander may have one rate above all others, so that it explains most of what is left."""
    assert periodic_term_in(data_vectors(beating(session(), size_N, 3.3, "time_s"))) is None


@pytest.mark.slow
@pytest.mark.parametrize("case", few([NOTHING, WANDERING]), ids=["quiet", "wandering"])
def test_where_nothing_comes_again_nothing_is_found(case):
    assert periodic_term_in(data_vectors(session(case))) is None


def test_a_few_readings_are_no_wave():
    m = beating(session(), 2e-4, 3.3, "time_s")
    few = replace(m, conditions=m.conditions[:2], sheets={"long": m.sheets["long"]})
    assert periodic_term_in(data_vectors(few)) is None


@pytest.mark.thorough
def test_an_eibm_that_breathes_is_seen_in_the_curves_where_the_forces_do_not_show_it():
    found = periodic_term_in(data_vectors(session(BREATHING)))
    assert found is not None
    assert found.what == "EIBM"
    assert np.hypot(*found.amplitudes) == pytest.approx(0.02, rel=0.3)


def test_what_a_wave_adds_to_the_force():
    one = data_vector_of(session(), "long").seen[0]
    clock = one.clock
    wave = PeriodicTerm(
        what="force", period_s=2.0, since="run", session_s=100.0, amplitudes=(3e-4, 4e-4)
    )
    phase = np.pi * clock.run_s
    readings = ReadingsOf(
        configuration="long", force_N=one.force_N, clock=clock,
        reading_of=np.zeros(len(one.force_N), dtype=np.int64),
    )  # fmt: skip
    added_N = one.force_N - wave.without(readings)
    np.testing.assert_allclose(added_N, 3e-4 * np.cos(phase) + 4e-4 * np.sin(phase), atol=1e-12)
    assert np.array_equal(replace(wave, what="EIBM").without(readings), one.force_N)


@pytest.mark.thorough
@pytest.mark.slow
@pytest.mark.parametrize(
    ("case", "location"),
    [(BEATING, "load_cell"), pytest.param(BREATHING, "time", marks=pytest.mark.thorough)],
)
def test_it_is_unknown_and_told_with_its_period(case, location):
    found = diagnosed(case)
    assert (found.verdict, found.effects) == ("unknown_effect", ())
    assert found.unknown.location == location
    assert "in the course of each period" in found.sentence
    assert found.unknown.s_mm[-1] < 12.0  # s
    assert found.fitted.after.chi2_per_dof < 1.3


@pytest.mark.parametrize("count", [1, 2, 41, 500])
def test_tables_of_periods_are_the_cosines_and_sines(count):
    at_s, rates = np.linspace(0.0, 900.0, 50), np.linspace(0.08, 0.8, 500)[:count]
    cosines, sines = cosines_and_sines(at_s, rates)
    np.testing.assert_allclose(cosines, cosine(at_s[:, None] * rates), atol=1e-10)
    np.testing.assert_allclose(sines, sine(at_s[:, None] * rates), atol=1e-10)
