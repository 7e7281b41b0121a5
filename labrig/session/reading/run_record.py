"""One recorded run, read from the file piece by piece as it is asked for."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields
from functools import cached_property
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.interfaces import FloatArray, GreyImage, SampleClock
from labrig.errors import BadInputError
from labrig.session.format import layout
from labrig.session.format.layout import Array
from labrig.session.format.setup import SessionSetup
from labrig.session.marks.mark import Mark, Place, standing
from labrig.session.reading.values import read_array, read_dataset, read_table
from model.measurements import Displayed, Summary, dataframe, in_volts, is_number
from protocols.execution.channels import FORCE_N
from protocols.planning.schedule import PlannedRun

if TYPE_CHECKING:
    import pandas as pd


@dataclass(frozen=True, kw_only=True)
class Counts:
    """What a run's acquisition reported at its end; all zero when it never came to it."""

    lost_samples: int
    frames_grabbed: int
    frames_dropped: int
    frames_incomplete: int = 0  # came with a part missing
    frames_missed: int = 0  # never came


class RunRecord(Displayed):
    """A run of an open session. Nothing is read before it is asked for, images one at a time."""

    def __init__(
        self,
        file: Any,
        path: Path,
        planned: PlannedRun,
        setup: SessionSetup,
        later_marks: Callable[[], Sequence[Mark]] = tuple,
    ) -> None:
        """`later_marks` returns the session's marks after the end."""
        self.planned = planned
        self._later_marks = later_marks
        self.channels = setup.channels
        self.signals = setup.signals
        self.ranges_V = {channel.name: channel.range_V for channel in setup.signals}
        self._reading_row = setup.reading_row
        self._value_columns = setup.value_columns
        self._file = file
        self._path = path
        self._has_frames = setup.frame_shape is not None
        self._frame_shape = setup.frame_shape
        self._version = setup.version

    @property
    def place_in_words(self) -> str:
        """Where it is measured: configuration, and position along the arc."""
        planned = self.planned
        at = "free" if planned.position_m is None else f"{1e3 * planned.position_m:g} mm"
        return f"{planned.configuration}, {at}"

    def in_words(self, reading: int | None = None) -> str:
        """Return which run this is, and which of its readings (index); both counted from 1."""
        run = f"run {self.planned.index + 1} ({self.place_in_words})"
        row = None if reading is None else self._reading(reading)
        if reading is None or row is None:
            return run
        force_N = self.values(row).get(FORCE_N)
        force = "" if force_N is None else f", {1e3 * force_N:.3f} mN"
        return f"{run}, reading {reading + 1} ({in_volts(row['voltage_V'])}{force})"

    def summary(self) -> Summary:
        """Return place, samples and frames."""
        planned = self.planned
        title = f"RunRecord {planned.index + 1}: {self.place_in_words}, {planned.in_words}"
        if not self._file:
            return Summary(f"{title}, of a closed session")
        if not self.started:
            return Summary(f"{title}, not begun")
        return Summary(
            f"{title}, {self.samples} samples of {', '.join(self.channels)}, "
            f"{self.frame_count} frames"
        )

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each sample as a pandas data frame: `time_s`, and inputs in V."""
        inputs = {f"{name}_V": self.signal_V(name) for name in self.channels}
        return dataframe({"time_s": self.time_s, **inputs})

    # --------------------------------------------------------------------------------- its course

    @cached_property
    def _acquisition(self) -> Any:
        name = f"{layout.run_path(self.planned.index)}/acquisition"
        found = read_table(self._file, name, layout.acquisition_row(self._version), self._path)
        if found.shape not in ((), (1,)):
            raise BadInputError(f"{self._path}: {name} has another shape than in a session.")
        return found.reshape(())[()]

    @property
    def started(self) -> bool:
        """Whether the run was begun."""
        return bool(self._acquisition["started"])

    @property
    def completed(self) -> bool:
        """Whether the run came to its planned end."""
        return bool(self._acquisition["completed"])

    @property
    def sample_clock(self) -> SampleClock:
        """Sample indices against clock time. Raises BadInputError when the run was never begun."""
        if not self.started:
            raise BadInputError(f"{self._path}: run {self.planned.index + 1} was never begun.")
        row = self._acquisition
        return SampleClock(
            start_s=float(row["clock_start_s"]),
            start_uncertainty_s=float(row["clock_start_uncertainty_s"]),
            rate_hz=float(row["rate_hz"]),
        )

    @property
    def time_zero_s(self) -> float:
        """Clock time at which the run began; NaN when it never did."""
        return float(self._acquisition["time_zero_s"])

    @property
    def since_wetting_s(self) -> float | None:
        """Time between the last wetting and the run's beginning, where it is known."""
        return _known(self._acquisition["since_wetting_s"])

    @property
    def stage_position_m(self) -> float | None:
        """Position along the arc that the stage reported, where one did."""
        return _known(self._acquisition["stage_position_m"])

    @property
    def counts(self) -> Counts:
        """Lost samples and frames."""
        row = self._acquisition
        names = [field.name for field in fields(Counts) if field.name in row.dtype.names]
        return Counts(**{name: int(row[name]) for name in names})

    # ------------------------------------------------------------------------------------ signals

    @property
    def samples(self) -> int:
        """How many samples of each channel were recorded."""
        return int(self._column("signals/time").shape[0])

    def signal_V(self, channel: str) -> FloatArray:
        """Return a channel's raw samples in V; samples that were lost are NaN."""
        if channel not in self.channels:
            known = ", ".join(self.channels)
            raise BadInputError(f"{self._path}: no channel {channel} among {known}.")
        column = self._column(f"signals/{channel}")
        if column.shape[0] != self.samples:
            raise BadInputError(
                f"{self._path}: in run {self.planned.index + 1} signals/{channel} has "
                f"{column.shape[0]} samples, signals/time has {self.samples}; the file was changed "
                "after its recording: fetch the original again."
            )
        return read_array(column, self._path)

    @property
    def time_s(self) -> FloatArray:
        """Time of each sample since the run's beginning."""
        return read_array(self._column("signals/time"), self._path)

    # ------------------------------------------------------------------------------------- tables

    @cached_property
    def writes(self) -> Array:
        """Each write of the voltage, columns as in `layout.WRITE_ROW`."""
        return self._table("writes", layout.WRITE_ROW)

    @cached_property
    def control(self) -> Array:
        """Each period of a controller, columns as in `layout.CONTROL_ROW`; none without one."""
        if not self.planned.reference:
            return np.zeros(0, dtype=layout.CONTROL_ROW)
        return self._table("control", layout.CONTROL_ROW)

    @cached_property
    def marks(self) -> Array:
        """Marks during the session, columns as in `layout.MARK_ROW`; see `standing_marks`."""
        return self._table("marks", layout.MARK_ROW)

    @cached_property
    def standing_marks(self) -> dict[Place, Mark]:
        """The marks that hold, during the session and after its end, by run and reading."""
        later = [mark for mark in self._later_marks() if mark.run == self.planned.index]
        return standing([*self.marks_during, *later])

    @property
    def marks_during(self) -> list[Mark]:
        """The marks that were made during the session."""
        return [
            Mark(
                run=self.planned.index,
                reading=None if mark["reading"] < 0 else int(mark["reading"]),
                why=str(mark["why"]) or "-",
                who=str(mark["who"]) or "-",
                when="",
            )
            for mark in self.marks
        ]

    @property
    def readings_as_taken(self) -> Array:
        """Each reading, as if none had been marked later."""
        return self._table("readings", self._reading_row)

    @cached_property
    def readings(self) -> Array:
        """Each reading, columns as in `layout.reading_row`; marks are in `valid` and `why`."""
        rows = self.readings_as_taken
        for mark in self.standing_marks.values():
            hit = slice(None) if mark.reading is None else rows["index"] == mark.reading
            rows["valid"][hit] = False
            rows["why"][hit] = mark.why
        return rows

    def values(self, row: Any) -> dict[str, float]:
        """Return the values of a row of the readings, by the columns of the run's channels."""
        recorded = {channel.column for channel in self.signals}
        return {name: float(row[name]) for name in self._value_columns if name in recorded}

    # ------------------------------------------------------------------------------------- frames

    @property
    def frame_count(self) -> int:
        """How many images were recorded."""
        return int(self._images().shape[0]) if self._has_frames else 0

    def image(self, row: int) -> GreyImage:
        """Return an image by its row, 0 to `frame_count` - 1."""
        if not is_number(row) or not 0 <= row < self.frame_count:
            raise BadInputError(
                f"{self._path}: run {self.planned.index + 1} has {self.frame_count} images and "
                f"none in row {row!r}."
            )
        return read_array(self._images(), self._path, row)

    def frame_column(self, name: str) -> Array:
        """One of `layout.frame_columns` for all images; NaN where an older session has it not."""
        if not self._has_frames:
            return np.empty(0)
        if name not in layout.frame_columns(self._version):
            return np.full(self.frame_count, np.nan)
        return read_array(self._column(f"frames/{name}"), self._path)

    def frame(self, reading_index: int) -> GreyImage | None:
        """Return a reading's image; None when it has none or was not taken."""
        row = self._reading(reading_index)
        if row is None or row["frame"] == layout.NO_FRAME:
            return None
        return self.image(int(row["frame"]))

    def frame_offset_s(self, reading_index: int) -> float | None:
        """Time of a reading's image minus that of its sampling point."""
        row = self._reading(reading_index)
        return None if row is None else _known(row["frame_offset_s"])

    # ------------------------------------------------------------------------------------ helpers

    def _reading(self, index: int) -> Any:
        found = np.flatnonzero(self.readings["index"] == index)
        return self.readings[found[0]] if found.size else None

    def _images(self) -> Any:
        return self._dataset("frames/images", "u", self._frame_shape or ())

    def _column(self, name: str) -> Any:
        return self._dataset(name, "fi", ())

    def _dataset(self, name: str, kinds: str, row_shape: tuple[int, ...]) -> Any:
        full = f"{layout.run_path(self.planned.index)}/{name}"
        found = read_dataset(self._file, full, self._path)
        if found.shape[1:] != row_shape or found.shape == () or found.dtype.kind not in kinds:
            raise BadInputError(
                f"{self._path}: {full} has another shape or type than in a session."
            )
        return found

    def _table(self, name: str, kind: np.dtype[Any]) -> Array:
        full = f"{layout.run_path(self.planned.index)}/{name}"
        return read_table(self._file, full, kind, self._path)


def _known(value: Any) -> float | None:
    return None if np.isnan(value) else float(value)
