"""What catalogues know, in this world's words and formulas."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._elements_beam import Cases, Law, Point
from benchmarks.worlds.generators._elements_specimen import LAYOUT
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
SLIDING_M = 0.03e-3
STUCK_FROM_M = 19e-3


def _two_lags(cases: Cases, at: Samples, sheet: Sheet, tau_s: float) -> None:
    def left(t: Array | float) -> Array:
        t = np.asarray(t)
        slow = 0.7 * np.exp(-t / tau_s) + 0.3 * np.exp(-t / (4.0 * tau_s))
        rising = np.exp(-t / LAYOUT.rise_s)
        return np.asarray(rising + (1.0 - rising) * slow)

    period = float(np.max(at.phase_s))
    slots, rows = np.unique(at.slot, return_index=True)
    reached, end = {}, 0.0
    for slot, volts in zip(slots.tolist(), at.drive_V[rows].tolist(), strict=True):
        reached[slot] = end
        end = volts + (end - volts) * float(left(period))
    start = np.array([reached[k] for k in at.slot.tolist()])
    lagging = at.drive_V + (start - at.drive_V) * left(at.phase_s)
    cases.moment_Nm += sheet.eibm_Nm(lagging) - sheet.eibm_Nm(at.sheet_V)


def _diffusing(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    cases.moment_Nm *= 1.0 - lost * np.sqrt(np.clip(at.phase_s / 0.6, 0.0, 1.0))


def _waking(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    cases.moment_Nm *= 1.0 - lost / (1.0 + np.exp((np.maximum(at.pulse, 0.0) - 2.0) / 0.7))


def _tiring(cases: Cases, at: Samples, _sheet: Sheet, change: float) -> None:
    cases.moment_Nm *= 1.0 + change * (np.sqrt(at.tau) - 2.0 / 3.0)


def _drying(cases: Cases, at: Samples, _sheet: Sheet, change: float) -> None:
    reached = (1.0 - np.exp(-2.5 * at.tau)) / (1.0 - np.exp(-2.5))
    cases.stiffness_Nm2 *= 1.0 + change * (reached - 0.5)


def _giving_way(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    cases.stiffness_Nm2 *= 1.0 - lost * at.time_s / (at.time_s + 3.0)


def _turned(cases: Cases, _at: Samples, _sheet: Sheet, angle: float) -> None:
    cases.root_rad += angle


def _scaled(cases: Cases, _at: Samples, _sheet: Sheet, at_30_mm: float) -> None:
    cases.position_m *= 1.0 + at_30_mm / 30.0


def _bent(size: float) -> Law:
    def law(at: Point) -> None:
        at.rest_per_m = at.rest_per_m * (1.0 + size / 20.0)

    return law


def _line_of_resistors(size: float) -> Law:
    def law(at: Point) -> None:
        decay, full = 50e-3 / size, at.length_m * size / 50e-3
        fall = np.cosh((at.length_m - at.s_m) / decay) / np.cosh(full)
        at.eibm_Nm = at.eibm_Nm * fall * full / np.tanh(full)

    return law


def _one_face(size: float) -> Law:
    def law(at: Point) -> None:
        less = size * np.exp(-at.s_m / 15e-3)
        at.eibm_Nm = at.eibm_Nm * np.where(at.eibm_Nm > 0.0, 1.0 - less, 1.0)

    return law


def _thicker(size: float) -> Law:
    def law(at: Point) -> None:
        share = (at.s_m / at.length_m) ** 2
        at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * (share - 1.0 / 3.0))

    return law


def _stiffening(size: float) -> Law:
    def law(at: Point) -> None:
        bent = (at.curvature_per_m - at.rest_per_m) / 20.0
        at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * (np.sqrt(1.0 + bent**2) - 1.0))

    return law


def _rubs(s_hat: Array, at: Samples, coefficient: float) -> Array:
    slid = since_slot_before(s_hat, at)
    return coefficient * slid / np.sqrt(slid**2 + SLIDING_M**2)


def since_slot_before(values: Array, at: Samples) -> Array:
    """Return the change since the reading of the slot before; 0 until the first pulse."""
    change = np.zeros(len(values))
    for number in np.unique(at.run):
        own = at.run == number
        read = own & (at.role == READING)
        known = np.zeros(1 + int(np.max(at.slot[own])))
        known[at.slot[read]] = values[read]
        driven = own & (at.pulse >= 0.0)
        change[driven] = values[driven] - known[at.slot[driven] - 1]
    return change


def _sticks(load: Load, size_mN: float) -> Array:
    hold = size_mN * 1e-3
    change = since_slot_before(load.force_N, load.samples)
    kept = hold * np.sign(change) * (1.0 - np.exp(-np.abs(change) / abs(hold)))
    far = np.nan_to_num(load.position_m, nan=0.0) > STUCK_FROM_M
    return np.asarray(np.where(far, load.force_N - kept, load.force_N))


def _plays(load: Load, size_mN: float) -> Array:
    """Two plays in parallel, of half and one and a half of the size (Prandtl and Ishlinskii)."""
    result = load.force_N.copy()
    for rows in load.samples.each_run():
        z = [0.0, 0.0]
        for row, force in zip(rows.tolist(), load.force_N[rows].tolist(), strict=True):
            for k, width in enumerate((0.5e-3 * abs(size_mN), 1.5e-3 * abs(size_mN))):
                z[k] = min(max(z[k], force - width), force + width)
            shown = 0.5 * (z[0] + z[1])
            result[row] = shown if size_mN > 0.0 else 2.0 * force - shown
    return result


def _skew(load: Load, angle: float) -> Array:
    return load.force_N * np.cos(angle) - load.outward_N * np.sin(angle)


def _meniscus(load: Load, size_mN: float) -> Array:
    pull = size_mN * 1e-3 * np.cos(load.lean_rad) / (1.0 + (load.lean_rad / 0.3) ** 2)
    return load.force_N + np.where(np.isnan(load.position_m), 0.0, pull)


def _warming(load: Load, size_mN: float) -> Array:
    return load.force_N + size_mN * 1e-3 * np.sin(0.5 * np.pi * load.samples.tau)


def _tilted(image: Image, size: float) -> tuple[Array, Array]:
    by = 1.0 - size * (0.8 * image.x_m + 0.6 * image.y_m) / 50e-3
    return image.x_m / by, image.y_m / by


def _k(words: str, name: str, where: str, **more: object) -> tuple[str, Acting]:
    sizes, unit = more.pop("sizes"), more.pop("unit")
    return name, acting(words, name, (where,), sizes, unit, **more)  # type: ignore[arg-type]


KNOWN: dict[str, Acting] = dict(
    [
        _k("Two capacitors charge side by side: what is left after t is 0.7 exp(-t/tau) +"
           " 0.3 exp(-t/(4 tau)), from where the pulse before ended.",
           "charging_lag", "time", sizes=(0.1, 0.4), unit="s", needs=SERIES, cases=_two_lags),
        _k("Water diffuses back: within a pulse the EIBM loses a sqrt(t/0.6 s).",
           "back_relaxation", "time", sizes=(0.12, 0.7), unit="", needs=SERIES,
           cases=_diffusing),
        _k("The EIBM of pulse k = 0, 1, ... falls short by a/(1 + exp((k - 2)/0.7)).",
           "first_pulse_transient", "time", sizes=(0.2, 0.8), unit="", cases=_waking),
        _k("The EIBM changes with the root of the session's time: 1 + c (sqrt(tau) - 2/3).",
           "eibm_drift", "time", sizes=(0.1, 0.7), unit="", cases=_tiring),
        _k("The stiffness dries towards an end, as 1 - exp(-2.5 tau), by c altogether.",
           "stiffness_drift", "time", sizes=(0.1, 0.8), unit="", cases=_drying),
        _k("In each run the stiffness relaxes as a hyperbola: B (1 - c t/(t + 3 s)).",
           "viscoelastic_creep", "time", sizes=(0.06, 0.35), unit="", cases=_giving_way),
        _k("The sheet leaves the clamp at an angle.", "clamp_angle", "rest_curvature",
           sizes=(0.015, 0.2), unit="rad", cases=_turned, parameters=lambda c: {"angle_rad": c}),
        _k("The scale of the arc's positions is wrong, by c at 30 mm and nothing at 0.",
           "position_error", "position", sizes=(0.6, 5.0), unit="mm", cases=_scaled),
        _k("The roll that is pressed holds the sheet aside: c tanh(N/0.3 mN).",
           "roll_offset", "position", sizes=(0.2, 1.5), unit="mm",
           setting=lambda c: {"pressed_offset_m": c * 1e-3}),
        _k("The rolls go on an arc whose radius is by a share c larger than stated.", "arc_error",
           "position", sizes=(0.005, 0.08), unit="", setting=lambda c: {"radius_error": c},
           parameters=lambda c: {"offset_mm": 40.0 * c, "of": 1.0}),
        _k("The stated curvature at rest is too small in proportion: k0 (1 + c/20 per m).",
           "initial_curvature", "rest_curvature", sizes=(1.5, 10.0), unit="1/m", law=_bent),
        _k("The electrodes are a line of resistors: Me falls as cosh((l - s)/d), d = 50 mm/c,"
           " with the same mean.", "nonuniform_eibm", "eibm", sizes=(1.2, 5.0), unit="",
           law=_line_of_resistors),
        _k("At positive voltage the crushed electrode gives less near the clamp:"
           " Me (1 - a exp(-s/15 mm)).", "eibm_asymmetry", "even_moment",
           sizes=(0.3, 0.9), unit="", law=_one_face),
        _k("The stiffness grows with the square of the distance: B (1 + c ((s/l)^2 - 1/3)).",
           "nonuniform_stiffness", "compliance", sizes=(0.25, 1.2), unit="", law=_thicker),
        _k("The sheet stiffens: B (1 + c (sqrt(1 + (u/20 per m)^2) - 1)), u = k - k0.",
           "nonlinear_stiffness", "compliance", sizes=(0.1, 0.6), unit="", law=_stiffening),
        _k("The weight of sheet and elongation, alike per length, acts in the picture's plane.",
           "gravity", "even_moment", sizes=(0.003, 0.03), unit="N/m",
           setting=lambda q: {"weight_N_per_m": q}, parameters=lambda q: {"load_N_per_m": q}),
        _k("The clamp is a hinge with a linear spring.", "clamp_compliance", "compliance",
           sizes=(60.0, 500.0), unit="rad/(N m)", setting=lambda c: {"clamp_rad_per_Nm": c},
           parameters=lambda c: {"rotation_rad_per_Nm": c}),
        _k("The glued joint of sheet and elongation turns under the moment there.",
           "elongation_flexibility", "compliance", sizes=(80.0, 1500.0), unit="rad/(N m)",
           setting=lambda c: {"hinge_rad_per_Nm": c}),
        _k("The load cell's beam is a linear spring along the arc.", "load_cell_compliance",
           "load_cell", sizes=(0.08, 0.8), unit="mm/mN", setting=lambda c: {"give_m_per_N": c},
           parameters=lambda c: {"compliance_mm_per_mN": c}),
        _k("The rolls rub: mu |N| d/sqrt(d^2 + (0.03 mm)^2), d slid since the pulse before.",
           "roll_friction", "position", sizes=(0.05, 0.3), unit="", slides=_rubs),
        _k("From 19 mm on the rolls hold back c (1 - exp(-|dF|/c)) of a change of the force.",
           "roll_sticking", "position", sizes=(0.1, 1.0), unit="mN", force=_sticks),
        _k("The zero rises as the cell warms: c sin(pi tau/2).", "force_drift", "load_cell",
           sizes=(0.1, 1.0), unit="mN", force=_warming),
        _k("The zero of the load cell is wrong.", "force_offset", "load_cell",
           sizes=(0.08, 1.0), unit="mN", force=lambda at, c: at.force_N + c * 1e-3,
           parameters=lambda c: {"force_mN": c}),
        _k("The load cell has play, two in parallel of c/2 and 3c/2.", "load_cell_hysteresis",
           "load_cell", sizes=(0.08, 0.6), unit="mN", force=_plays),
        _k("The load cell's axis is turned from the arc's tangent.", "load_cell_misalignment",
           "load_cell", sizes=(0.06, 0.5), unit="rad", force=_skew,
           parameters=lambda c: {"angle_rad": c}),
        _k("A meniscus pulls along the normal and tears as the sheet leans:"
           " c cos(gamma)/(1 + (gamma/0.3)^2).", "surface_tension", "load_cell",
           sizes=(0.1, 1.0), unit="mN", force=_meniscus),
        _k("The camera is tilted about an axis askew: r/(1 - c (0.8 x + 0.6 y)/50 mm).",
           "camera_perspective", "camera", sizes=(0.01, 0.2), unit="", image=_tilted),
        _k("The camera's pixels are not square: y (1 + c).", "camera_scale", "camera",
           sizes=(0.015, 0.2), unit="", image=lambda of, c: (of.x_m, of.y_m * (1.0 + c))),
        _k("The picture is older than the force.", "frame_delay", "camera", sizes=(0.44, 0.58),
           unit="s", needs=SERIES, delay_s=lambda c: c, parameters=lambda c: {"delay_s": c}),
    ]
)  # fmt: skip
