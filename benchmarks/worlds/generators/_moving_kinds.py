"""What the world `moving` can hide, in its own words and formulas."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._moving_sheet import Course, Floats, Strip, Wrong

Change = Callable[[Wrong, float], None]
Parameters = Callable[[float], Mapping[str, float]]


@dataclass(frozen=True)
class Kind:
    """A kind, what it changes, and the catalogue's parameters where it has that form."""

    told: HiddenKind
    change: Change
    parameters: Parameters | None = None


def _kind(
    words: str, known_as: str | None, where: str, sizes: tuple[float, float, str], change: Change,
    parameters: Parameters | None = None, needs: str = "",
) -> Kind:  # fmt: skip
    told = HiddenKind(
        words=words, known_as=known_as, locations=tuple(where.split()), typical=sizes[0],
        largest=sizes[1], unit=sizes[2], needs=tuple(needs.split()),
        own_form=parameters is not None,
    )  # fmt: skip
    return Kind(told, change, parameters)


def _add(name: str, make: Callable[[float], object]) -> Change:
    """Return a change that adds to one of the lists."""
    return lambda wrong, size: getattr(wrong, name).append(make(size))


def _set(name: str, scale: float = 1.0) -> Change:
    return lambda wrong, size: setattr(wrong, name, getattr(wrong, name) + scale * size)


def _spot(strip: Strip, s: Floats, at_m: float, width_m: float) -> Floats:
    here = 1.0 if strip.name == "long" else 0.0
    return np.asarray(here * np.exp(-(((s - at_m) / width_m) ** 2)))


def _zero(more_mN: Callable[[Course, float], float]) -> Change:
    return _add("felt", lambda c: lambda run, force: np.full(len(force), 1e-3 * more_mN(run, c)))


def _taller(size: float) -> Callable[[Course, Floats], Floats]:
    return lambda _, xy: xy * (1.0 + size)


KINDS: dict[str, Kind] = {
    # born of the dynamics
    "resistive_faces": _kind(
        "The electrodes have c ohm/m along the sheet: the layers charge from the clamp on, and the"
        " EIBM spreads from there during each pulse.",
        "nonuniform_eibm", "eibm time", (50.0, 20000.0, "ohm/m"), _set("electrode_ohm_per_m")),
    "sluggish_ions": _kind(
        "Ions pass 1 + c times slower: the layers charge with (1 + c) 40 ms.", "charging_lag",
        "time", (2.0, 20.0, "-"), _set("slower"), needs="series"),
    "slow_gel": _kind(
        "Of the stiffness c relaxes with 4 s (one more Maxwell element beside the springs).",
        "viscoelastic_creep", "time", (0.05, 0.8, "-"), _set("slow_share")),
    "old_image": _kind(
        "Images are c old.", "frame_delay", "camera time", (0.25, 0.45, "s"), _set("late_s"),
        lambda c: {"delay_s": c}),
    # what the catalogue has besides
    "more_curl": _kind(
        "The sheet is c more curved at rest than stated.", "initial_curvature", "rest_curvature",
        (1.0, 12.0, "1/m"), _add("rest", lambda c: lambda _, s: np.full(len(s), c)),
        lambda c: {"curvature_error_per_m": c}),
    "tapered": _kind(
        "B grows along the sheet as 1 + c s/l.", "nonuniform_stiffness", "compliance",
        (0.2, 4.0, "-"),
        _add("spring", lambda c: lambda t, s: (1 + c * s / t.free_m) / (1 + c / 2)),
        lambda c: {"relative_change": c}),
    "stiffer_with_time": _kind(
        "B goes as 1 + c (tau - 1/2) over the session.", "stiffness_drift", "time",
        (0.1, 0.9, "-"),
        _add("stiff", lambda c: lambda r: np.full(len(r.time_s), 1 + c * (r.session - 0.5)))),
    "weaker_with_time": _kind(
        "The EIBM goes as 1 - c (tau - 1/2) over the session.", "eibm_drift", "time",
        (0.1, 1.2, "-"),
        _add("moment", lambda c: lambda r: np.full(len(r.time_s), 1 - c * (r.session - 0.5)))),
    "shallow_start": _kind(
        "Pulse k of a run has 1 - c exp(-k) of the EIBM.", "first_pulse_transient", "time",
        (0.3, 1.0, "-"),
        _add("moment", lambda c: lambda r: 1 - c * np.exp(-np.maximum(r.pulse, 0.0))),
        needs="series"),
    "sheet_weighs": _kind(
        "The rig leans: a weight of c per length acts along -y.", "gravity", "even_moment",
        (0.003, 0.05, "N/m"), _set("weight_N_per_m"), lambda c: {"load_N_per_m": c}),
    "tare": _kind(
        "The load cell reads c too much.", "force_offset", "load_cell", (0.05, 5.0, "mN"),
        _zero(lambda _, c: c), lambda c: {"force_mN": c}),
    "creeping_tare": _kind(
        "The load cell's zero goes as c tau^2 over the session.", "force_drift", "load_cell",
        (0.15, 5.0, "mN"), _zero(lambda run, c: c * run.session**2)),
    "shifted_stage": _kind(
        "The load cell stands c farther than stated.", "position_error", "position",
        (0.3, 5.0, "mm"), _add("place", lambda c: lambda p, _: p + 1e-3 * c),
        lambda c: {"offset_mm": c}),
    "wrong_ruler": _kind(
        "Lengths in the image are 1 + c of the true ones.", "camera_scale", "camera",
        (0.005, 0.2, "-"), _add("seen", _taller)),
    # what no catalogue has
    "dead_patch": _kind(
        "Around 24 mm, 5 mm to either side, c of the EIBM is missing.", None, "eibm",
        (0.3, 1.0, "-"), _add("profile", lambda c: lambda t, s: 1 - c * _spot(t, s, 0.024, 5e-3))),
    "dent": _kind(
        "The long sheet has a dent at 33 mm: c more curved, 3 mm to either side.", None,
        "rest_curvature", (5.0, 60.0, "1/m"),
        _add("rest", lambda c: lambda t, s: c * _spot(t, s, 0.033, 3e-3))),
    "even_layer": _kind(
        "A moment goes with the square of the EIBM: c per m over B at +2 V, to nothing at 15 mm.",
        None, "even_moment eibm", (2.0, 50.0, "1/m"),
        _add("even", lambda c: lambda _, s: c * np.maximum(1 - s / 0.015, 0.0))),
    "flutter": _kind(
        "The EIBM flutters by c sin(7 pi tau) over the session.", None, "time", (0.05, 0.6, "-"),
        _add("moment", lambda c: lambda r: np.full(
            len(r.time_s), 1 + c * np.sin(7 * np.pi * r.session)))),
    "nudged_stage": _kind(
        "After 55 % of the session somebody nudges the stage: it stands c farther.", None,
        "position time", (0.3, 4.0, "mm"),
        _add("place", lambda c: lambda p, tau: p + 1e-3 * c * (tau > 0.55))),
    "third_pulse": _kind(
        "Every third pulse has 1 - c of the EIBM.", None, "time", (0.05, 0.8, "-"),
        _add("moment", lambda c: lambda r: 1 - c * (r.pulse % 3 == 2)), needs="series"),
}  # fmt: skip
