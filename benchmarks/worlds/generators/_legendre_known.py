"""What the world `legendre` hides that the catalogue has: sheet and clamp, and their course."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.generators import _legendre_course as course
from benchmarks.worlds.generators._legendre_ritz import Array
from benchmarks.worlds.generators._legendre_specimen import Specimen
from benchmarks.worlds.generators._legendre_strip import Along, mean_one
from benchmarks.worlds.session.effects import Acting, acting
from benchmarks.worlds.session.layout import Samples

LOSS_S, DEFICIT, WET_S, SLOW_S = 0.9, 0.5, 8.0, 3.0
BRANCH_M = 11e-3


@dataclass(frozen=True)
class Ludwick:
    """M = B u (1 + (u/10 per m)^2)^n."""

    n: float

    def moment(self, u: Array) -> Array:
        """Return it over B."""
        return np.asarray(u * (1.0 + (0.1 * u) ** 2) ** self.n)

    def slope(self, u: Array) -> Array:
        """Return its derivative."""
        w = (0.1 * u) ** 2
        return np.asarray((1.0 + w) ** (self.n - 1.0) * (1.0 + w + 2.0 * self.n * w))


def ludwick(size: float) -> Ludwick:
    """Return the law of a sheet stiffer by `size` where bent by 10 per m."""
    return Ludwick(float(np.log2(1.0 + size)))


def falling(size: float) -> dict[str, Along]:
    """The EIBM falls as exp(-size s/50 mm)."""
    return {"profile": lambda s, _: mean_one(np.exp(-size * s / 50e-3))}


def line(size: float) -> dict[str, Along]:
    """The EIBM is that of an open resistive line as long as `size` of its own lengths."""

    def shape(s: Array, true: Specimen) -> Array:
        share = size * true.length_m / 50e-3
        return mean_one(np.cosh(share * (1.0 - s / true.length_m)) / np.cosh(share))

    return {"profile": shape}


def like_stated(size: float) -> dict[str, Along]:
    """The rest curvature is the stated one times a number, more by `size` in the mean."""

    def more(_: Array, true: Specimen) -> Array:
        rest = true.grid()[1]
        return np.asarray(size * mean_one(rest))

    return {"rest": more}


def graded(size: float) -> dict[str, Along]:
    """B goes as 1 + c s/l, with c = `size` and a middle value that stays."""
    return {"soft": lambda s, _: (1.0 + 0.5 * size) / (1.0 + size * s / s[-1])}


def unlike_faces(size: float) -> dict[str, Along]:
    """A moment that does not change its sign, most at the clamp."""
    return {"even": lambda s, _: size * np.exp(-s / BRANCH_M)}


def relaxed(at: Samples, size: float) -> Array:
    """Return the EIBM over that at the sampling point."""
    loss = size / -np.expm1(-0.5 / LOSS_S)
    left = 1.0 + loss * np.expm1(-np.maximum(at.phase_s, 0.0) / LOSS_S)
    return np.asarray(left / (1.0 - size))


def deficient(at: Samples, size: float) -> Array:
    """Return the EIBM over the settled one in the first pulses."""
    k = at.pulse + (at.phase_s - 0.5) / course.PULSE_S
    return np.where(at.pulse >= 0, 1.0 - size * DEFICIT ** np.maximum(k, -1.0), 1.0)


def tired(at: Samples, size: float) -> Array:
    """Return the EIBM of a sheet that loses water under voltage, and is wetted before each run."""
    driven = np.where(at.pulse >= 0, at.pulse * course.PULSE_S + at.phase_s, 0.0)
    return np.asarray(1.0 + size * (np.expm1(-driven / WET_S) + 0.45))


def crept(at: Samples, size: float) -> Array:
    """Return the stiffness over that after 5 s in the run."""
    return np.asarray(1.0 - size * np.log10(np.maximum(at.time_s, 0.05) / 5.0))


def over_session(at: Samples, size: float) -> Array:
    """Return what goes evenly from one end of the session to the other."""
    return np.asarray(1.0 + size * (at.tau - 0.5))


KNOWN: dict[str, Acting] = {
    "electrode_falls": acting(
        "The electrode's resistance lets the EIBM fall as exp(-c s/50 mm), its mean kept.",
        "nonuniform_eibm", ("eibm",), (0.3, 10.0), "-", setting=falling,
        parameters=lambda c: {"decay_length_mm": 50.0 / c}),
    "resistive_line": acting(
        "The sheet is an open line of resistance and leak: the EIBM goes as cosh(c (l - s)/50 mm),"
        " its mean kept.", "nonuniform_eibm", ("eibm",), (0.8, 9.0), "-", setting=line),
    "more_curled": acting(
        "The sheet at rest is more curved than stated, by c everywhere.", "initial_curvature",
        ("rest_curvature",), (1.0, 14.0), "1/m", setting=lambda c: {"rest": lambda s, _: c + 0 * s},
        parameters=lambda c: {"curvature_error_per_m": c, "like_stated": 0.0}),
    "curled_in_proportion": acting(
        "The sheet at rest is the stated one, its curvature times a number: its mean is c more.",
        "initial_curvature", ("rest_curvature",), (1.0, 12.0), "1/m", setting=like_stated,
        parameters=lambda c: {"curvature_error_per_m": c, "like_stated": 1.0}),
    "unlike_faces": acting(
        "One face swells at either polarity: a moment c (V/2 V)^2 exp(-s/11 mm), over B.",
        "eibm_asymmetry", ("even_moment", "eibm"), (4.0, 60.0), "1/m", setting=unlike_faces),
    "rig_leans": acting(
        "The table leans: of sheet and elongation c per length pulls along -y.", "gravity",
        ("even_moment",), (0.003, 0.06), "N/m", setting=lambda c: {"weight_N_per_m": c},
        parameters=lambda c: {"load_N_per_m": c}),
    "crooked_in_clamp": acting(
        "The sheet leaves the clamp in the direction c.", "clamp_angle",
        ("rest_curvature", "position", "camera"), (0.012, 0.2), "rad",
        setting=lambda c: {"clamp_rad": c}, parameters=lambda c: {"angle_rad": c}),
    "soft_jaws": acting(
        "The clamp's rubber turns by c times the load's moment.", "clamp_compliance",
        ("compliance",), (60.0, 5e3), "rad/(N m)", setting=lambda c: {"clamp_rad_per_Nm": c},
        parameters=lambda c: {"rotation_rad_per_Nm": c}),
    "loose_joint": acting(
        "The glued joint of sheet and elongation turns by c times its moment.",
        "elongation_flexibility", ("compliance",), (120.0, 6e3), "rad/(N m)",
        setting=lambda c: {"joint_rad_per_Nm": c}),
    "stiffens_bent": acting(
        "M + Me = B u (1 + (u/10 per m)^2)^n with 2^n = 1 + c.", "nonlinear_stiffness",
        ("compliance",), (0.02, 0.2), "-", law=ludwick,
        parameters=lambda c: {"relative_change_at_10_per_m": c, "power": 0.0}),
    "thicker_outwards": acting(
        "Stiffness goes as 1 + c s/l.", "nonuniform_stiffness", ("compliance",), (0.2, 4.0), "-",
        setting=graded, parameters=lambda c: {"relative_change": c}),
    "gives_way_slowly": acting(
        "In each run the stiffness falls by c of itself in every tenfold of time.",
        "viscoelastic_creep", ("time",), (0.03, 0.3), "-", cases=course.stiffness(crept),
        parameters=lambda c: {"relative_change_per_decade": -c, "time_s": 0.0, "from_run": 1.0}),
    "dries_and_stiffens": acting(
        "Stiffness goes as 1 + c (tau - 1/2) over the session.", "stiffness_drift", ("time",),
        (0.1, 1.1), "-", cases=course.stiffness(over_session),
        parameters=lambda c: {"relative_change": c, "since_wetting": 0.0, "settles": 0.0}),
    "gains_over_session": acting(
        "The EIBM goes as 1 + c (tau - 1/2) over the session.", "eibm_drift", ("time",),
        (0.1, 1.4), "-", cases=course.eibm(over_session),
        parameters=lambda c: {"relative_change": c, "since_wetting": 0.0, "settles": 0.0}),
    "tires_when_driven": acting(
        "Driven for t since it was wetted the sheet has lost c (1 - exp(-t/8 s)) of its EIBM.",
        "eibm_drift", ("time",), (0.06, 0.8), "-", cases=course.eibm(tired)),
    "slow_to_charge": acting(
        "The EIBM follows the voltage's rise by a lag of c.", "charging_lag", ("time",),
        (0.1, 0.9), "s", cases=course.lagging,
        parameters=lambda c: {"time_constant_s": c, "slow_share": 1.0, "remembers": 1.0}),
    "relaxes_back": acting(
        "In each pulse water flows back: c of the EIBM is lost at the sampling point, with 0.9 s.",
        "back_relaxation", ("time",), (0.05, 0.38), "-", ("series",),
        cases=course.eibm(relaxed),
        parameters=lambda c: {"relative_loss_at_sample": c, "time_constant_s": LOSS_S,
                              "remembers": 0.0, "spread": 1.0}),
    "wakes_up": acting(
        "The EIBM of pulse k of a run is 1 - c/2^k of the settled one.", "first_pulse_transient",
        ("time",), (0.08, 0.95), "-", ("series",), cases=course.eibm(deficient),
        parameters=lambda c: {"relative_deficit": c, "ratio": DEFICIT}),
}  # fmt: skip
