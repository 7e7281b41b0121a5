"""The data classes of `Measurements`.

It is made from a session, from imported CSV files, or by a simulator; `model` takes nothing else.
All quantities are SI. Coordinates: origin at the clamp, x along the clamped sheet's tangent, y to
the side of positive deflection and of positive position on the arc; angles counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Literal

import numpy as np
import numpy.typing as npt

from model.measurements.columns import Columns, dataframe, of_rows
from model.measurements.display import Displayed, Summary, in_decimals, signed

if TYPE_CHECKING:
    import pandas as pd

FloatArray = npt.NDArray[np.float64]
Kind = Literal["zero", "discarded", "kept", "no_contact"]
_SAME_POSITION_M = 1e-5  # of a position that was measured, and one that is asked for
Part = Literal["conditions", "readings", "curves", "signals"]


class ModelError(ValueError):
    """Data, or a question, that the model cannot answer; the text is one sentence for the user."""


@dataclass(frozen=True, kw_only=True, repr=False)
class SheetGeometry(Displayed):
    """One configuration of sheet.toml."""

    configuration: str
    free_length_m: float  # l
    width_m: float  # w
    thickness_m: float  # d
    elongation_m: float  # visible length of the rigid elongation; 0: none
    arc_radius_m: float  # R
    arc_origin_rad: float  # polar angle of position 0 on the arc
    # k0 as known: (s_m, per_m) nodes, to be interpolated linearly; None: to be taken from the data
    initial_curvature: tuple[FloatArray, FloatArray] | None
    rise_time_s: float = 0.0
    clamped_length_m: float = 0.0

    def summary(self) -> Summary:
        """Return the lengths in mm."""
        end = f" + {_mm(self.elongation_m)} mm elongation" if self.elongation_m else ""
        return Summary(
            f"SheetGeometry '{self.configuration}': {_mm(self.free_length_m)} x "
            f"{_mm(self.width_m)} x {_mm(self.thickness_m)} mm{end}, "
            f"arc {_mm(self.arc_radius_m)} mm"
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class Curve(Displayed):
    """A neutral curve, from the clamp (s = 0) to the visible end of sheet or elongation."""

    s_m: FloatArray  # (points,), rising, from 0 at the clamp
    x_m: FloatArray  # along the clamped sheet's tangent
    y_m: FloatArray  # to the side of positive deflection and of positive position on the arc
    curvature_per_m: FloatArray | None = None
    # of the distance along the normal, from the image alone; None: not stated
    sigma_m: FloatArray | None = None
    curvature_sigma_per_m: FloatArray | None = None

    def summary(self) -> Summary:
        """Return the number of points and where the tip is."""
        if not len(self.s_m):
            return Summary("Curve: no points")
        return Summary(
            f"Curve: {len(self.s_m)} points over {_mm(self.s_m[-1])} mm, tip at "
            f"({_mm(self.x_m[-1])}, {_mm(self.y_m[-1])}) mm"
        )

    def columns(self) -> dict[str, FloatArray]:
        """Return the points: s, x, y in m, and curvature and uncertainties where known."""
        every = {
            "s_m": self.s_m, "x_m": self.x_m, "y_m": self.y_m,
            "curvature_per_m": self.curvature_per_m, "sigma_m": self.sigma_m,
            "curvature_sigma_per_m": self.curvature_sigma_per_m,
        }  # fmt: skip
        return {name: values for name, values in every.items() if values is not None}

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each point; see `columns`. Needs pandas."""
        return dataframe(self.columns())


@dataclass(frozen=True, kw_only=True)
class Contact:
    """Where the rolls touch the sheet as the picture shows it, beside what the stage says."""

    s_m: float  # along the sheet
    x_m: float
    y_m: float
    angle_rad: float  # of the sheet's tangent there
    position_m: float  # along the arc, as in `Condition`
    position_sigma_m: float
    radius_m: float  # distance from the clamp, to compare with the arc's
    # x, y and radius of each roll; without: not seen, and this is where the sheet crosses the arc
    rolls_m: tuple[tuple[float, float, float], ...] = ()


