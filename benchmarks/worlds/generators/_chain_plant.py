"""The rig of the world `chain`: two strips, what is wrong with them, and how a run goes in time."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
from scipy.signal import lfilter

from benchmarks.worlds.generators._chain_links import FINE, Bending, Floats, Strip

STEP_S = 0.002
RISE_S = 0.04  # time constant of the voltage across the sheet
RUN_S, WET_S = 75.0, 12.0  # from run to run; from wetting to a run's first reading
DRIVE_V = 2.0
LONG, SHORT = "long", "short"


@dataclass(frozen=True, kw_only=True)
class Sheet:
    """One configuration as it truly is. The stated rest curvature is exact, linear in between."""

    name: str
    free_m: float
    elongation_m: float
    stiffness_Nm2: float
    driven_per_m: float  # EIBM over B at +2 V
    negative: float  # EIBM at -2 V over that at +2 V
    nodes_m: Floats
    rest_per_m: Floats


@dataclass(frozen=True, kw_only=True)
class Course:
    """One run in time: each array of (samples,), STEP_S apart."""

    sheet: Sheet
    position_m: float | None
    time_s: Floats
    session: Floats  # 0 at the beginning of the session, 1 at its end
    volts: Floats
    pulse: Floats  # counts the pulses under voltage, from 0; -1 before the first
    since_s: Floats  # since the last change of the voltage
    pulse_s: float

    def settled(self) -> Floats:
        """Return the amplitude to which the EIBM goes."""
        ratio = np.where(self.volts < 0, self.sheet.negative, 1.0)
        return np.asarray(ratio * self.volts / DRIVE_V)

    def risen(self) -> Floats:
        """Return the amplitude of the EIBM, behind the rise of the voltage."""
        kept = float(np.exp(-STEP_S / RISE_S))  # exact for the steps of the voltage
        return np.asarray(lfilter([0.0, 1.0 - kept], [1.0, -kept], self.settled()))


def lag(amplitude: Floats, constant_s: float) -> Floats:
    """Return what follows an amplitude, linear from step to step, by a first-order lag."""
    kept = float(np.exp(-STEP_S / constant_s))
    share = -np.expm1(-STEP_S / constant_s) * constant_s / STEP_S
    return np.asarray(lfilter([1.0 - share, share - kept], [1.0, -kept], amplitude))


Along = Callable[[Sheet, Floats], Floats]  # along s (FINE,)
InTime = Callable[[Course], Floats]
Felt = Callable[[Course, "Load"], Floats]
Seen = Callable[[Course, Floats], Floats]


@dataclass(frozen=True)
class Load:
    """What the load cell meets in a run: forces in N, (samples,)."""

    force_N: Floats
    normal_N: Floats
    lean_rad: Floats  # gamma


@dataclass
class Plant:
    """What acts beside the base model. Each list is worked off in its order."""

    rest: list[Along] = field(default_factory=list)  # added, 1/m
    profile: list[Along] = field(default_factory=list)  # factors of the EIBM along the sheet
    even: list[Along] = field(default_factory=list)  # moment over B at 2 V, either sign, 1/m
    softness: list[Along] = field(default_factory=list)  # factors of 1/B along the sheet
    bending: Bending | None = None
    clamp_angle_rad: float = 0.0
    clamp_give_rad_per_Nm: float = 0.0
    weight_N_per_m: float = 0.0
    friction: float = 0.0
    beside_m: float = 0.0
    cell_give_m_per_N: float = 0.0
    # true position from the stated one, and where in the session the run is
    place: list[Callable[[float, float], float]] = field(default_factory=list)
    amplitude: list[Callable[[Course, Floats], Floats]] = field(default_factory=list)
    stiffness: list[InTime] = field(default_factory=list)  # factors of B in time
    felt: list[Felt] = field(default_factory=list)  # added to the force, N
    seen: list[Seen] = field(default_factory=list)  # points (readings, points, 2) as pictured
    late_s: float = 0.0  # age of a picture

    def strip(self, sheet: Sheet) -> Strip:
        """Return what the chain is made from. The EIBM keeps its mean along the sheet."""
        s = np.linspace(0.0, sheet.free_m, FINE)
        profile, soft, even = np.ones(FINE), np.ones(FINE), np.zeros(FINE)
        rest = np.interp(s, sheet.nodes_m, sheet.rest_per_m)
        for shape in self.profile:
            profile = profile * shape(sheet, s)
        for shape in self.softness:
            soft = soft * shape(sheet, s)
        for shape in self.rest:
            rest = rest + shape(sheet, s)
        for shape in self.even:
            even = even + shape(sheet, s)
        driven = sheet.driven_per_m * profile / np.mean(profile)
        return Strip(
            s_m=s, rest_per_m=rest, driven_per_m=driven * soft, even_per_m=even * soft,
            softness=soft, stiffness_Nm2=sheet.stiffness_Nm2,
            clamp_angle_rad=self.clamp_angle_rad,
            clamp_give_rad_per_Nm=self.clamp_give_rad_per_Nm, bending=self.bending,
        )  # fmt: skip

    def driven(self, course: Course) -> Floats:
        """Return the amplitude of the EIBM in a run."""
        u = course.risen()
        for change in self.amplitude:
            u = change(course, u)
        return u

    def stiffened(self, course: Course) -> Floats:
        """Return the factor of the stiffness in a run."""
        factor = np.ones(len(course.time_s))
        for change in self.stiffness:
            factor = factor * change(course)
        return factor


def only(sheet: Sheet, name: str) -> float:
    """Return 1 for this sheet, 0 for others."""
    return 1.0 if sheet.name == name else 0.0
