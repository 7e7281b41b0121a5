"""Conformance of a pattern in the readings: `faults` returns what is wrong with it.

A pattern is tried on noise alone, in which none may be found. What one looks like when it is there,
its author knows.
"""

from __future__ import annotations

from collections.abc import Iterator
from functools import partial

import numpy as np

from model.identification.data.data_vector import data_vector_of
from model.identification.reading_patterns.contract import ReadingPattern, ReadingsOfCondition
from model.locations.examples import example_sheet
from model.measurements import Condition, Measurements, Reading, RigScale
from model.plugins import first_faults

POSITIONS_M, READINGS, NOISE_N = (0.005, 0.015, 0.025), 10, 2e-5
FORCES_N = {0.0: -1e-3, 2.0: 2e-3, -2.0: -3e-3}  # by voltage
TRIES = 5


def faults(pattern: object) -> list[str]:
    """Return what is wrong with a pattern, a sentence each without its full stop."""
    if not isinstance(pattern, ReadingPattern):
        kind = "model.identification.reading_patterns.ReadingPattern"
        return [f"it is of type {type(pattern).__name__}, not a {kind}"]
    return first_faults(partial(check, pattern) for check in (_description, _in_noise))


def _description(pattern: ReadingPattern) -> Iterator[str]:
    if not (isinstance(pattern.name, str) and pattern.name.isidentifier()):
        yield f"its name {pattern.name!r} must be one word of letters, digits and underscores"
    if not (isinstance(pattern.meaning, str) and pattern.meaning.strip()):
        yield "its meaning is empty"
    if not isinstance(pattern.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]
    if type(pattern).found_in is ReadingPattern.found_in:
        yield "it has no `found_in`: nothing would ever be found"


def _in_noise(pattern: ReadingPattern) -> Iterator[str]:
    for seed in range(TRIES):
        measured = _noise(seed)
        if pattern.found_in([data_vector_of(measured, "long")], RigScale()) is not None:
            yield "`found_in` finds it in readings that are noise alone"
            return
        conditions = [
            ReadingsOfCondition(
                force_N=np.array([r.force_N for r in one.readings]),
                by_eibm_N=FORCES_N[one.voltage_V] - FORCES_N[0.0],
            )
            for one in measured.conditions
        ]
        flags = pattern.not_outliers(conditions)
        shapes = [np.shape(one) for one in flags]
        if shapes != [(READINGS,)] * len(conditions):
            yield "`not_outliers` must return a truth value for each reading of each condition"
            return
        if any(map(np.any, flags)):
            yield "`not_outliers` is true of readings that are noise alone"
            return


def _noise(seed: int) -> Measurements:
    """Return a session in which the readings of each condition differ by noise alone."""
    rng = np.random.default_rng(seed)
    conditions = []
    for run, position_m in enumerate(POSITIONS_M):
        for number, (voltage_V, force_N) in enumerate(FORCES_N.items()):
            readings = [
                Reading(
                    index=READINGS * number + i,
                    kind="kept" if voltage_V else "zero",
                    force_N=force_N + NOISE_N * rng.standard_normal(),
                    time_s=0.6 * (READINGS * number + i),
                    session_s=60.0 * run + 0.6 * (READINGS * number + i),
                )
                for i in range(READINGS)
            ]
            conditions.append(
                Condition(
                    configuration="long", position_m=position_m, voltage_V=voltage_V, run=run,
                    readings=tuple(readings),
                )
            )  # fmt: skip
    return Measurements(sheets={"long": example_sheet()}, conditions=tuple(conditions))
