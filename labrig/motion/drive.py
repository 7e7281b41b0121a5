"""What drives a simulated sheet: the pulses of a protocol, a run of its schedule, or a table."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path

import numpy as np

from labrig.errors import BadArgumentError, BadInputError
from labrig.session.tables.csv_rows import CsvRow
from labrig.session.tables.drive_table import drive_rows, load_protocol
from model.dynamics import HeldVoltage
from protocols import Purpose, ReadingKind, ScheduleError
from protocols.kinds.fields import LARGEST_VOLTAGE_V
from protocols.planning.builder import StepsAndReadings
from protocols.planning.schedule import PlannedRun


@dataclass(frozen=True)
class SamplingPoint:
    """When a reading is taken, and under which voltage."""

    time_s: float
    voltage_V: float


@dataclass(frozen=True, kw_only=True)
class MotionDrive:
    """The voltage of a simulated run, its end, and the readings that a rig would take in it."""

    voltage: HeldVoltage
    end_s: float
    samples: tuple[SamplingPoint, ...] = ()
    planned: PlannedRun | None = None  # the run of a schedule that says where the sheet is held


def load_drive(path: Path, run: int | None) -> MotionDrive:
    """Return what a file says: protocol.toml (`run`: that one of its schedule), or a CSV table.

    Raises BadInputError.
    """
    if path.suffix.lower() != ".csv":
        return _of_protocol(path, run)
    if run is not None:
        raise BadArgumentError(
            f"run {run}: {path} is a table; leave run out, which is of a protocol.", "run", "run"
        )
    return _of_rows(path, list(drive_rows(path)))


def _of_protocol(path: Path, number: int | None) -> MotionDrive:
    config = load_protocol(path)
    runs = config.schedule(str(path)).runs
    if number is None:
        try:
            return _of_parts(config.protocol().steps_and_readings())
        except ScheduleError as error:
            raise BadInputError(f"{path}: {error}.") from None
    if not 1 <= number <= len(runs):
        raise BadArgumentError(
            f"run {number}: {path} has the runs 1 to {len(runs)}; labrig plan shows them.", "run"
        )
    run = runs[number - 1]
    if run.purpose not in (Purpose.MEASUREMENT, Purpose.FREE_SHAPE):
        raise BadArgumentError(
            f"run {number}: a {run.in_words} looks at the load cell without the sheet; give a "
            "run that measures the sheet.",
            "run",
        )
    if run.move is not None:
        raise BadArgumentError(
            f"run {number}: the load cell moves in this run, and the stage decides how fast; "
            "give a run in which it stays.",
            "run",
        )
    return _of_parts((run.steps, run.readings, run.duration_s), run)


def _of_parts(parts: StepsAndReadings, planned: PlannedRun | None = None) -> MotionDrive:
    steps, readings, end_s = parts
    held = HeldVoltage(
        np.array([step.time_s for step in steps]), np.array([step.voltage_V for step in steps])
    )
    samples = tuple(
        SamplingPoint(steps[each.step].time_s + each.delay_s, each.voltage_V)
        for each in readings
        if each.kind in (ReadingKind.ZERO, ReadingKind.KEPT)
    )
    return MotionDrive(voltage=held, end_s=end_s, samples=samples, planned=planned)


def _of_rows(path: Path, rows: Sequence[tuple[CsvRow, float, float]]) -> MotionDrive:
    """Return the voltages of a table; the last row says when the last one ends."""
    if len(rows) < 2:
        raise BadInputError(
            f"{path}: a drive has two rows at least; the time of the last one is the run's end."
        )
    for row, time_s, _ in rows:
        if time_s < 0.0:
            raise row.fault(f"time_s = {time_s:g}: the sheet is at rest until time 0")
    for (_, before, _), (row, after, _) in pairwise(rows):
        if after <= before:
            raise row.fault(f"time_s = {after:g} does not come after {before:g}")
    for row, _, voltage_V in rows:
        if not abs(voltage_V) <= LARGEST_VOLTAGE_V:
            raise row.fault(
                f"voltage_V = {voltage_V:g} is beyond the ±{LARGEST_VOLTAGE_V:g} V of any protocol"
            )
    times, volts = [time_s for _, time_s, _ in rows], [voltage_V for _, _, voltage_V in rows]
    held = HeldVoltage(np.array(times[:-1]), np.array(volts[:-1]))
    return MotionDrive(voltage=held, end_s=times[-1])
