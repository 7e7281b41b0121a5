"""Whether a session's voltage was held before its readings, as a sheet at rest asks for."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from labrig.session import RecordedSession
from protocols.planning.schedule import PlannedRun, ReadingKind

# How long a voltage has to be held before a reading, that its electrodes are about charged: the
# paper samples 0.5 s after an edge, and Nafion's charge in tens of milliseconds.
HELD_S = 0.1


def held_voltage_warnings(session: RecordedSession) -> list[str]:
    """Return a sentence where most readings were taken while the voltage changed."""
    held = [
        held_s >= HELD_S
        for run in session.runs
        if run.started and run.planned.measures
        for held_s in _held_s(run.planned)
    ]
    if not held or 2 * sum(held) >= len(held):
        return []
    text = (
        f"The voltage changed less than {HELD_S:g} s before most readings. fit and diagnose take"
        " the sheet as at rest, so that EIBM at a voltage includes the lag of its electrodes, and"
        " this lag may be taken for another effect in time. `labrig fit --dynamic` identifies the"
        " sheet in time where a free release was recorded, too ([extras] release = true)."
    )
    return [text]


def _held_s(run: PlannedRun) -> Iterator[float]:
    """Yield for each kept reading under voltage how long its voltage had been held, s."""
    voltage_V = np.array([step.voltage_V for step in run.steps])
    changed = np.concatenate([[True], np.diff(voltage_V) != 0.0])
    since_s = np.maximum.accumulate(np.where(changed, [step.time_s for step in run.steps], -np.inf))
    for reading in run.readings:
        if reading.kind is ReadingKind.KEPT and reading.voltage_V:
            yield run.time_of(reading) - float(since_s[reading.step])
