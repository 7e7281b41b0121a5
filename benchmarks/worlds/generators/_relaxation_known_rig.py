"""What the world `relaxation` hides of the catalogue, of clamp, stage, rolls, cell and camera."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._relaxation_acting import Act, Picture, act, to_frames
from benchmarks.worlds.generators._relaxation_strip import Array, Lanes, Setting, Strip
from benchmarks.worlds.session.effects import Load
from benchmarks.worlds.session.layout import Samples

JAW_RAD = 0.12  # the most that a jaw's pad lets the sheet turn
SLIDE_M = 50e-6  # of sliding that turns a roll's drag half round
PIVOT_RAD = 0.45
TILT_RAD = 0.6


# ------------------------------------------------------------------------- clamp, stage, rolls


def _askew(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.root_rad += size


def _padded(setting: Setting, _: Strip, size: float) -> None:
    def hinge(moment_Nm: Array) -> tuple[Array, Array]:
        part = np.tanh(size * moment_Nm / JAW_RAD)
        return JAW_RAD * part, size * (1.0 - part**2)

    setting.hinge = hinge


def _pivot(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.pivot_x_m += 1e-3 * size * np.cos(PIVOT_RAD)
    lanes.pivot_y_m += 1e-3 * size * np.sin(PIVOT_RAD)


def _long_arm(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.radius_m += 1e-3 * size


def _marked(lanes: Lanes, _at: Samples, strip: Strip, size: float) -> None:
    lanes.beta_rad += 1e-3 * size / strip.radius_m


def _worn_pinion(lanes: Lanes, _at: Samples, strip: Strip, size: float) -> None:
    place = lanes.beta_rad * strip.radius_m
    lanes.beta_rad += 1e-3 * size * (0.7 + 0.3 * place / 0.015) / strip.radius_m


def _gap(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.offset_m += 1e-3 * size


def _rubbing(contact_m: Array, at: Samples, size: float) -> Array:
    """Return what holds the sheet back as it slides: along it where the contact moves outwards."""
    held_back = np.zeros(len(contact_m))
    for rows in at.each_run():
        moved, z = np.diff(contact_m[rows]) / SLIDE_M, 0.0
        for row, step in zip(rows[1:].tolist(), moved.tolist(), strict=True):
            z = min(1.0, max(-1.0, z + step))
            held_back[row] = size * z
        to_frames(at, rows, held_back)
    return held_back


CONTACT: dict[str, Act] = {
    "jaw_askew": act(
        "The jaw is mounted askew: the sheet leaves it at the angle c.", "clamp_angle",
        "rest_curvature position camera", (0.01, 0.2), "rad", lanes=_askew,
        parameters=lambda c: {"angle_rad": c}),
    "padded_jaw": act(
        "The jaw has a soft pad that closes: the sheet turns by 0.12 tanh(c M/0.12), M the load's"
        " moment at the clamp.", "clamp_compliance", "compliance", (30.0, 3e3), "rad/(N m)",
        alters=_padded),
    "pivot_off": act(
        "The arm's pivot is c from the clamp, at 0.45 rad.", "arc_error", "position", (0.4, 4.0),
        "mm", lanes=_pivot),
    "long_arm": act(
        "The arm that carries the cell is c longer; its angle is right.", "arc_error", "position",
        (0.3, 3.0), "mm", lanes=_long_arm),
    "wrong_mark": act(
        "The stage's zero mark is c too far along the arc.", "position_error", "position",
        (0.3, 5.0), "mm", lanes=_marked, parameters=lambda c: {"offset_mm": c}),
    "worn_pinion": act(
        "The stage's pinion is worn: p + c (0.7 + 0.3 p/15 mm).", "position_error", "position",
        (0.3, 4.0), "mm", lanes=_worn_pinion),
    "roll_gap": act(
        "The middle of the rolls' gap is c beside the arc's point.", "roll_offset", "position",
        (0.25, 2.5), "mm", lanes=_gap, parameters=lambda c: {"offset_mm": c}),
    "rubbing_rolls": act(
        "The rolls hold the sheet back with z c |N|; z grows by 1 in 50 um of sliding, up to 1,"
        " and is 0 as the run begins.", "roll_friction", "position load_cell", (0.1, 0.6), "-",
        rubs=_rubbing),
}  # fmt: skip


# ----------------------------------------------------------------------------------- load cell


def _play(load: Load, half_N: Array) -> Array:
    """Return what a play of this half width (n,) adds to the force."""
    at, shown = load.samples, load.force_N.copy()
    for rows in at.each_run():
        here = shown[rows[0]] if len(rows) else 0.0
        for row in rows.tolist():
            force = load.force_N[row]
            here = max(force - half_N[row], min(force + half_N[row], here))
            shown[row] = here
    return shown - load.force_N


def _sticking(load: Load, _: Strip, size: float) -> Array:
    far = 1.0 / (1.0 + np.exp(-(np.nan_to_num(load.position_m) - 0.021) / 0.0012))
    return _play(load, abs(1e-3 * size) * far)


def _lazy(load: Load, _: Strip, size: float) -> Array:
    ones = np.full(len(load.force_N), abs(1e-3 * size))
    return np.asarray(sum(_play(load, w * ones) for w in (0.5, 1.0, 1.5)) / 3.0)


def _offset(load: Load, _: Strip, size: float) -> Array:
    return np.full(len(load.force_N), 1e-3 * size)


def _warming(load: Load, _: Strip, size: float) -> Array:
    tau = load.samples.tau
    risen = -0.65 * np.expm1(-tau / 0.12) - 0.35 * np.expm1(-tau / 0.7)
    return np.asarray(1e-3 * size * risen)


def _turned(load: Load, _: Strip, size: float) -> Array:
    shown = load.force_N * np.cos(size) - load.outward_N * np.sin(size)
    return np.asarray(shown - load.force_N)


def _bridge(load: Load, strip: Strip, size: float) -> Array:
    wet = np.exp(-load.samples.wetted_s / 45.0) * (1.0 if strip.elongation_m else 0.5)
    return np.asarray(1e-3 * size * wet * (np.cos(load.lean_rad) + 0.4 * np.sin(load.lean_rad)))


def _yielding_arm(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.give_m_per_N += size  # 1 mm/mN is 1 m/N


CELL: dict[str, Act] = {
    "sticking": act(
        "Far out the rolls hold the force back like a play of half width"
        " c/(1 + exp(-(p - 21 mm)/1.2 mm)).", "roll_sticking", "position load_cell", (0.1, 2.0),
        "mN", felt=_sticking),
    "lazy_cell": act(
        "The cell's glue lets it follow by three plays of c/2, c and 3 c/2, a third each.",
        "load_cell_hysteresis", "load_cell", (0.06, 0.8), "mN", felt=_lazy),
    "zero": act(
        "The cell's zero is c.", "force_offset", "load_cell", (0.05, 4.0), "mN", felt=_offset,
        parameters=lambda c: {"force_mN": c}),
    "warming_cell": act(
        "The bridge warms fast and its body slowly: c (0.65 (1 - exp(-tau/0.12)) + 0.35 (1 -"
        " exp(-tau/0.7))).", "force_drift", "load_cell", (0.1, 4.0), "mN", felt=_warming),
    "turned_cell": act(
        "The cell's axis is turned by c from the arc: N cos(gamma - c).",
        "load_cell_misalignment", "load_cell", (0.06, 0.6), "rad", felt=_turned,
        parameters=lambda c: {"angle_rad": c}),
    "bridge_of_water": act(
        "A bridge of water on the lee roll pulls by c exp(-t/45 s) (cos gamma + 0.4 sin gamma), t"
        " since wetting; half of it at the long sheet.", "surface_tension", "load_cell",
        (0.15, 3.0), "mN", felt=_bridge),
    "yielding_arm": act(
        "The arm under the cell bends along the arc, by c times the force.",
        "load_cell_compliance", "load_cell position", (0.05, 2.0), "mm/mN", lanes=_yielding_arm,
        parameters=lambda c: {"compliance_mm_per_mN": c}),
}  # fmt: skip


# -------------------------------------------------------------------------------------- camera


def _tilted(picture: Picture, size: float) -> None:
    far = picture.x_m * np.cos(TILT_RAD) + picture.y_m * np.sin(TILT_RAD)
    near = 1.0 / (1.0 - size * far / 0.05)
    picture.x_m, picture.y_m = picture.x_m * near, picture.y_m * near


def _rolled(picture: Picture, size: float) -> None:
    c, s = np.cos(size), np.sin(size)
    x, y = picture.x_m, picture.y_m
    picture.x_m, picture.y_m = c * x - s * y, s * x + c * y


def _scaled(picture: Picture, size: float) -> None:
    picture.x_m, picture.y_m = (1.0 + size) * picture.x_m, (1.0 + size) * picture.y_m


CAMERA: dict[str, Act] = {
    "tilted_camera": act(
        "The camera is tilted: r/(1 - c u/50 mm), u along 0.6 rad.", "camera_perspective",
        "camera", (0.005, 0.2), "-", seen=_tilted),
    "rolled_camera": act(
        "The camera is turned about its axis: the picture about the clamp, by c.", "camera_roll",
        "camera position rest_curvature", (0.004, 0.15), "rad", seen=_rolled,
        parameters=lambda c: {"angle_rad": c}),
    "wrong_scale": act(
        "The ruler in view was read wrong: lengths are 1 + c of the true ones.", "camera_scale",
        "camera", (0.004, 0.2), "-", seen=_scaled, parameters=lambda c: {"relative_error": c}),
    "late_frames": act(
        "Frames wait in a buffer and are c older than their readings.", "frame_delay",
        "camera time", (0.3, 0.49), "s", delay_s=lambda c: c,
        parameters=lambda c: {"delay_s": c}),
}  # fmt: skip
