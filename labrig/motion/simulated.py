"""The motion of one configuration of a model file under a drive, and its figures in a table."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, fields, replace
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from labrig.errors import BadArgumentError, BadInputError
from labrig.model_file import load_model, moving_configuration
from labrig.motion.drive import MotionDrive
from model import ModelError
from model.dynamics import Resolution, SheetMotion, simulate
from model.measurements import Displayed, FloatArray, Summary, in_volts

if TYPE_CHECKING:
    import pandas as pd

MOST_TIMES = 500_000
_DEGREES, _FREE_DEGREES = (10, 4), 12  # polynomials: force and tip below 1e-5 of their range
SUMMARY_COLUMNS = ("", "time s", "force mN", "tip x mm", "tip y mm", "current mA")


@dataclass(frozen=True)
class OutputTimes:
    """When the motion is written."""

    every_s: float = 1e-3
    start_s: float = 0.0

    def of(self, drive: MotionDrive) -> FloatArray:
        """Return the times until the drive's end. Raises BadInputError."""
        if not 0.0 < self.every_s < np.inf:
            raise BadArgumentError(
                f"every_ms {1e3 * self.every_s:g}: a number above 0 is needed.", "every_ms"
            )
        if not 0.0 <= self.start_s <= drive.end_s:
            raise BadArgumentError(
                f"start_ms {1e3 * self.start_s:g}: the drive lasts from 0 to "
                f"{1e3 * drive.end_s:g} ms; give a time within it.",
                "start_ms",
            )
        count = np.floor((drive.end_s - self.start_s) / self.every_s + 1e-6)
        if count >= MOST_TIMES:
            raise BadArgumentError(
                f"every_ms {1e3 * self.every_s:g} makes {count + 1:.0f} rows and {MOST_TIMES} "
                "are the most; give a larger one, or a later start_ms.",
                "every_ms", "start_ms",
            )  # fmt: skip
        return np.asarray(self.start_s + self.every_s * np.arange(int(count) + 1))


@dataclass(frozen=True, kw_only=True, repr=False)
class SimulatedRun(Displayed):
    """A motion, and what it is of."""

    configuration: str
    position_m: float | None  # of the load cell; None: the sheet is free
    motion: SheetMotion
    readings: dict[float, SheetMotion]  # by voltage, at the sampling points of a rig
    has_effects: bool  # whether the file has effects, which are not in the motion

    def summary(self) -> Summary:
        """Return the rows that `labrig simulate --time` prints."""
        rows = [tuple(row) for row in summary_rows(self)]
        return Summary(f"SimulatedRun: {self.place}", SUMMARY_COLUMNS, rows)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each time as a pandas data frame; see `SheetMotion.to_dataframe`."""
        return self.motion.to_dataframe()

    @property
    def place(self) -> str:
        """Configuration and position, in words."""
        return _place(self.configuration, self.position_m)


def simulated_run(
    path: Path,
    drive: MotionDrive,
    times: OutputTimes,
    configuration: str | None,
    position_m: float | None,
) -> SimulatedRun:
    """Return what a model file says of a drive; the sheet begins at rest at time 0.

    Where the drive is a run of a schedule, configuration and position are that run's. Raises
    BadInputError.
    """
    if drive.planned is not None:
        configuration, position_m = drive.planned.configuration, drive.planned.position_m
    model = load_model(path)
    name = moving_configuration(model, path, configuration)
    moments = times.of(drive)
    by = Resolution(degrees=_DEGREES, free_degrees=_FREE_DEGREES)
    where = f"{path}: {_place(name, position_m)}"
    instants = np.unique(np.concatenate([moments, [each.time_s for each in drive.samples]]))
    try:
        beam, rolls = model.moving(name, position_m)
        motion = simulate(beam, rolls, drive.voltage, instants, resolution=by)
    except ModelError as error:
        raise BadInputError(f"{where}: {error}.") from None
    if motion.slipped_s is not None:
        raise BadInputError(
            f"{where}: the sheet leaves the rolls at {motion.slipped_s:.3f} s; give a place nearer "
            "to where it rests, or less voltage."
        )
    return SimulatedRun(
        configuration=name,
        position_m=position_m,
        motion=_at(motion, moments),
        readings=_readings(motion, drive, times.start_s),
        has_effects=bool(model.effects),
    )


def _place(configuration: str, position_m: float | None) -> str:
    where = "free" if position_m is None else f"at {1e3 * position_m:g} mm"
    return f"{configuration}, {where}"


def _at(motion: SheetMotion, times: FloatArray) -> SheetMotion:
    """Return the motion at some of its times."""
    rows = np.searchsorted(motion.time_s, times)
    over_time: dict[str, Any] = {
        each.name: value[rows]
        for each in fields(motion)
        if isinstance(value := getattr(motion, each.name), np.ndarray) and each.name != "s_m"
    }
    return replace(motion, **over_time)


def _readings(motion: SheetMotion, drive: MotionDrive, start_s: float) -> dict[float, SheetMotion]:
    """Return the motion at the sampling points of each voltage, in the order of their times."""
    taken = [each for each in drive.samples if each.time_s >= start_s]
    return {
        voltage_V: _at(motion, np.array([s.time_s for s in taken if s.voltage_V == voltage_V]))
        for voltage_V in dict.fromkeys(each.voltage_V for each in taken)
    }


def summary_rows(run: SimulatedRun) -> Iterator[list[str]]:
    """Yield rows under `SUMMARY_COLUMNS`: the begin, the largest values, the sampling points."""
    motion = run.motion
    away_m = np.hypot(motion.x_m[:, -1] - motion.x_m[0, -1], motion.y_m[:, -1] - motion.y_m[0, -1])
    instants = {"first": 0}
    if run.position_m is not None:
        instants["largest force"] = int(np.argmax(np.abs(motion.force_N)))
    instants["largest current"] = int(np.argmax(np.abs(motion.current_A)))
    instants["tip farthest from the first"] = int(np.argmax(away_m))
    instants["last"] = len(away_m) - 1
    for text, row in instants.items():
        at = motion.time_s[[row]]
        yield _row(run, text, f"{at[0]:.3f}", _at(motion, at))
    for voltage_V, taken in run.readings.items():
        text = f"sampling points at {in_volts(voltage_V)}"
        yield _row(run, text, f"mean of {len(taken.time_s)}", taken)


def _row(run: SimulatedRun, text: str, when: str, motion: SheetMotion) -> list[str]:
    x, y, current = (
        1e3 * float(np.mean(values))
        for values in (motion.x_m[:, -1], motion.y_m[:, -1], motion.current_A)
    )
    force = "-" if run.position_m is None else f"{1e3 * float(np.mean(motion.force_N)):+.3f}"
    return [text, when, force, f"{x:.2f}", f"{y:.2f}", f"{current:+.2f}"]
