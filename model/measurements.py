"""`Measurements`: the one table between the rig and the model.

It is made from a session, from imported CSV files, or by a simulator; `model` takes nothing else.
All quantities are SI. Coordinates: origin at the clamp, x along the clamped sheet's tangent, y to
the side of positive deflection and of positive position on the arc; angles counter-clockwise.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]
Kind = Literal["zero", "discarded", "kept", "no_contact"]


class ModelError(ValueError):
    """Data, or a question, that the model cannot answer; the text is one sentence for the user."""


@dataclass(frozen=True, kw_only=True)
class SheetGeometry:
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


@dataclass(frozen=True, kw_only=True)
class Curve:
    """A neutral curve, from the clamp (s = 0) to the visible end of sheet or elongation."""

    s_m: FloatArray  # (points,)
    x_m: FloatArray
    y_m: FloatArray
    curvature_per_m: FloatArray | None = None
    # of the distance along the normal, from the image alone; None: not stated
    sigma_m: FloatArray | None = None
    curvature_sigma_per_m: FloatArray | None = None


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


@dataclass(frozen=True, kw_only=True)
class Reading:
    """One force reading, and the curve of its own frame where there is one."""

    index: int  # in time order over the whole run, zero readings and pulses alike
    kind: Kind
    force_N: float
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


@dataclass(frozen=True, kw_only=True)
class Condition:
    """All that was measured at one configuration, position, voltage and mounting."""

    configuration: str
    position_m: float | None  # along the arc; None: free, no load cell touches the sheet
    voltage_V: float
    readings: tuple[Reading, ...]
    curve: Curve | None = None  # of the mean image
    mounting: int = 0  # counts how often this position was set anew
    approach: Literal["up", "down", ""] = ""
    tilt_rad: float = 0.0  # of the rig about the sheet's long axis
    run: int = 0  # a position measured again
    session: int = 1  # its number among the sessions analysed together
    contact: Contact | None = None  # from the mean image; None: not seen, or there is none

    def used(self) -> tuple[Reading, ...]:
        """Return the readings in use: zero or kept, and valid."""
        return tuple(r for r in self.readings if r.valid and r.kind in ("zero", "kept"))


@dataclass(frozen=True, kw_only=True)
class TimeSeries:
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


@dataclass(frozen=True, kw_only=True)
class Measurements:
    """Everything that is known of a session's outcome."""

    sheets: dict[str, SheetGeometry]
    conditions: tuple[Condition, ...]
    series: tuple[TimeSeries, ...] = ()
    source: str = ""  # file name
    checksum: str = ""  # sha256 of that file, hex
    warnings: tuple[str, ...] = field(default=())
