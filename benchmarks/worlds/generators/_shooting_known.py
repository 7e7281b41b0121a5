"""What catalogues know, in this world's words and formulas."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._shooting_equilibrium import Lanes, Law, Section
from benchmarks.worlds.generators._shooting_specimen import LAYOUT, step
from benchmarks.worlds.session.effects import (
    Acting,
    Array,
    Image,
    Load,
    Sheet,
    acting,
)
from benchmarks.worlds.session.layout import READING, Samples

SERIES = ("series",)
SLIDING_M = 0.05e-3
STUCK_FROM_M = 17.5e-3
LOOP_N = 0.5e-3


def _lag(lanes: Lanes, at: Samples, sheet: Sheet, tau_s: float) -> None:
    def left(t: Array | float) -> Array:
        rising = np.exp(-np.asarray(t) / LAYOUT.rise_s)
        return np.asarray(rising + (1.0 - rising) * np.exp(-((np.asarray(t) / tau_s) ** 0.8)))

    drive = dict(zip(at.slot.tolist(), at.drive_V.tolist(), strict=True))
    period = float(np.max(at.phase_s))
    begins, x = {}, 0.0
    for slot in range(max(drive) + 1):
        begins[slot] = x
        volts = drive.get(slot, 0.0)
        x = volts + (x - volts) * float(left(period))
    start = np.array([begins[k] for k in at.slot.tolist()])
    lagging = at.drive_V + (start - at.drive_V) * left(at.phase_s)
    lanes.moment_Nm += sheet.eibm_Nm(lagging) - sheet.eibm_Nm(at.sheet_V)


def _relaxing(lanes: Lanes, at: Samples, _sheet: Sheet, lost: float) -> None:
    lanes.moment_Nm *= 1.0 - lost * at.phase_s / (at.phase_s + 0.4)


def _first(lanes: Lanes, at: Samples, _sheet: Sheet, lost: float) -> None:
    lanes.moment_Nm *= 1.0 - lost / (1.0 + np.maximum(at.pulse, 0.0)) ** 2


def _weaker(lanes: Lanes, at: Samples, _sheet: Sheet, change: float) -> None:
    lanes.moment_Nm *= 1.0 + 0.5 * change * np.tanh(3.0 * (at.tau - 0.5)) / np.tanh(1.5)


def _stiffer(lanes: Lanes, at: Samples, _sheet: Sheet, change: float) -> None:
    lanes.stiffness_Nm2 *= 1.0 + change * (at.tau**2 - 1.0 / 3.0)


def _creep(lanes: Lanes, at: Samples, _sheet: Sheet, lost: float) -> None:
    lanes.stiffness_Nm2 *= 1.0 - lost * (1.0 - (1.0 + at.time_s / 1.5) ** -0.5)


def _turned(lanes: Lanes, _at: Samples, _sheet: Sheet, angle: float) -> None:
    lanes.root_rad += angle


def _moved(lanes: Lanes, _at: Samples, _sheet: Sheet, offset_mm: float) -> None:
    lanes.position_m += offset_mm * 1e-3


def _beside(lanes: Lanes, _at: Samples, _sheet: Sheet, offset_mm: float) -> None:
    lanes.offset_m += offset_mm * 1e-3


def _rest(size: float) -> Law:
    def law(here: Section) -> None:
        here.rest_per_m = here.rest_per_m + 1.5 * size * (1.0 - (here.s_m / here.length_m) ** 2)

    return law


def _falling(size: float) -> Law:
    def law(here: Section) -> None:
        here.eibm_Nm = here.eibm_Nm * (1.0 - size * step(here.s_m, 22e-3, 8e-3))

    return law


def _weak_face(size: float) -> Law:
    def law(here: Section) -> None:
        lost = size * here.s_m / here.length_m
        here.eibm_Nm = here.eibm_Nm * np.where(here.eibm_Nm < 0.0, 1.0 - lost, 1.0)

    return law


def _stiff_end(size: float) -> Law:
    def law(here: Section) -> None:
        share = here.s_m / here.length_m
        here.stiffness_Nm2 = here.stiffness_Nm2 * (1.0 + size * (step(share, 0.5, 0.2) - 0.5))

    return law


def _hardening(size: float) -> Law:
    def law(here: Section) -> None:
        bent = np.abs(here.eibm_Nm + here.load_Nm) / here.stiffness_Nm2
        here.stiffness_Nm2 = here.stiffness_Nm2 * (1.0 + size * bent / (bent + 15.0))

    return law


def _rubs(s_hat: Array, at: Samples, coefficient: float) -> Array:
    return coefficient * np.tanh(_since_slot_before(s_hat, at) / SLIDING_M)


def _since_slot_before(values: Array, at: Samples) -> Array:
    """Return the change since the reading of the slot before; 0 until the first pulse."""
    change = np.zeros(len(values))
    for number in np.unique(at.run):
        rows = np.flatnonzero(at.run == number)
        readings = rows[at.role[rows] == READING]
        last = dict(zip(at.slot[readings].tolist(), values[readings].tolist(), strict=True))
        driven = rows[at.pulse[rows] >= 0.0]
        before = np.array([last[k - 1] for k in at.slot[driven].tolist()])
        change[driven] = values[driven] - before
    return change


def _sticks(load: Load, size_mN: float) -> Array:
    hold = size_mN * 1e-3
    change = np.tanh(_since_slot_before(load.force_N, load.samples) / hold)
    at_m = np.nan_to_num(load.position_m)  # without the load cell nothing sticks
    return load.force_N - hold * step(at_m, STUCK_FROM_M, 0.5e-3) * change


def _behind(load: Load, size_mN: float) -> Array:
    """Dahl's loop: its width is reached as exp(-change of load/LOOP_N)."""
    result = load.force_N.copy()
    for rows in load.samples.each_run():
        z, before = 0.0, 0.0
        for row, force in zip(rows.tolist(), load.force_N[rows].tolist(), strict=True):
            way = float(np.sign(force - before))
            z = way + (z - way) * float(np.exp(-abs(force - before) / LOOP_N))
            before = force
            result[row] = force - size_mN * 1e-3 * z
    return result


