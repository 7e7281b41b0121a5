"""What effects and nonparametric terms act on: a beam problem, its solution, and its observation.

A `BeamProblem` holds K conditions of one configuration; quantities along the sheet are values at
its G nodes.
"""

from __future__ import annotations

from collections.abc import Hashable, Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Any

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, SheetGeometry

Values = Mapping[str, float]
# Of further channels at each reading, by name and unit (temperature_degC); NaN: not recorded.
ChannelValues = Mapping[str, FloatArray]


@dataclass(kw_only=True)
class AcquisitionTimes:
    """When something was acquired: arrays of one shape."""

    voltage_V: FloatArray
    pulse_s: FloatArray  # since this voltage was set
    pulse: FloatArray  # counts the pulses of the run, from 0; -1 while at 0 V from the start
    run_s: FloatArray  # since the run began
    session: FloatArray  # since its session began; 1: at the end of the longest one
    wetted_s: FloatArray  # since the sheet was last wetted
    driven_s: FloatArray  # under voltage since then
    opposite: FloatArray  # EIBM just before the last edge, over that after it: -1, or 0 at first
    opposite_V: FloatArray | float = np.nan  # the voltage, likewise; NaN: as large before as after
    rise_s: FloatArray | float = 0.0  # known time constant of the voltage's rise at the sheet
    worked_s: FloatArray | float = 0.0  # under voltage in all sessions
    overall: FloatArray | float = 0.5  # 0 .. 1 over all sessions analysed together
    run_began: FloatArray | float = np.nan  # `session` when the run began; NaN: not known
    position_m: FloatArray | float = np.nan  # on the arc as stated; NaN: free
    channels: ChannelValues = field(default_factory=dict)

    @property
    def worked_out(self) -> dict[Hashable, Any]:
        """What was once worked out of these times, by what it is: see `effect_hooks.course`."""
        kept: dict[Hashable, Any] = self.__dict__.setdefault("_worked_out", {})
        return kept

    def channel(self, name: str, otherwise: float) -> FloatArray:
        """Return the values of a further channel; `otherwise` where none was recorded."""
        return _recorded(self.channels, name, otherwise, self.voltage_V.shape)

    def of(self, use: npt.NDArray[np.bool_]) -> AcquisitionTimes:
        """Return some of these times."""
        shape = self.voltage_V.shape

        def some(values: FloatArray | float) -> FloatArray:
            whole = np.asarray(values)
            return (whole if whole.shape == shape else np.broadcast_to(whole, shape))[use]

        # a selection of none is that of times to come, which have no values either
        channels = {name: some(values) for name, values in self.channels.items() if np.any(use)}
        times = {name: some(getattr(self, name)) for name in _TIMES}
        return AcquisitionTimes(**times, channels=channels)

    def at(self, places: npt.NDArray[np.int64]) -> AcquisitionTimes:
        """Return the times at some places, each as often as it is asked for."""
        times = {
            name: np.broadcast_to(getattr(self, name), self.voltage_V.shape)[places]
            for name in _TIMES
        }
        channels = {name: values[places] for name, values in self.channels.items()}
        return AcquisitionTimes(**times, channels=channels)

    @staticmethod
    def joined(clocks: Sequence[AcquisitionTimes]) -> AcquisitionTimes:
        """Return the times of all of them, one after the other."""
        every = [clock.of(np.ones(clock.voltage_V.shape, dtype=bool)) for clock in clocks]
        names = dict.fromkeys(name for clock in clocks for name in clock.channels)
        return AcquisitionTimes(
            **{n: np.concatenate([np.zeros(0), *(getattr(c, n) for c in every)]) for n in _TIMES},
            channels={
                name: np.concatenate([clock.channel(name, np.nan) for clock in every])
                for name in names
            },
        )


_TIMES = tuple(f.name for f in fields(AcquisitionTimes) if f.name not in ("channels", "worked_out"))


def _recorded(
    channels: ChannelValues, name: str, otherwise: float, shape: tuple[int, ...]
) -> FloatArray:
    """Return a channel's values in this shape, `otherwise` where there is none."""
    if name not in channels:
        return np.full(shape, otherwise)
    values = np.broadcast_to(channels[name], shape)
    return np.where(np.isfinite(values), values, otherwise)


@dataclass(kw_only=True)
class BeamProblem:
    """K conditions of one configuration before they are solved.

    Their curvature will be k0 + rest + soft (eibm + bend - (N/B) lever).
    """

    sheet: SheetGeometry
    s_m: FloatArray  # (G,) nodes along the free length
    voltage_V: FloatArray  # (K,)
    stated_m: FloatArray  # (K,) position on the arc as stated; NaN: free
    up: FloatArray  # (K,) +1: the position was approached from below, -1: from above
    stiffness: FloatArray  # (K,) B in N m^2
    rest: FloatArray  # (K, G) change of the rest curvature, 1/m
    eibm: FloatArray  # (K, G) Me/B, 1/m
    bend: FloatArray  # (K, G) moments other than EIBM and contact, over B, 1/m
    soft: FloatArray  # (K, G) B/B(s)
    elongation_soft: FloatArray  # (K,) B over the elongation's stiffness; 0: rigid
    shift_m: FloatArray  # (K,) of the contact along the arc
    tilt_rad: FloatArray  # (K,) direction in which the sheet leaves the clamp
    offset_m: FloatArray  # (K,) from the neutral curve to the point on the arc, along the normal
    reach_m: FloatArray  # (K,) of that point beyond the stated arc, away from its centre
    piece_m: FloatArray  # (G,) of the sheet that each node stands for; their sum is its length
    # when the readings of each condition were taken (n,), and of which condition each is (n,)
    clock: AcquisitionTimes
    reading_of: npt.NDArray[np.int64]
    share: FloatArray  # (n,) of each reading in the mean of its condition; 0: it is in none
    # (K,) share of the weight's push towards -y: -1 where the rig is turned over
    upright: FloatArray | float = 1.0
    # (K,) number of the session among those analysed together, from 1; 0: of none in particular
    session_number: FloatArray | float = 0.0
    # free length of the sheet whose material it is, where this one is cut to another; 0: its own
    measured_length_m: float = 0.0

    @property
    def material_length_m(self) -> float:
        """Free length of the measured sheet: what changes along the material refers to it."""
        return self.measured_length_m or self.sheet.free_length_m

    @property
    def material_m(self) -> FloatArray:
        """Nodes' places in the material (G,): beyond the measured length it is as at its end."""
        return np.minimum(self.s_m, self.material_length_m)


