"""What the world `relaxation` hides of the catalogue, of the sheet and the course of time."""

from __future__ import annotations

import numpy as np

from benchmarks.worlds.generators._relaxation_acting import Act, act, lagged, with_frames
from benchmarks.worlds.generators._relaxation_specimen import LAYOUT
from benchmarks.worlds.generators._relaxation_strip import Array, Lanes, Setting, Strip
from benchmarks.worlds.session.layout import Samples

WHOLE_M = 0.05  # over which resistance of the electrodes is counted
NOT_RISE = 1e-4  # a lag is at least so much, relative, beside the voltage's rise


# ------------------------------------------------------------------------------ along the sheet


def _starving(setting: Setting, strip: Strip, size: float) -> None:
    share = strip.length_m / WHOLE_M
    mean = (np.sinh(size) - np.sinh(size * (1.0 - share))) / (size * share)
    setting.eibm.append(lambda s, _: np.cosh(size * (1.0 - s / WHOLE_M)) / mean)


def _poor_cathode(setting: Setting, strip: Strip, size: float) -> None:
    def along(s: Array, lanes: Lanes) -> Array:
        return 1.0 + size * (0.5 - s / strip.length_m) * (lanes.eibm_Nm < 0.0)

    setting.eibm.append(along)


def _reeled(setting: Setting, strip: Strip, size: float) -> None:
    setting.rest.append(lambda s, _: size * (1.2 - 0.4 * s / strip.length_m))


def _soaked(setting: Setting, strip: Strip, size: float) -> None:
    setting.softness.append(lambda s, _: np.exp(-size * (s / strip.length_m - 0.5)))


def _yielding(setting: Setting, _: Strip, size: float) -> None:
    def bending(v: Array) -> tuple[Array, Array]:
        q, w = (v / 12.0) ** 2, (v / 40.0) ** 2
        more = size * q / (1.0 + w)
        return v * (1.0 + more), 1.0 + more * (3.0 - 2.0 * w / (1.0 + w))

    setting.bending = bending