@dataclass(frozen=True, kw_only=True, repr=False)
class Reading(Displayed):
    """One force reading, and the curve of its own frame where there is one."""

    # From 0, in time order over the whole run, zero readings and pulses alike; labrig show and
    # labrig mark count it from 1
    index: int
    kind: Kind  # zero and kept count; discarded and no_contact do not
    force_N: float  # on the load cell, along the arc's tangent, towards larger positions
    time_s: float | None = None  # since the run began
    session_s: float | None = None  # since the session began
    wetted_s: float | None = None  # since the last wetting
    valid: bool = True
    why: str = ""  # the reason when not valid
    curve: Curve | None = None
    frame_s: float | None = None  # middle of the exposure that shows `curve`, since the run began
    # of further channels at the sampling point, by name and unit: {"temperature_degC": 21.5}
    other_values: Mapping[str, float] = field(default_factory=dict)
    # Of a mean that was written down in place of its readings: how many they were, and their
    # standard deviation; None: not stated
    mean_of: int = 1
    sd_N: float | None = None

    def summary(self) -> Summary:
        """Return what was read, and why it does not count."""
        why = "" if self.valid else f", invalid: {self.why}"
        curve = "" if self.curve is None else f", curve of {len(self.curve.s_m)} points"
        return Summary(f"Reading {self.index} ({self.kind}): {_mN(self.force_N)} mN{curve}{why}")

    def row(self) -> dict[str, object]:
        """Return its numbers by name of the column."""
        return {
            "reading": self.index, "kind": self.kind, "time_s": self.time_s,
            "session_s": self.session_s, "force_N": self.force_N, "valid": self.valid,
            "why": self.why, **self.other_values,
        }  # fmt: skip


@dataclass(frozen=True, kw_only=True, repr=False)
class Condition(Displayed):
    """All that was measured at one configuration, position, voltage and mounting."""

    configuration: str
    position_m: float | None  # along the arc; None: free, no load cell touches the sheet
    voltage_V: float
    readings: tuple[Reading, ...]
    curve: Curve | None = None  # of the mean image
    mounting: int = 0  # counts how often this position was set anew
    approach: Literal["up", "down", ""] = ""
    tilt_rad: float = 0.0  # of the rig about the sheet's long axis
    run: int = 0  # how often the same place was measured before; not the number of the run
    session: int = 1  # its number among the sessions analysed together
    contact: Contact | None = None  # from the mean image; None: not seen, or there is none

    def used(self) -> tuple[Reading, ...]:
        """Return the readings in use: zero or kept, and valid."""
        return tuple(r for r in self.readings if r.valid and r.kind in ("zero", "kept"))

    def forces_N(self) -> FloatArray:
        """Return the forces of the readings in use, (readings,)."""
        return np.array([r.force_N for r in self.used()], dtype=np.float64)

    def place(self) -> dict[str, object]:
        """Return what tells it from the other conditions, by name of the column.

        `again` is how often the same place was measured before: 0 of the first time.
        """
        return {
            "configuration": self.configuration, "position_m": self.position_m,
            "voltage_V": self.voltage_V, "mounting": self.mounting, "again": self.run,
            "session": self.session,
        }  # fmt: skip

    def row(self) -> dict[str, object]:
        """Return place, mean force and its standard deviation over the readings in use."""
        force_N = self.forces_N()
        return {
            **self.place(),
            "readings": len(force_N),
            "force_N": float(np.mean(force_N)) if len(force_N) else np.nan,
            "force_deviation_N": float(np.std(force_N, ddof=1)) if len(force_N) > 1 else np.nan,
            "curve_points": 0 if self.curve is None else len(self.curve.s_m),
        }

    def summary(self) -> Summary:
        """Return the place and the mean force."""
        _, position, volts, count, mean, _, curve = _condition_cells(self)
        place = "free" if self.position_m is None else f"{position} mm"
        force = "no reading in use" if count == "0" else f"{mean} mN, mean of {count}"
        return Summary(
            f"Condition {self.configuration}, {place}, {volts} V: {force}; curve: {curve}"
        )