@dataclass(kw_only=True)
class ContactSolution:
    """What solving a `BeamProblem` gave; NaN where there is no contact."""

    force_N: FloatArray  # (K,) along the arc's tangent
    normal_N: FloatArray  # (K,) N
    gamma_rad: FloatArray  # (K,)
    s_hat_m: FloatArray  # (K,) contact's place along the sheet
    lever: FloatArray  # (K, G) p_hat - r along the contact's tangent, m; 0 beyond the contact
    offset: FloatArray  # (K, G) p_hat - r along the contact's normal, m; 0 beyond the contact
    x_m: FloatArray  # (K, G) the nodes' places
    y_m: FloatArray
    phi_rad: FloatArray  # (K, G)
    curvature: FloatArray  # (K, G) 1/m
    end_phi_rad: FloatArray  # (K,) at the end of the free length
    at_rest: FloatArray | float = 0.0  # (K, G) or (G,) initial curvature of the base model, 1/m


@dataclass(kw_only=True)
class LoadCellInput:
    """What the load cell is given: arrays of one shape; the last axis is in the order of time."""

    force_N: FloatArray  # along the arc's tangent
    normal_N: FloatArray
    gamma_rad: FloatArray
    position_m: FloatArray
    voltage_V: FloatArray
    session: FloatArray  # as of the acquisition times
    touching: FloatArray  # 1, or 0 without contact
    wetted_s: FloatArray | float = 0.0  # since the sheet was last wetted
    slid: FloatArray | float = 0.0  # which way along the sheet the rolls last slid: 1, to its end
    run_s: FloatArray | float = 0.0  # since the run began
    pulse_s: FloatArray | float = 0.0  # since this voltage was set
    session_number: FloatArray | float = 0.0  # as of the beam problem
    overall: FloatArray | float = 0.5  # as of the acquisition times
    force_scale: float = 1.0  # of the usual forces of such a sheet, over those of the paper's
    channels: ChannelValues = field(default_factory=dict)

    def channel(self, name: str, otherwise: float) -> FloatArray:
        """Return the values of a further channel; `otherwise` where none was recorded."""
        return _recorded(self.channels, name, otherwise, self.force_N.shape)

    def in_order(self, order: npt.NDArray[np.int64]) -> LoadCellInput:
        """Return the readings in another order."""
        given = {
            f.name: np.broadcast_to(getattr(self, f.name), self.force_N.shape)[..., order]
            for f in fields(self) if f.name not in ("channels", "force_scale")
        }  # fmt: skip
        channels = {name: values[order] for name, values in self.channels.items()}
        return LoadCellInput(**given, channels=channels, force_scale=self.force_scale)


# waves across the image, those with i + j below a degree, by the coordinates of terms that move
# points in x and in y; such a term has an amplitude for each of them
WAVE_DEGREES = {("image_x", "image_y"): 4, ("fine_x", "fine_y"): 8}


def wave_count(along: str) -> int:
    """Return how many waves across the image a coordinate numbers; 0: it is another one."""
    degree = next((degree for names, degree in WAVE_DEGREES.items() if along in names), 0)
    return degree * (degree + 1) // 2


@dataclass(kw_only=True)
class ImagePoints:
    """Points of curves as the camera should see them, (K, S), metres from the clamp."""

    s_m: FloatArray  # along the sheet
    x_m: FloatArray
    y_m: FloatArray
    normal_x: FloatArray  # unit normal of the curve
    normal_y: FloatArray
    length_scale: float = 1.0  # of a rig of this size, over one of the paper's
    free_length_m: float = np.inf  # from here on the curve is that of the elongation
    # (K, 1) the contact's place along the sheet, and its normal force over the stiffness, 1/m^2;
    # NaN: nothing touches
    contact_m: FloatArray | float = np.nan
    pressed_per_m2: FloatArray | float = np.nan
    session_number: FloatArray | float = 0.0  # (K, 1) as of the beam problem
    voltage_V: FloatArray | float = 0.0  # (K, 1)


@dataclass(kw_only=True)
class Perturbation:
    """A change of one configuration's prediction, to first order."""

    beam: FloatArray  # (K, Q) columns of `ConfigurationModel.answers`
    eibm: FloatArray  # (n,) relative, of each reading
    stiffness: FloatArray  # (n,)
    force_N: FloatArray  # (n,) of each reading
    bin_eibm: FloatArray  # (b,) relative to the sampling point
    bin_stiffness: FloatArray
    points_m: FloatArray  # (K, S) of the predicted points along the normal
    frame_eibm: FloatArray  # (n,) relative, of the frame of each reading where it is older
