"""What an effect is: one object that says what it is and what it changes.

An effect acts in up to six places, each a method that changes nothing unless it is overridden:
    `beam`    the beam problem: moments, stiffness, rest curvature, where clamp and contact are
    `course`  how EIBM and stiffness go with time, relative to the settled values
    `lagging` what its memory adds to the rest curvature from reading to reading
    `force`   what the load cell adds to the force
    `curve`   where the camera puts the points of a curve
    `pictured` the EIBM in the picture of a reading
All work on arrays; a `BeamProblem` holds K conditions of one configuration, quantities along the
sheet are values at its G nodes.
"""

# ruff: noqa: ARG002 - the methods that an effect may override do nothing with what they are given

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, fields
from typing import Literal

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, SheetGeometry

Location = Literal[
    "rest_curvature", "eibm", "even_moment", "compliance", "position", "load_cell", "camera", "time"
]
LOCATIONS: tuple[Location, ...] = (
    "rest_curvature", "eibm", "even_moment", "compliance", "position", "load_cell", "camera", "time"
)  # fmt: skip
Along = Literal["s", "curvature", "position", "voltage", "time", "place", "run"]
Values = Mapping[str, float]


@dataclass(frozen=True)
class EffectParameter:
    """A parameter of an effect, in the unit of its name."""

    name: str
    meaning: str
    unit: str
    prior_scale: (
        float  # a size that would surprise nobody; the scale of what is believed beforehand
    )
    low: float = -np.inf
    high: float = np.inf
    neutral: float = 0.0  # the value at which the effect is absent
    log: bool = False  # positive, and refined in its logarithm
    # shapes to look for: values that are tried one by one; empty: the size, which is estimated
    starting_values: tuple[float, ...] = ()
    expected_sign: float = 0.0  # the sign that it has as a rule; the other one is a surprise


@dataclass
class AcquisitionTimes:
    """When something was taken: arrays of one shape."""

    voltage_V: FloatArray
    pulse_s: FloatArray  # since this voltage was set
    pulse: FloatArray  # counts the pulses of the run, from 0; -1 while at 0 V from the start
    run_s: FloatArray  # since the run began
    session: FloatArray  # 0 .. 1 over the data
    wetted_s: FloatArray  # since the sheet was last wetted
    driven_s: FloatArray  # under voltage since then
    opposite: FloatArray  # EIBM just before the last edge, over that after it: -1, or 0 at first
    rise_s: FloatArray | float = 0.0  # known time constant of the voltage's rise at the sheet
    worked_s: FloatArray | float = 0.0  # under voltage in the whole session

    def of(self, use: npt.NDArray[np.bool_]) -> AcquisitionTimes:
        """Some of these times."""
        shape = self.voltage_V.shape
        return AcquisitionTimes(
            *(np.broadcast_to(getattr(self, f.name), shape)[use] for f in fields(AcquisitionTimes))
        )

    @staticmethod
    def joined(clocks: Sequence[AcquisitionTimes]) -> AcquisitionTimes:
        """One after the other."""
        all_of_it = [clock.of(np.ones(clock.voltage_V.shape, dtype=bool)) for clock in clocks]
        return AcquisitionTimes(
            *(
                np.concatenate([np.zeros(0), *(getattr(clock, f.name) for clock in all_of_it)])
                for f in fields(AcquisitionTimes)
            )
        )


@dataclass
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
    piece_m: FloatArray  # (G,) of the sheet that each node stands for; their sum is its length
    # when the readings of each condition were taken (n,), and of which condition each is (n,)
    clock: AcquisitionTimes
    reading_of: npt.NDArray[np.int64]
    share: FloatArray  # (n,) of each reading in the mean of its condition; 0: it is in none
    # (K,) share of the weight's push towards -y: -1 where the rig is turned over
    upright: FloatArray | float = 1.0


@dataclass
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


@dataclass
class LoadCellInput:
    """What the load cell is given: arrays of one shape; the last axis is in the order of time."""

    force_N: FloatArray  # along the arc's tangent
    normal_N: FloatArray
    gamma_rad: FloatArray
    position_m: FloatArray
    session: FloatArray  # 0 .. 1 over the data
    touching: FloatArray  # 1, or 0 without contact
    wetted_s: FloatArray | float = 0.0  # since the sheet was last wetted
    slid: FloatArray | float = 0.0  # which way along the sheet the rolls last slid: 1, to its end


@dataclass
class ImagePoints:
    """Points of curves as the camera should see them, (K, S), metres from the clamp."""

    x_m: FloatArray
    y_m: FloatArray
    scale_m: float  # half the width of the picture of the sheet


@dataclass(frozen=True)
class Effect:
    """An entry of the catalogue."""

    name: str
    meaning: str
    form: str
    location: Location
    signature: str
    isolates: str
    source: str
    parameters: tuple[EffectParameter, ...]
    # along what its form may differ from the one written here
    form_error_along: tuple[Along, ...] = ("voltage",)
    waves: int = 3  # of a deviation along the sheet: more where the form itself has no shape
    # whether each configuration may have its own size
    by_configuration: bool = False
    of_the_rig: bool = False  # not of the sheet: the same for all configurations
    extra: Mapping[str, str] = field(default_factory=dict)  # unit by name of derived quantities
    needs_session: bool = False  # says nothing of a single run, whose session has no course

    @property
    def amplitude(self) -> EffectParameter:
        """The parameter that says how much of the effect there is."""
        return self.parameters[0]

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """The changed problem; `contact` is its present solution."""
        return beam

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """Relative change of EIBM and of stiffness at each time."""
        return None

    def lagging(
        self, beam: BeamProblem, contact: ContactSolution, p: Values
    ) -> Sequence[tuple[FloatArray, FloatArray]]:
        """Change of the rest curvature at each reading of `beam` beyond the mean of its condition.

        As shapes (K, G), 1/m, each with how much of it there is at each reading (n,).
        """
        return ()

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray | None:
        """What is added to the force, N; to readings without contact, too."""
        return None

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """What is added to the points' x and y, m."""
        return None

    def pictured(self, clock: AcquisitionTimes, p: Values) -> FloatArray | None:
        """Relative change of the EIBM in the picture of a reading, at each time."""
        return None

    def derived(self, p: Values, sheet: SheetGeometry) -> dict[str, float]:
        """Further quantities people ask for, named as in `extra`."""
        return {}
