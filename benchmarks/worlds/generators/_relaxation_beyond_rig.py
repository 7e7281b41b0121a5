"""What the world `relaxation` hides that no catalogue has, of load cell, its meter, and camera."""

from __future__ import annotations

import numpy as np
from scipy.ndimage import gaussian_filter1d

from benchmarks.worlds.generators._relaxation_acting import Act, Picture, act
from benchmarks.worlds.generators._relaxation_strip import Array, Strip
from benchmarks.worlds.session.effects import Load

DROP_M, DROP_WIDE_M = (0.026, 0.006), 0.008
LAMP_RAD = 0.9
AXIS_M = (0.025, 0.005)  # where the lens looks at


# ----------------------------------------------------------------------------------- load cell


def _dead(load: Load, _: Strip, size: float) -> Array:
    band, force = 1e-3 * size, load.force_N
    return np.asarray(-force * band**2 / (force**2 + band**2))


def _pushed(load: Load, _: Strip, size: float) -> Array:
    return np.asarray(size * np.maximum(load.force_N, 0.0))


def _bridge_supply(load: Load, _: Strip, size: float) -> Array:
    risen = np.exp(-0.5 / 0.25) - np.exp(-load.samples.tau / 0.25)
    return np.asarray(size * risen * load.force_N)


def _ground(load: Load, _: Strip, size: float) -> Array:
    return np.asarray(1e-3 * size * load.samples.sheet_V / 2.0)


def _pickup(load: Load, _: Strip, size: float) -> Array:
    at = load.samples
    step = (at.drive_V - at.before_V) / 4.0
    return np.asarray(1e-3 * size * step * np.exp(-np.maximum(at.phase_s, 0.0) / 0.28))


def _slow(load: Load, _: Strip, size: float) -> Array:
    """Return what a first-order lag takes from the force, straight from sample to sample."""
    at, shown = load.samples, load.force_N.copy()
    for rows in at.each_run():
        force, h = load.force_N[rows], np.diff(at.time_s[rows])
        x = np.maximum(h / abs(size), 1e-12)
        kept, share = np.exp(-x), 1.0 + np.expm1(-x) / x
        here = float(force[0]) if len(force) else 0.0
        for k, row in enumerate(rows[1:].tolist()):
            late = force[k] + share[k] * (force[k + 1] - force[k])
            here = kept[k] * (here - force[k]) + late
            shown[row] = here
    return shown - load.force_N


def _humming(load: Load, _: Strip, size: float) -> Array:
    return np.asarray(1e-3 * size * np.sin(2.0 * np.pi * 0.113 * load.samples.session_s + 0.5))


def _tared(load: Load, _: Strip, size: float) -> Array:
    at, result = load.samples, np.zeros(len(load.force_N))
    for number in np.unique(at.run):
        own = at.run == number
        before = own & (at.pulse < 0.0)
        if np.any(before):
            result[own] = -size * np.mean(load.force_N[before])
    return result


def _left_behind(load: Load, _: Strip, size: float) -> Array:
    turned = size * np.nan_to_num(load.position_m) / 0.03
    shown = load.force_N * np.cos(turned) - load.outward_N * np.sin(turned)
    return np.asarray(shown - load.force_N)


def _rolls_weigh(load: Load, strip: Strip, size: float) -> Array:
    return np.asarray(1e-3 * size * np.sin(np.nan_to_num(load.position_m) / strip.radius_m))


CELL: dict[str, Act] = {
    "dead_band": act(
        "The cell's guide is stiff about its zero: it shows F F^2/(F^2 + c^2).", None,
        "load_cell", (0.15, 1.5), "mN", felt=_dead),
    "push_and_pull": act(
        "The cell shows 1 + c of a push, a force along the arc, and 1 of a pull.", None,
        "load_cell", (0.06, 1.0), "-", felt=_pushed),
    "bridge_supply": act(
        "The bridge's supply rises as it warms: its gain changes by -c exp(-tau/0.25) from that"
        " amid the session.", None, "load_cell time", (0.08, 0.8), "-", felt=_bridge_supply),
    "common_ground": act(
        "The sheet's current lifts the bridge's ground: c at 2 V is added.", None, "load_cell",
        (0.06, 2.0), "mN", felt=_ground),
    "pickup": act(
        "The bridge's input is charged by each step of the voltage: c exp(-t/0.28 s) for 4 V.",
        None, "load_cell time", (0.4, 6.0), "mN", felt=_pickup),
    "slow_meter": act(
        "The meter follows the force with a time constant c.", None, "load_cell time",
        (0.12, 0.6), "s", ("series",), felt=_slow),
    "humming_meter": act(
        "The mains' hum is sampled too seldom: c sin(2 pi 0.113 Hz t + 0.5).", None,
        "load_cell time", (0.06, 1.5), "mN", felt=_humming),
    "tared_under_load": act(
        "The meter is tared as the sheet already presses: c of the run's force at 0 V is taken"
        " off.", None, "load_cell", (0.1, 1.0), "-", felt=_tared),
    "axis_left_behind": act(
        "The cell does not turn with its arm: its axis is turned by c p/30 mm.", None,
        "load_cell", (0.08, 0.75), "rad", felt=_left_behind),
    "weight_of_rolls": act(
        "The rig is not level and the rolls weigh on the cell: c sin(p/R), tared at 0 mm.", None,
        "load_cell position", (0.15, 4.0), "mN", felt=_rolls_weigh),
}  # fmt: skip


