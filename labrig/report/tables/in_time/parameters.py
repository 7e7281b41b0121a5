"""The sheet in time: each parameter with its interval, or that these data do not determine it."""

from __future__ import annotations

from collections.abc import Sequence
from math import exp
from typing import Any, NamedTuple

from labrig.analysis.motion.dynamic_fit import DynamicFit
from labrig.report.parts.table import Table, interval, number
from model.dynamics import Viscoelasticity
from model.dynamics.identification import DynamicParameter

_READING_S = 0.5  # after an edge, as the static fit's readings are taken
_RELEASE = "a free step and release, [extras] release = true"
_CURRENT = "the current, [current_sense] in rig.toml"
_CONTACT = "pulses in contact at a position"


class _Shown(NamedTuple):
    text: str
    unit: str
    scale: float
    needs: str  # the measurement that determines it


_SHOWN = {
    "B": _Shown("relaxed bending stiffness B", "µN·m²", 1e6, _CONTACT),
    "mass_per_length": _Shown("mass per length", "g/m", 1e3, _RELEASE),
    "viscous_time": _Shown(
        "viscous time", "ms", 1e3, "a release filmed at 100 frames/s or more: it is of short times"
    ),
    "electrode_resistance": _Shown("electrodes r", "ohm/m", 1.0, _CURRENT),
    "capacitance": _Shown("capacitance c", "F/m", 1.0, _CURRENT),
    "bulk_resistance": _Shown("bulk resistance rho", "ohm·m", 1.0, _CURRENT),
    "leak": _Shown("leak g", "S/m", 1.0, _CURRENT),
    "moment_per_positive_volt": _Shown(
        "moment per volt, U > 0", "µN·m/V", 1e6, "pulses of positive voltage in contact"
    ),
    "moment_per_negative_volt": _Shown(
        "moment per volt, U < 0", "µN·m/V", 1e6, "pulses of negative voltage in contact"
    ),
}


def shown(name: str) -> _Shown:
    """Return how a parameter is named and scaled for people."""
    if name in _SHOWN:
        return _SHOWN[name]
    kind, _, term = name.partition("_")
    if kind == "share":
        return _Shown(f"Prony share {term}", "of B", 1.0, _RELEASE)
    return _Shown(f"Prony time {term}", "s", 1.0, _RELEASE)


def dynamic_table(fit: DynamicFit) -> Table:
    """Return all parameters of a configuration."""
    return Table(
        title=f"{fit.sheet.configuration} in time",
        columns=("parameter", "value", "90 % interval", "unit", "prior's share", "determined by"),
        rows=tuple(_row(one) for one in fit.found.parameters),
        note=stiffness_sentence(fit.found.beam.material),
    )


def _row(one: DynamicParameter) -> tuple[str, ...]:
    text, unit, scale, needs = shown(one.name)
    share = f"{100 * one.prior_share:.0f} %"
    value = number(scale * one.parameter.value, 4)
    if not one.determined:
        assumed = f"{number(scale * one.parameter.value, 2)} assumed"
        why = f"these data do not determine it; {needs} would"
        if one.other_value is not None:
            other = number(scale * one.other_value, 2)
            why = f"these data do not determine it: {other} {unit} explains them as well"
        return text, assumed, "-", unit, share, why
    low, high = one.parameter.interval()
    return text, value, interval(scale * low, scale * high), unit, share, "data"


def stiffness_sentence(material: Viscoelasticity) -> str:
    """Return which static stiffness B is, and which the static fit finds."""
    instant = material.B_Nm2 * (1.0 + sum(material.shares))
    terms = zip(material.shares, material.times_s, strict=True)
    read = material.B_Nm2 * (1.0 + sum(g * exp(-_READING_S / tau) for g, tau in terms))
    return (
        "B is the relaxed stiffness, which a sheet at rest has. Right after an edge it is"
        f" {number(1e6 * instant, 4)} µN·m², and {number(1e6 * read, 4)} µN·m² half a second later:"
        " labrig fit without --dynamic finds one in between."
    )


def noise_sentence(fit: DynamicFit) -> str:
    """Return the noise that the intervals count on."""
    force, current = fit.noise.force, fit.noise.current
    parts = []
    if any(run.plan.force for run in fit.runs):
        parts.append(
            f"force {number(1e3 * force.white, 2)} mN a sample, hum of"
            f" {number(1e3 * force.hum, 2)} mN at {fit.noise.mains_hz:g} Hz, drift of"
            f" {number(1e3 * force.drift_per_sqrt_s, 2)} mN in a second"
        )
    if any(run.plan.current for run in fit.runs):
        parts.append(f"current {number(1e3 * current.white, 2)} mA a sample")
    if any(len(run.plan.frame_s) for run in fit.runs):
        parts.append(f"curves {number(1e3 * fit.noise.curve_m, 2)} mm a point")
    return f"Noise, from what the model leaves: {'; '.join(parts)}."


def dynamic_json(fits: Sequence[DynamicFit]) -> dict[str, Any]:
    """Return the same for --json, in SI."""
    return {"configurations": {fit.sheet.configuration: _json(fit) for fit in fits}}


def _json(fit: DynamicFit) -> dict[str, Any]:
    found, noise = fit.found, fit.noise
    return {
        "B_is": "relaxed",
        "parameters": {
            one.name: one.parameter.to_json()
            | {
                "unit": one.parameter.unit,
                "prior_share": one.prior_share,
                "determined": one.determined,
                "needs": None if one.determined else shown(one.name).needs,
            }
            for one in found.parameters
        },
        "undetermined": list(found.undetermined),
        "chi2_per_value": found.chi2 / found.count,
        "values": found.count,
        "converged": found.converged,
        "noise": {
            "force_N": vars(noise.force), "current_A": vars(noise.current),
            "curve_m": noise.curve_m, "mains_hz": noise.mains_hz,
        },
        "runs": [run.plan.name for run in fit.runs],
        "missing": list(fit.missing),
    }  # fmt: skip
