"""What no catalogue has."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._magnus_acting import Own, Seen, hidden, per_slot, timing
from benchmarks.worlds.generators._magnus_rod import Cases, Law, Section
from benchmarks.worlds.generators._magnus_specimen import RADIUS_M
from benchmarks.worlds.session.effects import Array, Load, Sheet
from benchmarks.worlds.session.layout import READING, Samples

KNOCKED_AT = 0.4  # of the session
WAVE_M, WINDOW_M = 19e-3, 18e-3
GUST_S = 47.0
ROLL_M = 1.2e-3


# ---------------------------------------------------------------------------- the sheet


def _loose(cases: Cases, at: Samples, _sheet: Sheet, lost: float) -> None:
    weak = (2 * at.pulse + at.run) % 5 == 0
    cases.moment_Nm *= np.where(weak, 1.0 - lost, 1.0)


def _draught(cases: Cases, at: Samples, _sheet: Sheet, size: float) -> None:
    cases.load_N_per_m += size * np.sin(2.0 * np.pi * at.session_s / GUST_S)


def _wet_middle(cases: Cases, _at: Samples, _sheet: Sheet, size: float) -> None:
    p = np.nan_to_num(cases.position_m, nan=0.0)
    cases.moment_Nm *= 1.0 + size * np.sin(np.pi * p / 30e-3)


def _two_hands(cases: Cases, at: Samples, _sheet: Sheet, size: float) -> None:
    wetter = at.run % 2 == 1
    cases.stiffness_Nm2 *= np.where(wetter, 1.0 - size, 1.0)
    cases.moment_Nm *= np.where(wetter, 1.0 + size, 1.0)


def _gutter(size: float) -> Law:
    def law(at: Section) -> None:
        flat = 1.0 / (1.0 + (at.curvature_per_m / 20.0) ** 2)
        at.stiffness_Nm2 = at.stiffness_Nm2 * (1.0 + size * flat)

    return law


def _shorting(cases: Cases, _at: Samples, _sheet: Sheet, lost: float) -> None:
    cases.moment_Nm *= np.where(np.isnan(cases.position_m), 1.0, 1.0 - lost)


def _bends_inside(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.root_rad += size_mm * 1e-3 * cases.moment_Nm / cases.stiffness_Nm2


# ---------------------------------------------------------------------------- where it is held


def _settles(cases: Cases, at: Samples, _sheet: Sheet, size_mm: float) -> None:
    cases.position_m += size_mm * 1e-3 * np.exp(-at.time_s / 5.0)


def _wavy(cases: Cases, _at: Samples, _sheet: Sheet, size_mm: float) -> None:
    p = np.nan_to_num(cases.position_m, nan=0.0)
    more = size_mm * 1e-3 * np.sin(2.0 * np.pi * p / WAVE_M)
    cases.farther_m += more
    cases.position_m *= 1.0 + more / RADIUS_M  # the stage counts angles


def _eccentric(cases: Cases, s_hat: Array, _normal: Array, _at: Samples, size_mm: float) -> None:
    cases.offset_m += size_mm * 1e-3 * np.sin((s_hat - RADIUS_M) / ROLL_M)


# ---------------------------------------------------------------------------- the load cell


def _guide(load: Load, size: float) -> Array:
    return load.force_N - size * np.abs(load.outward_N) * np.tanh(load.force_N / 0.1e-3)


def _tension(load: Load, size: float) -> Array:
    return load.force_N + size * np.maximum(load.force_N, 0.0)


def _slow(load: Load, tau_s: float) -> Array:
    """A filter of first order behind the force, which changes at the edges."""
    at, force = load.samples, load.force_N
    pulse_s, _ = timing(at)
    settled, before = per_slot(force, at)
    jump = before - settled  # at the edge that a sample follows
    kept = np.exp(-pulse_s / tau_s)
    behind = np.zeros(len(force))
    for number in np.unique(at.run):
        own = at.run == number
        read = np.flatnonzero(own & (at.role == READING))
        jumps = np.zeros(1 + int(np.max(at.slot[own])))
        jumps[at.slot[read]] = jump[read]
        begins, left = np.zeros(len(jumps)), 0.0
        for slot, one in enumerate(jumps.tolist()):
            begins[slot] = left + one
            left = begins[slot] * kept
        behind[own] = begins[at.slot[own]]
    return np.asarray(force + behind * np.exp(-np.maximum(at.phase_s, 0.0) / tau_s))


def _heavy_rolls(load: Load, size_mN: float) -> Array:
    beta = np.nan_to_num(load.position_m, nan=0.0) / RADIUS_M
    return load.force_N + size_mN * 1e-3 * np.sin(beta)


def _warm_wires(load: Load, size_mN: float) -> Array:
    at = load.samples
    pulse_s, _ = timing(at)
    driven = np.where(at.pulse < 0.0, 0.0, at.pulse * pulse_s + np.maximum(at.phase_s, 0.0))
    rise = size_mN * 1e-3 * (1.0 - np.exp(-driven / 6.0))
    return load.force_N + np.where(np.isnan(load.position_m), 0.0, rise)


# ---------------------------------------------------------------------------- the camera


def _knocked(image: Seen, size_mm: float) -> tuple[Array, Array]:
    after = size_mm * 1e-3 * (image.at.tau > KNOCKED_AT)[:, None]
    return image.x_m + 0.6 * after, image.y_m + 0.8 * after


def _window(image: Seen, size_mm: float) -> tuple[Array, Array]:
    aside = size_mm * 1e-3 * np.sin(2.0 * np.pi * image.x_m / WINDOW_M)
    return image.x_m, image.y_m + aside


def _lamp(image: Seen, size_mm: float) -> tuple[Array, Array]:
    s, c = np.sin(image.phi_rad), np.cos(image.phi_rad)
    aside = size_mm * 1e-3 * s**2
    return image.x_m - aside * s, image.y_m + aside * c


def _zooming(image: Seen, size: float) -> tuple[Array, Array]:
    by = 1.0 + size * (image.at.tau - 0.5)[:, None]
    return image.x_m * by, image.y_m * by


def _twisted(image: Seen, size: float) -> tuple[Array, Array]:
    out = np.hypot(image.x_m, image.y_m) / 50e-3
    by = 1.0 + size * 0.5 * image.at.sheet_V[:, None] * out
    return image.x_m * by, image.y_m * by


FURTHER: dict[str, Own] = {
    "loose_contact": hidden(
        "A contact of the electrodes is loose: two pulses of each ten have 1 - c of the EIBM.",
        None, "time eibm", (0.12, 0.8), "", cases=_loose),
    "draught": hidden(
        "The ventilation blows on the sheet: a load of c sin(2 pi t/47 s) per length along -y.",
        None, "even_moment time", (0.004, 0.03), "N/m", cases=_draught),
    "wet_middle": hidden(
        "It is wetted best amid the arc: EIBM (1 + c sin(pi p/30 mm)).",
        None, "eibm position", (0.06, 0.8), "", cases=_wet_middle),
    "two_hands": hidden(
        "Two people wet the sheet in turn: in every second run B (1 - c) and EIBM (1 + c).",
        None, "compliance eibm time", (0.04, 0.4), "", cases=_two_hands),
    "gutter": hidden(
        "The sheet is hollow across, stiffer where it is straight: B (1 + c/(1 + (k/20 per m)^2)).",
        None, "compliance", (0.12, 0.9), "", law=_gutter),
    "shorting_rolls": hidden(
        "The wet rolls short the electrodes: a sheet that is held has 1 - c of the EIBM.",
        None, "eibm position", (0.08, 0.6), "", ("free_shapes",), cases=_shorting),
    "bends_in_the_clamp": hidden(
        "The sheet bends inside the clamp, where a length c of it is driven: phi(0) = c Me/B.",
        None, "eibm rest_curvature compliance", (0.3, 3.5), "mm", cases=_bends_inside),
    "settling_stage": hidden(
        "The stage stands on rubber and settles after it was moved: p + c exp(-t/5 s).",
        None, "position time", (0.25, 3.0), "mm", cases=_settles),
    "wavy_rail": hidden(
        "The rail of the arc is bent: its radius is R + c sin(2 pi p/19 mm).",
        None, "position", (0.25, 2.5), "mm", cases=_wavy),
    "eccentric_roll": hidden(
        "The roll turns about a point off its middle: it holds the sheet aside by"
        " c sin((s_hat - R)/1.2 mm).",
        None, "position", (0.15, 0.6), "mm", again=_eccentric),
    "bowed_elongation": hidden(
        "The elongation is not straight but an arc of curvature c.",
        None, "rest_curvature position", (0.6, 8.0), "1/m",
        setting=lambda c: {"bar_bow_per_m": c}),
    "rubbing_guide": hidden(
        "The load cell's guide rubs under the radial force Q: F - c |Q| tanh(F/0.1 mN).",
        None, "load_cell position", (0.1, 1.0), "", force=_guide),
    "tension_gain": hidden(
        "The load cell's gain differs between pull and push: F (1 + c) where F > 0.",
        None, "load_cell", (0.04, 0.6), "", force=_tension),
    "slow_meter": hidden(
        "The meter filters the force with a time constant c, not the pictures.",
        None, "load_cell time", (0.12, 0.8), "s", force=_slow),
    "heavy_rolls": hidden(
        "The rig leans, and the rolls weigh on the load cell as it turns: F + c sin(p/R).",
        None, "load_cell position", (0.1, 2.0), "mN", force=_heavy_rolls),
    "warm_wires": hidden(
        "The current warms the load cell: F + c (1 - exp(-t/6 s)), t under voltage in each run.",
        None, "load_cell time even_moment", (0.08, 1.0), "mN", force=_warm_wires),
    "knocked_camera": hidden(
        "Somebody knocks the camera after two fifths of the session: pictures lie c aside since.",
        None, "camera time", (0.12, 2.0), "mm", image=_knocked),
    "wavy_window": hidden(
        "The sheet is seen through a wavy window: y + c sin(2 pi x/18 mm).",
        None, "camera", (0.06, 0.6), "mm", image=_window),
    "lamp": hidden(
        "The lamp's shadow draws the curve aside where the sheet turns: c sin(phi)^2.",
        None, "camera", (0.1, 1.5), "mm", image=_lamp),
    "zooming": hidden(
        "The lens warms up: the scale changes by c (tau - 1/2) over the session.",
        None, "camera time", (0.008, 0.1), "", image=_zooming),
    "twisting": hidden(
        "The sheet twists under voltage towards the camera: r (1 + c (V/2 V) r/50 mm).",
        None, "camera eibm", (0.008, 0.12), "", image=_twisted),
}  # fmt: skip
