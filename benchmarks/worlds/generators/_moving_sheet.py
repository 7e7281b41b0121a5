"""The strips of the world `moving` in time, and what can be wrong with them."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

from sim_hardware.world.motion.bare import BareSheet
from sim_hardware.world.motion.ladder import ladder
from sim_hardware.world.motion.links import Links
from sim_hardware.world.motion.march import Law

Floats = npt.NDArray[np.float64]

RADIUS_M, WIDTH_M, THICKNESS_M = 0.04, 0.011, 0.21e-3
LINKS = (40, 80)  # of two chains, whose answers are extrapolated
SHEET_KG_PER_M, BAR_KG_PER_M = 5.8e-3, 4e-3
AIR_KG_PER_M, AIR_NS_PER_M2, AIR_NS2_PER_M3 = 1.7e-4, 1.1e-3, 0.013
VISCOUS_S, QUICK_SHARE, QUICK_S = 4e-3, 0.35, 0.03  # held strips rest after half a second
RISE_S, FARAD_PER_M, LEAK_S_PER_M = 0.04, 0.3, 0.05
HELD_STEP_S, FREE_STEP_S = 5e-3, 2.5e-3
MASSLESS = 1e-6
DRIVE_V = 2.0


@dataclass(frozen=True, kw_only=True)
class Strip:
    """One configuration as it truly is; the stated rest curvature is linear between nodes."""

    name: str
    free_m: float
    bar_m: float
    stiffness_Nm2: float
    driven_per_m: float  # EIBM over B at +2 V
    negative: float  # EIBM at -2 V over that at +2 V
    nodes_m: Floats
    rest_per_m: Floats


@dataclass(frozen=True, kw_only=True)
class Course:
    """One run: each array (samples,), a step of time apart, since the run's beginning."""

    strip: Strip
    position_m: float | None
    time_s: Floats
    volts: Floats
    pulse: Floats  # counts those under voltage, from 0
    session: float  # 0 at the session's beginning, 1 at its end


Along = Callable[[Strip, Floats], Floats]
InTime = Callable[[Course], Floats]


@dataclass
class Wrong:
    """What acts beside the base model."""

    rest: list[Along] = field(default_factory=list)  # added to the rest curvature, 1/m
    profile: list[Along] = field(default_factory=list)  # factors of the EIBM
    even: list[Along] = field(default_factory=list)  # moment over B at 2 V of either sign, 1/m
    spring: list[Along] = field(default_factory=list)  # factors of B
    moment: list[InTime] = field(default_factory=list)  # factors of the EIBM
    stiff: list[InTime] = field(default_factory=list)  # factors of B
    felt: list[Callable[[Course, Floats], Floats]] = field(default_factory=list)  # added, N
    seen: list[Callable[[Course, Floats], Floats]] = field(default_factory=list)  # points
    place: list[Callable[[float, float], float]] = field(default_factory=list)
    weight_N_per_m: float = 0.0
    electrode_ohm_per_m: float = 1e-6
    slower: float = 0.0  # ions, over their time
    slow_share: float = 0.0  # of B, that relaxes ...
    slow_s: float = 4.0  # ... in this time
    late_s: float = 0.0  # age of an image

    def sheet(
        self, strip: Strip, place_m: float | None, scale: float, links: int, *, massless: bool
    ) -> BareSheet:
        """Return the strip between the rolls or free, as so many links.

        `scale`: of its stiffness; `massless`: it follows at once.
        """
        h = strip.free_m / links
        s = (np.arange(links) + 0.5) * h
        B = strip.stiffness_Nm2 * scale
        rest = np.interp(s, strip.nodes_m, strip.rest_per_m)
        odd, even, spring = np.full(links, strip.driven_per_m), np.zeros(links), np.ones(links)
        for each in self.rest:
            rest = rest + each(strip, s)
        for each in self.profile:
            odd = odd * each(strip, s)
        for each in self.even:
            even = even + each(strip, s)
        for each in self.spring:
            spring = spring * each(strip, s)
        step_s = HELD_STEP_S if place_m is not None else FREE_STEP_S
        return BareSheet(
            links=self._links(strip, h, rest, B * spring, MASSLESS if massless else 1.0),
            line=ladder(
                links, strip.free_m, step_s, ohm_per_m=self.electrode_ohm_per_m,
                farad_per_m=FARAD_PER_M, bulk_ohm_m=RISE_S * (1.0 + self.slower) / FARAD_PER_M,
                leak_S_per_m=LEAK_S_PER_M, source_ohm=1e-6,
            ),
            law=Law(_clamped(B * odd), _clamped(B * even), 1e6, strip.negative),
            step_s=step_s, radius_m=RADIUS_M, elongation_m=strip.bar_m,
            polar_rad=None if place_m is None else place_m / RADIUS_M,
        )  # fmt: skip

    def _links(self, strip: Strip, h: float, rest: Floats, B: Floats, heavy: float) -> Links:
        gauss = strip.bar_m / 2 * (1.0 + np.array([-1.0, 1.0]) / np.sqrt(3.0))
        slow = np.array([[QUICK_SHARE, QUICK_S], [self.slow_share, self.slow_s]])
        slow = slow[slow[:, 0] > 0.0]
        even = np.ones(len(rest))
        return Links(
            h_m=h, rest_rad=_clamped(rest * h), spring_Nm=_clamped(B / h),
            mass_kg=_clamped(heavy * SHEET_KG_PER_M * h * even), span_m=_clamped(h * even),
            bar_at_m=h / 2 + gauss, bar_kg=np.full(2, heavy * BAR_KG_PER_M * strip.bar_m / 2),
            bar_span_m=np.full(2, strip.bar_m / 2), viscous_s=VISCOUS_S, share=slow[:, 0].copy(),
            relax_s=slow[:, 1].copy(), added_kg_per_m=heavy * AIR_KG_PER_M,
            normal_Ns_per_m2=heavy * AIR_NS_PER_M2, quadratic_Ns2_per_m3=heavy * AIR_NS2_PER_M3,
            tangential_Ns_per_m2=0.0, load_N_per_m=-self.weight_N_per_m,
        )  # fmt: skip


def _clamped(values: Floats) -> Floats:
    return np.concatenate(([0.0], values))


def points(strip: Strip, phi: Floats, s_m: Floats) -> Floats:
    """Return points (images, places, 2) of strips whose links have the angles (images, n + 1)."""
    links = phi.shape[1] - 1
    at = np.linspace(0.0, strip.free_m, links + 1)
    fine = np.linspace(0.0, strip.free_m, 8 * links + 1)
    angle = CubicSpline(at, phi, axis=1)(fine)
    towards = np.stack([np.cos(angle), np.sin(angle)], axis=2)
    path = CubicSpline(fine, towards, axis=1).antiderivative()
    on, beyond = np.minimum(s_m, strip.free_m), np.maximum(s_m - strip.free_m, 0.0)
    return np.asarray(path(on) + beyond[:, None] * towards[:, -1:])


def extrapolated(coarse: Floats, fine: Floats) -> Floats:
    """Return what chains of endless many links would answer: the error goes with 1/links^2."""
    return np.asarray((4.0 * fine - coarse) / 3.0)
