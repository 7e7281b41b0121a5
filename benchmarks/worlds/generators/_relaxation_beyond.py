"""What the world `relaxation` hides that no catalogue has, of clamp, sheet and driver."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._relaxation_acting import Act, act
from benchmarks.worlds.generators._relaxation_strip import Array, Lanes, Setting, Strip
from benchmarks.worlds.session.layout import Samples

LONG_M = 0.01  # sheets longer than this are the long one


def _bump(s: Array, middle_m: float, width_m: float) -> Array:
    return np.asarray(np.exp(-(((s - middle_m) / width_m) ** 2)))


def _turning(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.root_rad -= size * np.expm1(-at.tau / 0.3)


def _slipping(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.slipped_m += 1e-3 * size * at.tau


def _curling(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.curl_per_m += size * at.tau**2


def _crusted(setting: Setting, strip: Strip, size: float) -> None:
    part = size * (strip.length_m > LONG_M)
    setting.softness.append(lambda s, _: 1.0 - part * _bump(s, 0.024, 0.004))


def _wired(setting: Setting, _: Strip, size: float) -> None:
    setting.rest.append(lambda s, _: size * np.maximum(1.0 - s / 0.007, 0.0) ** 2)


def _fingered(setting: Setting, _: Strip, size: float) -> None:
    setting.eibm.append(lambda s, _: 1.0 + size * np.cos(2.0 * np.pi * s / 0.018))


def _shunted(setting: Setting, _: Strip, size: float) -> None:
    setting.beyond = 1.0 - size


def _left_over(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.volts_V += size * np.exp(-at.time_s / 4.0)


def _beating(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.gain *= 1.0 + size * np.sin(2.0 * np.pi * at.time_s / 2.9 + 0.8)


def _strained(lanes: Lanes, _at: Samples, strip: Strip, size: float) -> None:
    place = lanes.beta_rad * strip.radius_m
    lanes.gain *= 1.0 - size * ((place / 0.03) ** 2 - 0.3) * (lanes.free == 0.0)


def _swivelling(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.swivel_Nm += 1e-6 * size


def _pillar(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.stretch_m_per_N += size  # 1 mm/mN is 1 m/N


def _misread(lanes: Lanes, _at: Samples, strip: Strip, size: float) -> None:
    place = lanes.beta_rad * strip.radius_m
    lanes.beta_rad += 1e-3 * size * _bump(place, 0.012, 0.004) / strip.radius_m


def _flat_rail(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.radius_m *= 1.0 + size * (1.0 / np.cos(lanes.beta_rad) - 1.0)


NAMELESS: dict[str, Act] = {
    "turning_clamp": act(
        "The clamp's screw creeps: the sheet leaves it at c (1 - exp(-tau/0.3)).", None,
        "rest_curvature time", (0.012, 0.2), "rad", lanes=_turning),
    "slipping_out": act(
        "The sheet slips out of the clamp: it is c tau longer, and what had been clamped is as"
        " curved as its root.", None, "compliance rest_curvature time", (0.2, 2.5), "mm",
        lanes=_slipping),
    "one_side_dries": act(
        "One side dries before the other: k0 + c tau^2 over the session.", None,
        "rest_curvature time", (1.5, 15.0), "1/m", lanes=_curling),
    "salt_crust": act(
        "Salt has dried on the long sheet: compliance 1 - c exp(-((s - 24 mm)/4 mm)^2).", None,
        "compliance", (0.3, 0.95), "-", alters=_crusted),
    "wire_stub": act(
        "A soldered wire bends the root: k0 + c (1 - s/7 mm)^2 up to 7 mm.", None,
        "rest_curvature", (4.0, 60.0), "1/m", alters=_wired),
    "fingers": act(
        "Metal has grown in fingers: EIBM (1 + c cos(2 pi s/18 mm)).", None, "eibm", (0.15, 1.0),
        "-", alters=_fingered),
    "shunting_rolls": act(
        "Wet rolls shunt the electrodes: beyond the contact EIBM is 1 - c of itself.", None,
        "eibm", (0.25, 1.0), "-", alters=_shunted),
    "charge_left": act(
        "A run begins with charge that is left: c exp(-t/4 s) is added to the voltage.", None,
        "eibm time", (0.15, 1.5), "V", lanes=_left_over),
    "beating_supply": act(
        "The supply beats with the mains: EIBM (1 + c sin(2 pi t/2.9 s + 0.8)) in each run.",
        None, "eibm time", (0.04, 0.6), "-", lanes=_beating),
    "strained_electrode": act(
        "Where the sheet is held far out its electrodes are strained and conduct less: EIBM"
        " (1 - c ((p/30 mm)^2 - 0.3)).", None, "eibm time", (0.1, 0.9), "-", lanes=_strained),
    "stiff_swivel": act(
        "The rolls' holder does not swivel freely: a moment of c times gamma against the lean.",
        None, "position load_cell compliance", (4.0, 120.0), "uN m/rad", lanes=_swivelling),
    "springy_pillar": act(
        "The arm stretches along itself, by c times the force along it.", None,
        "load_cell position", (0.2, 3.0), "mm/mN", lanes=_pillar),
    "scratched_scale": act(
        "The stage's scale is bent about 12 mm: p + c exp(-((p - 12 mm)/4 mm)^2).", None,
        "position", (0.4, 4.0), "mm", lanes=_misread),
    "flat_rail": act(
        "The rail is flatter than an arc: R (1 + c (1/cos(p/R) - 1)), its angle right.", None,
        "position", (0.03, 0.25), "-", lanes=_flat_rail),
}  # fmt: skip
