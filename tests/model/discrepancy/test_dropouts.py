"""Readings that lack the same share of the EIBM are found, and are neither noise nor outliers."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from benchmarks.wordings import Wording, worded
from benchmarks.worlds.cases import Task, made
from model.discrepancy import diagnose
from model.identification.data.data_vector import data_vector_of
from model.identification.data.outlier_readings import without_outliers
from model.identification.reading_patterns.kinds.dropouts import dropped_readings
from model.measurements import Condition, Measurements
from tests.model.discrepancy.sessions import session


def found(m: Measurements) -> int:
    dropped = dropped_readings([data_vector_of(m, name) for name in m.sheets])
    return int(sum(map(np.sum, dropped.values())))


def with_dropouts(m: Measurements, missing: float, chance: float = 0.15) -> Measurements:
    """With readings at random, under voltage, that lack a share of what the EIBM adds."""
    rng = np.random.default_rng(5)
    rest = {(c.configuration, c.position_m): np.mean(c.forces_N())
            for c in m.conditions if not c.voltage_V}  # fmt: skip

    def dropped(c: Condition) -> Condition:
        by_eibm_N = np.mean(c.forces_N()) - rest[c.configuration, c.position_m]
        readings = [
            replace(r, force_N=r.force_N - (rng.random() < chance) * missing * by_eibm_N)
            for r in c.readings
        ]
        return replace(c, readings=tuple(readings)) if c.voltage_V else c

    return replace(m, conditions=tuple(map(dropped, m.conditions)))


def moved(m: Measurements, size_N: float, *, places: tuple[int, ...], voltages=(-2.0, 2.0)):
    """With the kept readings at some places of the order moved, in all conditions."""

    def more(c: Condition) -> Condition:
        kept = c.used()
        those = {id(kept[i]) for i in places if i < len(kept)}
        readings = (replace(r, force_N=r.force_N + size_N) if id(r) in those else r
                    for r in c.readings)  # fmt: skip
        return replace(c, readings=tuple(readings)) if c.voltage_V in voltages else c

    return replace(m, conditions=tuple(map(more, m.conditions)))


@pytest.mark.parametrize("missing", [0.15, 0.6])
def test_readings_that_lack_a_share_of_the_eibm_are_found_and_are_no_outliers(missing):
    m = with_dropouts(session(), missing)
    kept = sum(len(c.used()) for c in m.conditions if c.voltage_V)
    assert 0.08 * kept < found(m) < 0.22 * kept
    assert without_outliers(m).readings == 0


def test_a_transient_at_the_same_place_of_each_run_is_no_dropout():
    assert found(moved(session(), 4e-4, places=(0,))) == 0


def test_what_is_the_same_at_both_polarities_is_no_dropout():
    m = session()
    odd = [replace(c) if i % 2 else moved(replace(m, conditions=(c,)), 4e-4, places=(i % 7,))
           .conditions[0] for i, c in enumerate(m.conditions)]  # fmt: skip
    assert found(replace(m, conditions=tuple(odd))) == 0


def test_stray_readings_are_left_out_all_the_same():
    m = session()
    wild = moved(replace(m, conditions=m.conditions[1:2]), 5e-3, places=(3,))
    m = replace(m, conditions=(m.conditions[0], *wild.conditions, *m.conditions[2:]))
    assert found(m) == 0
    assert without_outliers(m).readings == 1


def test_a_session_without_any_has_none():
    assert found(session()) == 0


def test_they_are_something_unknown_in_the_course_of_time():
    opens = Wording(
        effect="eibm_drift", words="a contact that opens", acts={"cases": lacking_at_times}
    )
    hidden = (("eibm_drift", 60.0),)
    task = Task(key="", world="elements", family="single", hidden=hidden, thorough=False, seed=7)
    made_of = made(task, worded(opens))
    diagnosis = diagnose(made_of.session)
    assert diagnosis.verdict == "unknown_effect"
    assert diagnosis.unknown is not None
    assert diagnosis.unknown.location == "time"
    size = made_of.sizes["eibm_drift"]
    assert np.allclose(diagnosis.unknown.profile, -size, atol=0.3 * size)
    assert "a part of the EIBM is missing); its size is -0.1" in diagnosis.sentence


def lacking_at_times(cases, at, _sheet, size):
    """Return a tenth of the pulses, in no order, in which the EIBM is smaller."""
    missing = (at.pulse >= 0) & ((at.pulse * 7919 + at.run * 104729) % 97 < 12)
    cases.moment_Nm *= 1.0 - size * missing