def _curled(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.curl_per_m += size


def _leaning(lanes: Lanes, _at: Samples, _strip: Strip, size: float) -> None:
    lanes.load_y_N_per_m -= size
    lanes.load_x_N_per_m += 0.3 * size


def _light_bar(setting: Setting, _strip: Strip, _size: float) -> None:
    setting.bar_weight = 0.7


def _soft_bar(setting: Setting, _: Strip, size: float) -> None:
    setting.bar_softness = size


SHEET: dict[str, Act] = {
    "starving_electrode": act(
        "Current has to pass the thin electrodes: EIBM as cosh(c (1 - s/50 mm)), its mean kept.",
        "nonuniform_eibm", "eibm", (0.8, 5.0), "-", alters=_starving),
    "poor_cathode": act(
        "One electrode is thinner at the tip: at the negative voltage EIBM (1 + c (1/2 - s/l)).",
        "eibm_asymmetry", "even_moment eibm", (0.25, 2.0), "-", alters=_poor_cathode),
    "curled": act(
        "The sheet has curled since its shape was taken: k0 + c.", "initial_curvature",
        "rest_curvature", (1.0, 12.0), "1/m", lanes=_curled,
        parameters=lambda c: {"curvature_error_per_m": c}),
    "reeled": act(
        "The sheet remembers a reel that it was wound on, tighter inside: k0 + c (1.2 - 0.4 s/l).",
        "initial_curvature", "rest_curvature", (1.0, 12.0), "1/m", alters=_reeled),
    "soaked_root": act(
        "Water gathers at the clamp: stiffness as exp(c (s/l - 1/2)).", "nonuniform_stiffness",
        "compliance", (0.25, 2.0), "-", alters=_soaked),
    "yielding_polymer": act(
        "The polymer gives way when bent far, and then no more: curvature v (1 + c (v/12 per m)^2"
        "/(1 + (v/40 per m)^2)), v the moment over B.", "nonlinear_stiffness", "compliance",
        (0.02, 0.2), "-", alters=_yielding),
    "leaning_bench": act(
        "The bench leans: a weight c per length of the sheet along -y and 0.3 c along x, and 0.7 of"
        " it per length of the bar.", "gravity", "even_moment", (0.003, 0.03), "N/m",
        lanes=_leaning, alters=_light_bar),
    "soft_bar": act(
        "The bar bends: its curvature is c M/B.", "elongation_flexibility", "compliance",
        (0.005, 0.5), "-", alters=_soft_bar, parameters=lambda c: {"relative_compliance": c}),
}  # fmt: skip


# ------------------------------------------------------------------------------------- in time


def _smooth(tau: Array) -> Array:
    return np.asarray(tau**2 * (3.0 - 2.0 * tau))


def _wearing(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.gain *= 1.0 - size * (_smooth(at.tau) - 0.5)


def _dewatered(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    driven = np.maximum(at.time_s - _first_edge_s(at), 0.0)
    lanes.gain *= 1.0 - size * (-np.expm1(-driven / 9.0) - 0.5)


def _first_edge_s(at: Samples) -> Array:
    """Return when the first pulse of each sample's run begins."""
    result = np.zeros(len(at.run))
    for number in np.unique(at.run):
        own = at.run == number
        on = own & (at.pulse == 0.0)
        result[own] = np.min((at.time_s - at.phase_s)[on]) if np.any(on) else 0.0
    return result


def _drying(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.stiffness *= 1.0 + size * (at.tau**0.6 - 0.5**0.6)


PRONY = ((0.3, 0.7), (0.4, 4.0), (0.3, 25.0))  # shares, and times in s


def _relaxing(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    left = sum(g * (np.exp(-at.time_s / t) - np.exp(-5.0 / t)) for g, t in PRONY)
    lanes.stiffness *= 1.0 + size * left


def _charging(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    def behind(constant_s: float) -> Array:
        rise = LAYOUT.rise_s
        if abs(constant_s / rise - 1.0) < NOT_RISE:
            constant_s = rise * (1.0 + NOT_RISE)
        return with_frames(at, lambda one: lagged(one, constant_s, rise))

    lanes.volts_V += 0.65 * behind(size) + 0.35 * behind(3.0 * size) - at.sheet_V


def _ebbing(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    def left(t: Array | float) -> Array:
        return np.asarray(1.0 + size * np.expm1(-np.sqrt(np.maximum(t, 0.0) / 0.25)))

    lanes.gain *= left(at.phase_s) / left(0.5)


def _waking(lanes: Lanes, at: Samples, _: Strip, size: float) -> None:
    lanes.gain *= 1.0 - size * np.exp(-0.9 * np.maximum(at.pulse, 0.0) ** 0.8)


COURSE: dict[str, Act] = {
    "wearing_electrode": act(
        "Platinum comes off, most amid the session: EIBM (1 - c (tau^2 (3 - 2 tau) - 1/2)).",
        "eibm_drift", "time", (0.1, 1.2), "-", lanes=_wearing),
    "dewatered": act(
        "Water is driven off in each run: EIBM (1 - c (1/2 - exp(-t/9 s))), t under voltage.",
        "eibm_drift", "time", (0.1, 1.2), "-", lanes=_dewatered),
    "drying": act(
        "The sheet dries, first fast: stiffness (1 + c (tau^0.6 - 0.5^0.6)).", "stiffness_drift",
        "time", (0.1, 0.9), "-", lanes=_drying),
    "relaxing_chains": act(
        "Chains relax in each run with 0.7, 4 and 25 s: stiffness 1 + c (g(t) - g(5 s)),"
        " g = 0.3 exp(-t/0.7 s) + 0.4 exp(-t/4 s) + 0.3 exp(-t/25 s).", "viscoelastic_creep",
        "time", (0.05, 0.8), "-", lanes=_relaxing),
    "two_lags": act(
        "Charge reaches near sites with c and far ones (0.35 of all) with 3 c, behind the rise.",
        "charging_lag", "time", (0.06, 0.6), "s", ("series",), lanes=_charging),
    "ebbing": act(
        "Water seeps back through the sheet: EIBM as 1 - c (1 - exp(-sqrt(t/0.25 s))) in each"
        " pulse.", "back_relaxation", "time", (0.15, 0.7), "-", ("series",), lanes=_ebbing),
    "waking": act(
        "The first pulses spread the water: pulse k has EIBM (1 - c exp(-0.9 k^0.8)).",
        "first_pulse_transient", "time", (0.2, 0.95), "-", ("series",), lanes=_waking),
}  # fmt: skip
