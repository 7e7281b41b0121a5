"""What catalogues know, in this world's words and formulas."""

from __future__ import annotations

import numpy as np
from scipy.special import erfcx

from benchmarks.worlds.generators._magnus_acting import (
    SERIES,
    Own,
    Seen,
    hidden,
    since_slot_before,
    timing,
)
from benchmarks.worlds.generators._magnus_rod import Cases, Law, Section
from benchmarks.worlds.generators._magnus_specimen import LAYOUT
from benchmarks.worlds.session.effects import Array, Load, Sheet
from benchmarks.worlds.session.layout import Samples

FADES = 0.5  # from one pulse's deficit to the next
SLIDING_M = 0.02e-3
STICKS_FROM_M, STICKS_FULLY_M = 16e-3, 26e-3
PLAYS = np.array([0.2, 0.6, 1.0, 1.4, 1.8])  # widths of the plays over the mean one
RELAXING_S = 0.5, 3.0, 18.0
DRIES_S = 90.0


# ---------------------------------------------------------------------------- in time


def _diffusive(cases: Cases, at: Samples, sheet: Sheet, root_s: float) -> None:
    """What is left to do after t, behind the rise: exp(t/tau) erfc(sqrt(t/tau)), tau = root_s^2."""

    def left(t: Array) -> Array:
        rising = np.exp(-t / LAYOUT.rise_s)
        return np.asarray(rising + (1.0 - rising) * erfcx(np.sqrt(t) / root_s))

    period = float(left(np.array(timing(at)[0])))
    slots, rows = np.unique(at.slot, return_index=True)
    begins, end = np.zeros(1 + int(slots[-1])), 0.0
    for slot, volts in zip(slots.tolist(), at.drive_V[rows].tolist(), strict=True):
        begins[slot] = end
        end = volts + (end - volts) * period
    behind = at.drive_V + (begins[at.slot] - at.drive_V) * left(np.maximum(at.phase_s, 0.0))
    cases.moment_Nm += sheet.eibm_Nm(behind) - sheet.eibm_Nm(at.sheet_V)


