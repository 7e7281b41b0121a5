"""Forms of the catalogue's effects of the sheet itself, along it and in time."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.hidden_effects.forms import Change, Form, set_to
from benchmarks.hidden_effects.recipe import (
    BOTH,
    EIBM_LONG_PER_M,
    EIBM_SHORT_PER_M,
    LONG,
    SHORT,
    Recipe,
)
from sim_hardware.world.along import bump, fall, stiffness_rise

LENGTH_MM = 50.0
RUN_DRIVEN_S = 13.0  # time at 2 V in a run
SAMPLE_S = 0.5
SLOW_SHARE = 0.4
MIDDLES = (np.arange(400) + 0.5) / 400

# -------------------------------------------------------------------------------- along the sheet

# Length for a fall, from the clamp to 50 mm, by this share.
_DECAY_MM: dict[str, Callable[[float], float]] = {
    "exp": lambda share: -LENGTH_MM / math.log(1 - share),
    "cosh": lambda share: LENGTH_MM / math.acosh(1 / (1 - share)),
    "line": lambda share: LENGTH_MM / share,
    "root": lambda share: LENGTH_MM / ((1 - share) ** -2 - 1),
}


def _falling_eibm(form: str) -> Change:
    def change(recipe: Recipe, share: float) -> None:
        decay_mm = _DECAY_MM[form](share)
        recipe.set("eibm.form", form)
        recipe.set("eibm.decay_mm", decay_mm)
        for name in BOTH:  # its mean over the free length stays
            length = recipe.settings().configurations[name].free_length_m
            mean = np.mean(fall(MIDDLES * length, form, decay_mm / 1e3, length))  # type: ignore[arg-type]
            recipe.weigh_moment(name, 1 / float(mean))

    return change


def _changing_stiffness(form: str) -> Change:
    def change(recipe: Recipe, relative: float) -> None:
        recipe.set("configurations.NAME.stiffness_change", relative)
        recipe.set("configurations.NAME.stiffness_form", form)
        for name in BOTH:  # the mean compliance stays
            rise = stiffness_rise(MIDDLES, form, 1.0)  # type: ignore[arg-type]
            recipe.weigh_stiffness(name, float(np.mean(1 / (1 + relative * rise))))

    return change


def _stiffening(knee_per_m: float) -> Change:
    def change(recipe: Recipe, at_10_per_m: float) -> None:
        recipe.set("configurations.NAME.stiffening_knee_per_m", knee_per_m)
        recipe.set("configurations.NAME.stiffening", at_10_per_m * (100 + knee_per_m**2) / 100)

    return change


def _more_curvature(recipe: Recipe, per_m: float) -> None:
    """The same everywhere along the long sheet."""
    recipe.bump("rest_curvature", LENGTH_MM / 2, 1e6, per_m, LONG)


def _hump(recipe: Recipe, per_m: float) -> None:
    """Most in the middle of the long sheet."""
    recipe.bump("rest_curvature", LENGTH_MM / 2, LENGTH_MM / 4, per_m, LONG)


def _joint(recipe: Recipe, give: float) -> None:
    """A joint that gives way like an elongation of which every part does."""
    sheet, radius_mm = recipe.world["configurations"]["short"], recipe.world["arc"]["radius_mm"]
    lever_mm = radius_mm - sheet["free_length_mm"]
    recipe.set("configurations.short.elongation_joint_mm", give * lever_mm / 3)


def _even_near_clamp(recipe: Recipe, less: float) -> None:
    """A part of the moment does not care for the sign of the voltage, most of all at the clamp."""
    width_mm = 30.0
    for name, per_m in ((LONG, EIBM_LONG_PER_M), (SHORT, EIBM_SHORT_PER_M)):
        length = recipe.settings().configurations[name].free_length_m
        mean = float(np.mean(bump(MIDDLES * length, 0.0, width_mm / 1e3)))
        recipe.bump("even_moment", 0.0, width_mm, per_m * less / (2 - less) / mean, name)


# ---------------------------------------------------------------------------------------- in time

_MOST = {"stiffening_per_min": 1.2, "weakening_per_min": 0.8, "tiring_per_min": 0.8}


def _drying(key: str, form: str) -> Change:
    """`key` such that the change over one run is the size."""

    def change(recipe: Recipe, relative: float) -> None:
        recipe.set("water.drying_form", form)
        tau = recipe.world["water"]["drying_s"]
        counted = {
            "line": RUN_DRIVEN_S,
            "root": math.sqrt(60 * RUN_DRIVEN_S),
            "exp": 60 * math.expm1(-RUN_DRIVEN_S / tau) / math.expm1(-60 / tau),
        }[form]
        recipe.set(f"water.{key}", _rate(key, relative, counted))

    return change


def _tiring(recipe: Recipe, relative: float) -> None:
    runs = 14
    recipe.set("water.tiring_per_min", _rate("tiring_per_min", relative, runs * RUN_DRIVEN_S))


def _rate(key: str, relative: float, counted_s: float) -> float:
    return -60 * _MOST[key] / counted_s * math.log(1 - relative / _MOST[key])


def _creep(spread: float) -> Change:
    def change(recipe: Recipe, share: float) -> None:
        recipe.set("creep.share", share)
        recipe.set("creep.time_s", 8.0)
        recipe.set("creep.spread", spread)

    return change


def _two_rates(recipe: Recipe, time_s: float) -> None:
    """A part of the moment comes at once, the rest slowly."""
    recipe.set("eibm.relaxation", -SLOW_SHARE / (1 - SLOW_SHARE))
    recipe.set("eibm.relaxation_s", time_s)
    for name in BOTH:
        recipe.weigh_moment(name, 1 - SLOW_SHARE)


def _relaxing(time_s: float, spread: float) -> Change:
    """The size is what a sheet that was at rest has lost at the sampling point."""

    def change(recipe: Recipe, loss: float) -> None:
        times = time_s * np.array([1 / spread, 1.0, spread])
        recipe.set("eibm.relaxation", loss / float(np.mean(-np.expm1(-SAMPLE_S / times))))
        recipe.set("eibm.relaxation_s", time_s)
        recipe.set("eibm.relaxation_spread", spread)

    return change


def _first_pulses(order: int, spread_s: float) -> Change:
    """The size is what the very first pulse lacks at its sampling point."""

    def change(recipe: Recipe, deficit: float) -> None:
        past = SAMPLE_S / spread_s
        left = math.exp(-past) if order == 1 else 1 / (1 + past)
        recipe.set("water.first_pulse_deficit", deficit / left)
        recipe.set("water.spread_order", order)
        recipe.set("water.spread_s", spread_s)

    return change


# -------------------------------------------------------------------------------------- the forms

_EIBM = Form(
    "nonuniform_eibm", "exp", "share by which it falls from the clamp to 50 mm", 0.5, 0.95,
    _falling_eibm("exp"), "eibm", place_mm=(0.0, 50.0),
    parameters=lambda f: {"decay_length_mm": _DECAY_MM["exp"](f), "end_to_root_ratio": 1 - f},
)  # fmt: skip
_STIFFNESS = Form(
    "nonuniform_stiffness", "sine", "relative change of B from the clamp to the end", 0.4, 3.0,
    _changing_stiffness("sine"), "compliance", place_mm=(0.0, 50.0),
    parameters=lambda c: {"relative_change": c},
)  # fmt: skip
_NONLINEAR = Form(
    "nonlinear_stiffness", "wide", "relative change of B at 10 per m", 0.008, 0.05,
    _stiffening(60.0), "compliance",
    parameters=lambda c: {"relative_change_at_10_per_m": c},
)  # fmt: skip
_CURVATURE = Form(
    "initial_curvature", "offset", "true minus stated k0, per m", 1.0, 20.0,
    _more_curvature, "rest_curvature", place_mm=(0.0, 50.0),
    parameters=lambda e: {"curvature_error_per_m": e},
)  # fmt: skip
_B_DRIFT = Form(
    "stiffness_drift", "line", "relative change of B in a run", 0.1, 0.8,
    _drying("stiffening_per_min", "line"), "time",
    parameters=lambda c: {"relative_change": c},
)  # fmt: skip
_EIBM_DRIFT = Form(
    "eibm_drift", "line", "relative loss of EIBM in a run", 0.2, 0.7,
    _drying("weakening_per_min", "line"), "time",
    parameters=lambda c: {"relative_change": -c},
)  # fmt: skip

FORMS: tuple[Form, ...] = (
    _EIBM,
    *(
        replace(_EIBM, form=f, change=_falling_eibm(f),
                parameters=lambda f: {"end_to_root_ratio": 1 - f})
        for f in ("cosh", "line", "root")
    ),
    _CURVATURE,
    replace(_CURVATURE, form="hump", change=_hump, size=2.0, parameters=lambda _: {}),
    Form("eibm_asymmetry", "ratio", "1 - |EIBM(-)/EIBM(+)|", 0.15, 0.9,
         lambda r, less: r.set("eibm.negative_ratio", 1 - less), "even_moment", symmetric=True,
         parameters=lambda less: {"ratio": 1 - less}),
    Form("eibm_asymmetry", "near_clamp", "1 - |EIBM(-)/EIBM(+)|", 0.15, 0.9,
         _even_near_clamp, "even_moment", symmetric=True,
         parameters=lambda less: {"ratio": 1 - less}),
    _STIFFNESS,
    *(replace(_STIFFNESS, form=f, change=_changing_stiffness(f)) for f in ("line", "step")),
    _NONLINEAR,
    replace(_NONLINEAR, form="early", change=_stiffening(8.0), size=0.15, largest=1.0),
    _B_DRIFT,
    *(replace(_B_DRIFT, form=f, change=_drying("stiffening_per_min", f)) for f in ("root", "exp")),
    _EIBM_DRIFT,
    *(replace(_EIBM_DRIFT, form=f, change=_drying("weakening_per_min", f))
      for f in ("root", "exp")),
    replace(_EIBM_DRIFT, form="for_good", change=_tiring,
            unit="relative loss of EIBM in a session"),
    Form("viscoelastic_creep", "single", "share of B lost under a strain that stays", 0.15, 0.5,
         _creep(1.0), "time"),
    Form("viscoelastic_creep", "spread", "share of B lost under a strain that stays", 0.15, 0.5,
         _creep(5.0), "time"),
    Form("charging_lag", "first_order", "time constant in s", 0.2, 1.5,
         set_to("eibm.build_up_s"), "time", parameters=lambda t: {"time_constant_s": t}),
    Form("charging_lag", "two_rates", "time constant in s of the slow part", 0.4, 3.0,
         _two_rates, "time"),
    Form("back_relaxation", "single", "share of Me lost at the sampling point", 0.15, 0.5,
         _relaxing(0.3, 1.0), "time",
         parameters=lambda f: {"relative_loss_at_sample": f, "time_constant_s": 0.3}),
    Form("back_relaxation", "spread", "share of Me lost at the sampling point", 0.15, 0.5,
         _relaxing(0.3, 4.0), "time", parameters=lambda f: {"relative_loss_at_sample": f}),
    Form("first_pulse_transient", "geometric", "share that the first pulse lacks", 0.3, 0.7,
         _first_pulses(1, 1.5), "time", parameters=lambda a: {"relative_deficit": a}),
    Form("first_pulse_transient", "hyperbolic", "share that the first pulse lacks", 0.3, 0.5,
         _first_pulses(2, 0.5), "time", parameters=lambda a: {"relative_deficit": a}),
    Form("elongation_flexibility", "uniform", "B over the elongation's stiffness", 0.03, 0.5,
         set_to("configurations.short.elongation_give"), "compliance",
         parameters=lambda c: {"relative_compliance": c}),
    Form("elongation_flexibility", "joint", "B over the elongation's stiffness", 0.03, 0.5,
         _joint, "compliance", parameters=lambda c: {"relative_compliance": c}),
    Form("gravity", "weight", "N per m, along -y", 0.01, 0.06,
         set_to("gravity_N_per_m"), "even_moment", parameters=lambda q: {"load_N_per_m": q}),
)  # fmt: skip