@dataclass(frozen=True, kw_only=True, repr=False)
class TimeSeries(Displayed):
    """The signals of one run over time, each of shape (samples,)."""

    configuration: str
    position_m: float | None
    time_s: FloatArray
    drive_V: FloatArray
    force_N: FloatArray | None = None
    current_A: FloatArray | None = None
    mounting: int = 0
    run: int = 0  # as of the conditions
    extra: str = ""  # of the protocol whose run it is, such as release; empty: a measurement

    def summary(self) -> Summary:
        """Return place, length and channels."""
        known = [name for name in self.columns() if name != "time_s"]
        length = f"{len(self.time_s)} samples"
        if len(self.time_s):
            length += f" over {self.time_s[-1] - self.time_s[0]:.3g} s"
        at = _position(self.position_m)
        return Summary(f"TimeSeries {self.configuration}, {at} mm: {length}, {', '.join(known)}")

    def columns(self) -> dict[str, FloatArray]:
        """Return the signals that were recorded, by name with the unit at its end."""
        every = {
            "time_s": self.time_s, "drive_V": self.drive_V, "force_N": self.force_N,
            "current_A": self.current_A,
        }  # fmt: skip
        return {name: values for name, values in every.items() if values is not None}

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each sample; see `columns`. Needs pandas."""
        return dataframe(self.columns())


@dataclass(frozen=True, kw_only=True)
class CameraUncertainty:
    """Standard uncertainties of curves that no mean of readings lessens; 0: none is stated.

    The first three are those of the camera's calibration, common to all curves.
    """

    scale: float = 0.0  # relative
    roll_rad: float = 0.0  # of its direction
    origin_m: float = 0.0  # of the clamp's place, along x and along y
    curve_m: float = 0.0  # of each mode of the curve of a mean image

    def larger(self, other: CameraUncertainty) -> CameraUncertainty:
        """Return the larger of each."""
        return CameraUncertainty(
            scale=max(self.scale, other.scale), roll_rad=max(self.roll_rad, other.roll_rad),
            origin_m=max(self.origin_m, other.origin_m), curve_m=max(self.curve_m, other.curve_m),
        )  # fmt: skip


def is_at(one: Condition | TimeSeries, configuration: str, position_m: float) -> bool:
    """Whether it was measured in this configuration (empty: in any) and at this position."""
    return (
        configuration in ("", one.configuration)
        and one.position_m is not None
        and abs(one.position_m - position_m) < _SAME_POSITION_M
    )


@dataclass(frozen=True, kw_only=True, repr=False)
class Measurements(Displayed):
    """Everything that is known of a session's outcome."""

    sheets: dict[str, SheetGeometry]
    conditions: tuple[Condition, ...]
    series: tuple[TimeSeries, ...] = ()
    source: str = ""  # file name
    checksum: str = ""  # sha256 of that file, hex
    warnings: tuple[str, ...] = field(default=())
    # as camera and curves are stated to be known
    camera: CameraUncertainty = field(default_factory=CameraUncertainty)

    def summary(self) -> Summary:
        """Return one row for each condition."""
        measured = {one.configuration for one in self.conditions}
        measured |= {one.configuration for one in self.series}
        names = ", ".join(name for name in self.sheets if name in measured) or "no sheet"
        origin = f" of {self.source}" if self.source else ""
        return Summary(
            f"Measurements{origin}: {len(self.conditions)} conditions of {names}, "
            f"{len(self.series)} time series",
            _CONDITION_COLUMNS,
            [_condition_cells(one) for one in self.conditions],
            self.warnings,
        )

    def to_dataframe(self, part: Part = "conditions") -> pd.DataFrame:
        """Return a part of the measurements as a pandas data frame, in SI units.

        part: `conditions` (mean force of each), `readings` (each force), `curves` (each point of
        the mean images' neutral curves) or `signals` (each sample of each run).

        `reading` counts from 0 within its run, where labrig show and labrig mark count from 1.
        `again` is how often the same place was measured before (`run` of forces.csv), not the
        number of a run; the data frame of an open session has that.

        Raises ModelError for another part, MissingPandasError where pandas is not installed.
        """
        tables: dict[str, Callable[[], Columns]] = {
            "conditions": self._conditions, "readings": self._readings,
            "curves": self._curves, "signals": self._signals,
        }  # fmt: skip
        if part not in list(tables):
            raise ModelError(f"measurements have no part '{part}', but {', '.join(tables)}")
        return dataframe(tables[part]())

    def _conditions(self) -> dict[str, list[object]]:
        return of_rows([one.row() for one in self.conditions])

    def _readings(self) -> dict[str, list[object]]:
        return of_rows([{**c.place(), **r.row()} for c in self.conditions for r in c.readings])

    def _curves(self) -> dict[str, list[object]]:
        return of_rows(
            [
                {**c.place(), **dict(zip(points, values, strict=True))}
                for c in self.conditions
                if c.curve is not None
                for points in (c.curve.columns(),)
                for values in zip(*points.values(), strict=True)
            ]
        )

    def _signals(self) -> Columns:
        every = [one.columns() for one in self.series]
        names = list(dict.fromkeys(name for columns in every for name in columns))
        places = {
            "configuration": "configuration", "position_m": "position_m", "mounting": "mounting",
            "again": "run", "extra": "extra",
        }  # fmt: skip
        result: dict[str, Sequence[Any] | Any] = {
            name: [getattr(s, its) for s in self.series for _ in s.time_s]
            for name, its in places.items()
        }
        for name in names:
            parts = [c.get(name, np.full(len(c["time_s"]), np.nan)) for c in every]
            result[name] = np.concatenate(parts)
        return result


_CONDITION_COLUMNS = ("sheet", "position mm", "V", "readings", "mean mN", "deviation mN", "curve")


def _condition_cells(one: Condition) -> tuple[str, ...]:
    row = one.row()
    force_N, deviation_N = (float(str(row[name])) for name in ("force_N", "force_deviation_N"))
    curve = "-" if one.curve is None else f"{row['curve_points']} points"
    at = (one.configuration, _position(one.position_m), signed(one.voltage_V))
    return (*at, str(row["readings"]), _mN(force_N), _mN(deviation_N), curve)


def _position(position_m: float | None) -> str:
    return "free" if position_m is None else _mm(position_m)


def _mm(length_m: float) -> str:
    return f"{1e3 * length_m:.4g}"


def _mN(force_N: float) -> str:
    return in_decimals(1e3 * force_N, 3) if np.isfinite(force_N) else "-"