# -------------------------------------------------------------------------------------- camera


def _drop(picture: Picture, size: float) -> None:
    x, y = picture.x_m - DROP_M[0], picture.y_m - DROP_M[1]
    part = size * np.exp(-(x**2 + y**2) / DROP_WIDE_M**2)
    picture.shift(part * x, part * y)


def _lit(picture: Picture, size: float) -> None:
    towards = np.cos(LAMP_RAD) * -np.sin(picture.phi_rad) + np.sin(LAMP_RAD) * np.cos(
        picture.phi_rad
    )
    picture.aside(1e-3 * size * towards)


def _zooming(picture: Picture, size: float) -> None:
    larger = size * (picture.at.tau**1.3 - 0.5**1.3)[:, None]
    picture.shift(larger * (picture.x_m - AXIS_M[0]), larger * (picture.y_m - AXIS_M[1]))


def _blunted(picture: Picture, size: float) -> None:
    """Smooth along the sheet; beyond its ends it goes on as its mirror image through them."""
    step = picture.s_m[1] - picture.s_m[0]
    wide = abs(1e-3 * size) / step
    if wide > 1e-3:
        picture.x_m, picture.y_m = (_smoothed(v, wide) for v in (picture.x_m, picture.y_m))


def _smoothed(v: Array, wide: float) -> Array:
    n = min(int(4.0 * wide) + 1, v.shape[1] - 1)
    before, after = 2.0 * v[:, :1] - v[:, n:0:-1], 2.0 * v[:, -1:] - v[:, -2 : -2 - n : -1]
    whole = gaussian_filter1d(np.concatenate([before, v, after], axis=1), wide, axis=1)
    return np.asarray(whole[:, n : n + v.shape[1]])


def _glaring(picture: Picture, size: float) -> None:
    away = (picture.s_m - picture.contact_m[:, None]) / 0.004
    picture.aside(1e-3 * size * np.exp(-(away**2)))


def _sweating(picture: Picture, size: float) -> None:
    at = picture.at
    film = at.sheet_V / 2.0 * -np.expm1(-np.maximum(at.phase_s, 0.0) / 0.2)
    picture.aside(1e-3 * size * film[:, None] * np.tanh(picture.s_m / 0.005))


CAMERA: dict[str, Act] = {
    "drop_on_window": act(
        "A drop on the window before the camera is a lens: points r from (26, 6) mm move by"
        " c r exp(-(r/8 mm)^2).", None, "camera", (0.02, 0.9), "-", seen=_drop),
    "side_lamp": act(
        "The brightest line lies towards the lamp at 0.9 rad: c times the cosine of the normal's"
        " angle to it, along the normal.", None, "camera", (0.06, 1.5), "mm", seen=_lit),
    "zooming_lens": act(
        "The lens warms: pictures grow about (25, 5) mm by c (tau^1.3 - 0.5^1.3).", None,
        "camera time", (0.006, 0.15), "-", seen=_zooming),
    "blunted_curves": act(
        "The curve is smoothed along itself over c (standard deviation of a Gaussian).", None,
        "camera", (1.5, 10.0), "mm", seen=_blunted),
    "glaring_rolls": act(
        "The rolls' glare draws the curve aside: c exp(-((s - contact)/4 mm)^2).", None,
        "camera", (0.06, 2.0), "mm", seen=_glaring),
    "sweating_face": act(
        "Water comes out of the face that swells, and the bright line moves with it: c at 2 V"
        " along the normal, within 0.2 s and 5 mm of the clamp.", None, "camera", (0.05, 1.0),
        "mm", seen=_sweating),
}  # fmt: skip