def _skew(load: Load, angle: float) -> Array:
    return load.force_N * np.cos(angle) - load.outward_N * np.sin(angle)


def _meniscus(load: Load, size_mN: float) -> Array:
    pull = size_mN * 1e-3 / (1.0 + load.samples.wetted_s / 30.0)
    return load.force_N + np.where(np.isnan(load.position_m), 0.0, pull * np.cos(load.lean_rad))


def _projected(image: Image, size: float) -> tuple[Array, Array]:
    by = 1.0 - size * image.x_m / 50e-3
    return image.x_m / by, image.y_m / by


def _k(words: str, name: str, where: tuple[str, ...], **more: object) -> tuple[str, Acting]:
    sizes, unit = more.pop("sizes"), more.pop("unit")
    return name, acting(words, name, where, sizes, unit, **more)  # type: ignore[arg-type]


KNOWN: dict[str, Acting] = dict(
    [
        _k("The EIBM follows the voltage as a stretched exponential: what is left to do after t is"
           " exp(-(t/tau)^0.8), behind the voltage's rise, from where the pulse before ended.",
           "charging_lag", ("time",), sizes=(0.12, 0.4), unit="s", needs=SERIES, cases=_lag),
        _k("Within a pulse the EIBM loses a t/(t + 0.4 s).",
           "back_relaxation", ("time",), sizes=(0.15, 0.8), unit="", needs=SERIES,
           cases=_relaxing),
        _k("The n-th pulse of a run (n = 1, 2, ...) lacks a/n^2 of its EIBM.",
           "first_pulse_transient", ("time",), sizes=(0.2, 0.8), unit="", cases=_first),
        _k("The EIBM changes over the session as tanh(3 (tau - 1/2)), altogether by c.",
           "eibm_drift", ("time",), sizes=(0.1, 0.8), unit="", cases=_weaker),
        _k("The stiffness changes with the square of the session's time: B (1 + c (tau^2 - 1/3)).",
           "stiffness_drift", ("time",), sizes=(0.1, 0.8), unit="", cases=_stiffer),
        _k("In each run the polymer gives way: B (1 - c (1 - (1 + t/1.5 s)^(-1/2))).",
           "viscoelastic_creep", ("time",), sizes=(0.06, 0.35), unit="", cases=_creep),
        _k("The sheet leaves the clamp at an angle.", "clamp_angle", ("rest_curvature",),
           sizes=(0.015, 0.2), unit="rad", cases=_turned,
           parameters=lambda c: {"angle_rad": c}),
        _k("The load cell stands farther along the arc than it says.", "position_error",
           ("position",), sizes=(0.3, 4.0), unit="mm", cases=_moved,
           parameters=lambda c: {"offset_mm": c}),
        _k("The rolls hold the sheet to the right of the point on the arc.", "roll_offset",
           ("position",), sizes=(0.3, 4.0), unit="mm", cases=_beside,
           parameters=lambda c: {"offset_mm": c}),
        _k("At rest the sheet is more curved than stated, as a parabola that is 0 at its end:"
           " 1.5 c (1 - (s/l)^2).", "initial_curvature", ("rest_curvature",),
           sizes=(1.5, 20.0), unit="1/m", law=_rest),
        _k("The EIBM is less beyond 22 mm from the clamp: Me (1 - a (1 + tanh((s - 22)/8 mm))/2).",
           "nonuniform_eibm", ("eibm",), sizes=(0.4, 1.0), unit="", law=_falling),
        _k("At negative voltage the electrode gives less the farther from the clamp:"
           " Me (1 - a s/l).", "eibm_asymmetry", ("even_moment", "eibm"),
           sizes=(0.3, 1.0), unit="", law=_weak_face),
        _k("The outer half of the sheet is stiffer: B (1 + c tanh((s/l - 1/2)/0.2)/2).",
           "nonuniform_stiffness", ("compliance",), sizes=(0.2, 1.0), unit="", law=_stiff_end),
        _k("The sheet stiffens as it is bent, less and less: B (1 + c u/(u + 15 per m)), u the"
           " change of curvature that Hooke's law would give.",
           "nonlinear_stiffness", ("compliance",), sizes=(0.3, 2.0), unit="", law=_hardening),
        _k("Sheet and elongation, which is twice as heavy, hang in the picture's plane.",
           "gravity", ("even_moment",), sizes=(0.003, 0.03), unit="N/m",
           setting=lambda q: {"weight_N_per_m": q}),
        _k("The clamp turns under the load's moment M, as c M/sqrt(1 + (c M/0.03)^2).",
           "clamp_compliance", ("compliance",), sizes=(60.0, 600.0), unit="rad/(N m)",
           setting=lambda c: {"clamp_rad_per_Nm": c}),
        _k("The elongation is a bar that becomes thinner: its compliance grows along it threefold,"
           " from c/2 of the sheet's on.", "elongation_flexibility", ("compliance",),
           sizes=(0.01, 0.2), unit="", setting=lambda c: {"bar_compliance": c}),
        _k("The load cell moves under the force, less the larger it is: c F/(1 + |F|/8 mN).",
           "load_cell_compliance", ("load_cell",), sizes=(0.08, 0.8), unit="mm/mN",
           setting=lambda c: {"give_m_per_N": c}),
        _k("The rolls rub on the sheet: mu |N| tanh(sliding since the pulse before/0.05 mm).",
           "roll_friction", ("position",), sizes=(0.05, 0.4), unit="", slides=_rubs),
        _k("From 17.5 mm on the sheet sticks: F - c tanh(change since the pulse before/c).",
           "roll_sticking", ("position",), sizes=(0.1, 1.0), unit="mN", force=_sticks),
        _k("The zero rises with the square root of the session's time.",
           "force_drift", ("load_cell",), sizes=(0.1, 1.0), unit="mN",
           force=lambda at, c: at.force_N + c * 1e-3 * np.sqrt(at.samples.tau)),
        _k("The zero of the load cell is wrong.", "force_offset", ("load_cell",),
           sizes=(0.08, 1.0), unit="mN", force=lambda at, c: at.force_N + c * 1e-3,
           parameters=lambda c: {"force_mN": c}),
        _k("The load cell hangs behind its load on a loop of Dahl's, whose half height it reaches"
           " as exp(-change/0.5 mN).", "load_cell_hysteresis", ("load_cell",),
           sizes=(0.08, 0.6), unit="mN", force=_behind),
        _k("The load cell's axis is turned from the arc's tangent.", "load_cell_misalignment",
           ("load_cell",), sizes=(0.06, 0.5), unit="rad", force=_skew,
           parameters=lambda c: {"angle_rad": c}),
        _k("A meniscus pulls along the sheet's normal and dries: c cos(gamma)/(1 + t/30 s), t since"
           " the wetting.", "surface_tension", ("load_cell",), sizes=(0.15, 1.0), unit="mN",
           force=_meniscus),
        _k("The camera looks askew: a homography, r/(1 - c x/50 mm).", "camera_perspective",
           ("camera",), sizes=(0.01, 0.2), unit="", image=_projected),
        _k("The picture's scale is wrong.", "camera_scale", ("camera",), sizes=(0.01, 0.2),
           unit="", image=lambda of, c: (of.x_m * (1.0 + c), of.y_m * (1.0 + c)),
           parameters=lambda c: {"relative_error": c}),
        _k("The picture is older than the force.", "frame_delay", ("camera",),
           sizes=(0.45, 0.58), unit="s", needs=SERIES, delay_s=lambda c: c,
           parameters=lambda c: {"delay_s": c}),
    ]
)  # fmt: skip