def _leaking(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    _, sample_s = timing(at)
    gone = np.log1p(np.maximum(at.phase_s, 0.0) / 0.05) / np.log1p(sample_s / 0.05)
    cases.moment_Nm *= 1.0 - lost * gone


def _waking(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    pulse_s, sample_s = timing(at)
    k = at.pulse + (at.phase_s - sample_s) / pulse_s
    cases.moment_Nm *= 1.0 - lost * FADES ** np.where(at.pulse < 0.0, 0.0, k)


def _wearing(cases: Cases, at: Samples, _sheet: Sheet, change: float) -> None:
    cases.moment_Nm *= 1.0 + change * (at.tau - 0.5)


def _fatigued(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    cases.moment_Nm *= 1.0 + lost * (np.exp(-3.0 * at.tau) - (1.0 - np.exp(-3.0)) / 3.0)


def _drying(cases: Cases, at: Samples, _sheet: Sheet, change: float) -> None:
    cases.stiffness_Nm2 *= 1.0 + change * (1.5 * at.tau - 0.5 * at.tau**3 - 0.625)


def _relaxing(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    gone = np.mean([1.0 - np.exp(-at.time_s / tau) for tau in RELAXING_S], axis=0)
    cases.stiffness_Nm2 *= 1.0 - lost * gone


# ---------------------------------------------------------------------------- the sheet


def _more_curved(cases: Cases, _at: Samples, _sheet: Sheet, size: float) -> None:
    cases.bow_per_m += size


def _turned(cases: Cases, _at: Samples, _sheet: Sheet, angle: float) -> None:
    cases.root_rad += angle


def _heavy(cases: Cases, _at: Samples, _sheet: Sheet, load: float) -> None:
    cases.load_N_per_m += load


def _falling(size: float) -> Law:
    def law(at: Section) -> None:
        whole = at.length_m * size / 50e-3
        fall = np.exp(-at.s_m * size / 50e-3) * whole / -np.expm1(-whole)
        at.eibm_Nm = at.eibm_Nm * fall

    return law


def _thinning(size: float) -> Law:
    def law(at: Section) -> None:
        less = 1.0 - size * at.s_m / at.length_m
        at.eibm_Nm = at.eibm_Nm * less / (1.0 - 0.5 * size)

    return law


def _other_face(size: float) -> Law:
    def law(at: Section) -> None:
        near = 1.0 + size * (1.0 - 2.0 * at.s_m / at.length_m)
        at.eibm_Nm = at.eibm_Nm * np.where(at.eibm_Nm < 0.0, near, 1.0)

    return law


def _graded(size: float) -> Law:
    def law(at: Section) -> None:
        share = (1.0 + size * at.s_m / at.length_m) / (1.0 + 0.5 * size)
        at.stiffness_Nm2 = at.stiffness_Nm2 * share

    return law


def _stiffening(size: float) -> Law:
    def law(at: Section) -> None:
        v = ((at.curvature_per_m - at.rest_per_m) / 25.0) ** 2
        at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * v / (1.0 + v))

    return law


# ---------------------------------------------------------------------------- rolls and cell


def _moved(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.position_m += size_mm * 1e-3


def _wider(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.farther_m += size_mm * 1e-3


def _beside(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.offset_m += size_mm * 1e-3


def _rubs(cases: Cases, s_hat: Array, normal: Array, at: Samples, coefficient: float) -> None:
    slid = since_slot_before(s_hat, at)
    cases.rubbing += np.sign(normal) * coefficient * np.arctan(slid / SLIDING_M) * 2.0 / np.pi


def _play(force: Array, at: Samples, width: Array) -> Array:
    """Return what follows a force with a play to either side, begun in its middle by each run."""
    result = force.copy()
    for rows in at.each_run():
        z = force[rows[0]]
        for row, f, w in zip(
            rows.tolist(), force[rows].tolist(), width[rows].tolist(), strict=True
        ):
            z = min(max(z, f - w), f + w)
            result[row] = z
    return result


def _sticks(load: Load, size_mN: float) -> Array:
    position = np.nan_to_num(load.position_m, nan=0.0)
    deep = np.clip((position - STICKS_FROM_M) / (STICKS_FULLY_M - STICKS_FROM_M), 0.0, 1.0)
    return _play(load.force_N, load.samples, abs(size_mN) * 1e-3 * deep)


def _lagging(load: Load, size_mN: float) -> Array:
    one = np.full(len(load.force_N), abs(size_mN) * 1e-3)
    plays = [_play(load.force_N, load.samples, one * width) for width in PLAYS]
    return np.asarray(np.mean(plays, axis=0))


def _askew(load: Load, angle: float) -> Array:
    return load.force_N * np.cos(angle) - load.outward_N * np.sin(angle)


def _meniscus(load: Load, size_mN: float) -> Array:
    left = np.maximum(1.0 - np.sqrt(np.maximum(load.samples.wetted_s, 0.0) / DRIES_S), 0.0)
    pull = size_mN * 1e-3 * np.cos(load.lean_rad) * left
    return load.force_N + np.where(np.isnan(load.position_m), 0.0, pull)


# ---------------------------------------------------------------------------- the camera


def _tilted(image: Seen, size: float) -> tuple[Array, Array]:
    by = 1.0 - size * (0.87 * image.x_m - 0.5 * image.y_m) / 50e-3
    return image.x_m / by, image.y_m / by


def _rolled(image: Seen, angle: float) -> tuple[Array, Array]:
    c, s = np.cos(angle), np.sin(angle)
    return image.x_m * c - image.y_m * s, image.x_m * s + image.y_m * c


def _larger(image: Seen, size: float) -> tuple[Array, Array]:
    return image.x_m * (1.0 + size), image.y_m * (1.0 + size)


KNOWN: dict[str, Own] = {
    "diffusive_charging": hidden(
        "The double layer charges by diffusion: what is left to do after t is"
        " exp(t/tau) erfc(sqrt(t/tau)), tau = c^2, from where the pulse before ended.",
        "charging_lag", "time", (0.06, 0.45), "s^(1/2)", (SERIES,), cases=_diffusive),
    "leaking_back": hidden(
        "Within a pulse the EIBM loses c ln(1 + t/0.05 s)/ln(1 + 0.5/0.05).",
        "back_relaxation", "time", (0.12, 0.7), "", (SERIES,), cases=_leaking),
    "first_pulses": hidden(
        "The EIBM of pulse k = 0, 1, ... falls short by c/2^k, and so on between the readings.",
        "first_pulse_transient", "time", (0.15, 0.55), "", cases=_waking,
        parameters=lambda c: {"relative_deficit": c, "ratio": FADES}),
    "wearing": hidden(
        "The EIBM changes evenly over the session: 1 + c (tau - 1/2).",
        "eibm_drift", "time", (0.08, 1.2), "", cases=_wearing,
        parameters=lambda c: {"relative_change": c}),
    "fatigue": hidden(
        "The EIBM falls at first quickly and then slowly, as c exp(-3 tau) over the session.",
        "eibm_drift", "time", (0.1, 1.0), "", cases=_fatigued),
    "drying_through": hidden(
        "The sheet dries through, and its stiffness grows as B (1 + c (3 tau - tau^3)/2 - 5 c/8).",
        "stiffness_drift", "time", (0.08, 0.8), "", cases=_drying),
    "three_relaxations": hidden(
        "In each run the stiffness relaxes with 0.5, 3 and 18 s, a third of c with each.",
        "viscoelastic_creep", "time", (0.06, 0.4), "", cases=_relaxing),
    "crooked_clamp": hidden(
        "The sheet leaves the clamp at an angle c.", "clamp_angle", "rest_curvature",
        (0.01, 0.2), "rad", cases=_turned, parameters=lambda c: {"angle_rad": c}),
    "curled": hidden(
        "At rest the sheets are more curved than stated, by c everywhere.",
        "initial_curvature", "rest_curvature", (0.8, 12.0), "1/m", cases=_more_curved,
        parameters=lambda c: {"curvature_error_per_m": c}),
    "resistive_electrode": hidden(
        "The EIBM falls as exp(-s/(50 mm/c)), with the mean that it had.",
        "nonuniform_eibm", "eibm", (0.7, 7.0), "", law=_falling,
        parameters=lambda c: {"decay_length_mm": 50.0 / c}),
    "thinning_electrode": hidden(
        "The EIBM falls in a straight line, by c at the end: (1 - c s/l)/(1 - c/2).",
        "nonuniform_eibm", "eibm", (0.3, 0.95), "", law=_thinning),
    "other_face": hidden(
        "At negative voltage the EIBM is more at the clamp and less at the end: 1 + c (1 - 2 s/l).",
        "eibm_asymmetry", "even_moment", (0.2, 0.9), "", law=_other_face),
    "leaning_rig": hidden(
        "The rig leans, and a weight of c per length, elongation included, acts along -y.",
        "gravity", "even_moment", (0.004, 0.04), "N/m", cases=_heavy,
        parameters=lambda c: {"load_N_per_m": c}),
    "loose_clamp": hidden(
        "The clamp turns by c times the moment of the load.",
        "clamp_compliance", "compliance", (60.0, 600.0), "rad/(N m)",
        setting=lambda c: {"clamp_rad_per_Nm": c},
        parameters=lambda c: {"rotation_rad_per_Nm": c}),
    "rocking_joint": hidden(
        "The elongation's joint rocks to a stop: it turns by c tanh(M/0.05 N mm).",
        "elongation_flexibility", "compliance", (0.012, 0.15), "rad",
        setting=lambda c: {"joint_rad": c}),
    "stiffening": hidden(
        "The sheet stiffens to an end: B (1 + c v^2/(1 + v^2)), v = (k - k0)/25 per m.",
        "nonlinear_stiffness", "compliance", (0.08, 1.0), "", law=_stiffening),
    "graded": hidden(
        "The stiffness grows evenly along the sheet: B (1 + c s/l)/(1 + c/2).",
        "nonuniform_stiffness", "compliance", (0.15, 5.0), "", law=_graded,
        parameters=lambda c: {"relative_change": c}),
    "wide_arc": hidden(
        "The arc's radius is c more than stated; positions are lengths on it.",
        "arc_error", "position", (0.25, 4.0), "mm", cases=_wider,
        parameters=lambda c: {"offset_mm": c}),
    "misplaced": hidden(
        "The load cell stands c farther along the arc than it is said to.",
        "position_error", "position", (0.25, 4.0), "mm", cases=_moved,
        parameters=lambda c: {"offset_mm": c}),
    "rubbing": hidden(
        "The rolls rub: c |N| (2/pi) atan(d/0.02 mm), d slid since the pulse before.",
        "roll_friction", "position", (0.05, 0.4), "", again=_rubs),
    "thick_rolls": hidden(
        "The point on the arc lies c to the sheet's left.",
        "roll_offset", "position", (0.25, 3.0), "mm", cases=_beside,
        parameters=lambda c: {"offset_mm": c}),
    "sticking": hidden(
        "The rolls hold the force back by a play, from none at 16 mm to c from 26 mm on.",
        "roll_sticking", "position", (0.12, 1.2), "mN", force=_sticks),
    "warming_cell": hidden(
        "The zero rises evenly over the session, by c.", "force_drift", "load_cell",
        (0.1, 2.0), "mN", force=lambda at, c: at.force_N + c * 1e-3 * at.samples.tau,
        parameters=lambda c: {"force_mN": c}),
    "wrong_zero": hidden(
        "The zero of the load cell is c.", "force_offset", "load_cell", (0.06, 1.5), "mN",
        force=lambda at, c: at.force_N + c * 1e-3, parameters=lambda c: {"force_mN": c}),
    "yielding_cell": hidden(
        "The load cell gives way along the arc, by c times the force.",
        "load_cell_compliance", "load_cell", (0.06, 1.0), "mm/mN",
        setting=lambda c: {"give_m_per_N": c},
        parameters=lambda c: {"compliance_mm_per_mN": c}),
    "loops": hidden(
        "The load cell's loop has rounded ends: five plays from c/5 to 9c/5, their mean.",
        "load_cell_hysteresis", "load_cell", (0.06, 0.6), "mN", force=_lagging),
    "askew_cell": hidden(
        "The load cell's axis is turned by c: it shows N cos(gamma - c).",
        "load_cell_misalignment", "load_cell", (0.05, 0.5), "rad", force=_askew,
        parameters=lambda c: {"angle_rad": c}),
    "meniscus": hidden(
        "A meniscus pulls along the normal, and dries: c cos(gamma) (1 - sqrt(t/90 s)).",
        "surface_tension", "load_cell", (0.12, 2.0), "mN", force=_meniscus),
    "tilted_camera": hidden(
        "The camera looks askew: r/(1 - c (0.87 x - 0.5 y)/50 mm).",
        "camera_perspective", "camera", (0.008, 0.2), "", image=_tilted),
    "rolled_camera": hidden(
        "Pictures are turned by c about the clamp.", "camera_roll", "camera", (0.01, 0.2), "rad",
        image=_rolled, parameters=lambda c: {"angle_rad": c}),
    "wrong_scale": hidden(
        "Lengths in pictures are 1 + c of the true ones.", "camera_scale", "camera",
        (0.006, 0.2), "", image=_larger, parameters=lambda c: {"relative_error": c}),
    "old_pictures": hidden(
        "A picture is c older than its reading.", "frame_delay", "camera", (0.42, 0.5), "s",
        (SERIES,), delay_s=lambda c: c, parameters=lambda c: {"delay_s": c}),
}  # fmt: skip
