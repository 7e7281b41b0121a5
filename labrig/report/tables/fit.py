"""How far a fit can be trusted: scatter between set-ups, the paper's own way, each condition."""

from __future__ import annotations

from collections.abc import Collection, Sequence

import numpy as np

from labrig.report.data.models import ALONG, CONSTANT, HELD
from labrig.report.data.selection import place
from labrig.report.parts.table import Table, fixed, number, volts, with_sigma
from model import ConfigurationFit, Fit, Parameter
from model.identification.residuals import ConditionResidual

FEW_VOLTAGES = 6  # of which each is told
# names of the fit's scatter -> what it is, and the factor to the unit named
_SCATTER = {
    "stiffness": ("bending stiffness, %", 100.0),
    "eibm": ("EIBM, %", 100.0),
    "eibm_condition": ("EIBM within a set-up, %", 100.0),
    "eibm_free": ("EIBM of a free shape, %", 100.0),
    "position": ("position on the arc, mm", 1e3),
    "clamp_tilt": ("tilt of the clamp, mrad", 1e3),
    "registration": ("registration of the camera, µm", 1e6),
    "force_zero": ("zero of the load cell, mN", 1e3),
}


def scatter_table(fit: Fit) -> Table:
    """Return the standard deviations between set-ups, estimated from the residuals."""
    rows = []
    for name, value in fit.scatter.items():
        text, scale = _SCATTER.get(name, (name.replace("_", " "), 1.0))
        rows.append((text, number(scale * value, 2)))
    note = "Estimated from the residuals; the uncertainties of table 4 include it."
    if fit.joint.forward.row_index.setups < 2:
        note = (
            "One set-up does not show how set-ups differ: these are values that are usual, as far"
            " as its residuals allow them. The uncertainties of table 4 include them."
        )
    return Table(
        title="Scatter between set-ups",
        columns=("quantity", "standard deviation"),
        rows=tuple(rows),
        note=note,
    )


def one_by_one_table(fit: Fit) -> Table:
    """Return the paper's own way: (7) and (9), a value from each condition and their mean."""
    names = [name for name, one in fit.configurations.items() if one.paper is not None]
    driven = sorted({v for one in fit.configurations.values() for v in one.eibm}, reverse=True)
    rows = [
        ("bending stiffness B by (7), µN·m²", *(_stiffness(fit.configurations[n]) for n in names))
    ]
    rows += [
        (
            f"constant EIBM by (9) at {volts(v)}, µN·m",
            *(_constant(fit.configurations[n], v) for n in names),
        )
        for v in driven
    ]
    note = "± from the scatter between positions alone. Table 4 is one joint fit."
    return Table(
        title="Parameters condition by condition, the paper's way",
        columns=("parameter", *names),
        rows=tuple(rows),
        note=note,
    )


def _stiffness(one: ConfigurationFit) -> str:
    assert one.paper is not None  # noqa: S101 - chosen so
    return with_sigma(1e6 * one.paper.B_Nm2, 1e6 * one.paper.B_sigma_Nm2)


def _constant(one: ConfigurationFit, voltage_V: float) -> str:
    assert one.paper is not None  # noqa: S101 - chosen so
    value = one.paper.eibm_Nm.get(voltage_V, float("nan"))
    return with_sigma(1e6 * value, 1e6 * one.paper.eibm_sigma_Nm.get(voltage_V, float("nan")))


def residual_table(fit: Fit) -> Table:
    """Each condition that was fitted."""
    return against_table("Errors of each condition", fit.residuals)


def against_table(title: str, conditions: Sequence[ConditionResidual]) -> Table:
    """Of each condition the measured force, both simulated ones, and the curves' distances."""
    columns = (
        "condition",
        "F, mN",
        f"{ALONG}: force error, mN",
        f"{CONSTANT}: force error, mN",
        f"{ALONG}: curve error, mm",
        f"{CONSTANT}: curve error, mm",
    )
    rows = [
        (
            f"{row.configuration}, {place(row.position_m)}, {volts(row.voltage_V)}",
            with_sigma(1e3 * row.force_N, 1e3 * row.force_sigma_N),
            *(
                _signed(1e3 * (row.predicted_N[k] - row.force_N), 1e3 * row.force_sigma_N)
                for k in ("varying", "constant")
            ),
            *(fixed(1e3 * row.curve_rmse_m[k], 3) for k in ("varying", "constant")),
        )
        for row in conditions
    ]
    note = f"Force error: simulated − measured. Curve error: RMS distance. {HELD}"
    return Table(title=title, columns=columns, rows=tuple(rows), note=note)


def repeats_table(fit: Fit) -> Table | None:
    """Where simulated repeats were asked for: how far they scatter beside what table 4 states."""
    if not fit.bootstrap_ratio:
        return None
    rows = tuple((name, fixed(ratio, 2)) for name, ratio in fit.bootstrap_ratio.items())
    note = f"1: table 4 is right. From {fit.options.bootstrap} simulated sessions."
    return Table(
        title="Bootstrap check of the uncertainties",
        columns=("parameter", "scatter of simulated repeats / stated uncertainty"),
        rows=rows,
        note=note,
    )


def _signed(value: float, sigma: float) -> str:
    """Return a difference with its sign, to two digits of an uncertainty, or three decimals."""
    if not np.isfinite(value):
        return "-"
    known = np.isfinite(sigma) and sigma > 0.0
    decimals = min(12, max(3, 1 - int(np.floor(np.log10(sigma))))) if known else 3
    return f"{value:+.{decimals}f}"


def _widths(one: ConfigurationFit) -> list[str]:
    """Return how wide the intervals of B and EIBM are; of many voltages the best and the worst."""

    def width(parameter: Parameter) -> float:
        low, high = parameter.interval()
        return 50 * (high - low) / abs(parameter.value)

    moments = [(f"{CONSTANT} at {volts(v)}", p) for v, p in one.eibm.items() if p.value]
    if len(moments) > FEW_VOLTAGES:
        moments.sort(key=lambda moment: width(moment[1]))
        moments = [moments[0], moments[-1]]
    told = [("B", one.B)] if one.B_known else []
    shares = [f"±{_percent(width(parameter))} % ({what})" for what, parameter in (*told, *moments)]
    if len(one.eibm) > FEW_VOLTAGES:
        shares[-2:] = [" to ".join(shares[-2:])]
    return shares


def _percent(share: float) -> str:
    return f"{share:.1f}" if share >= 0.1 else number(share, 1)


def trust(fit: Fit) -> list[str]:
    """Sentences on how far the parameters are fixed."""
    said = []
    for name, one in fit.configurations.items():
        said.append(f"{name}: 90 % intervals reach {', '.join(_widths(one))}.")
        if not _has_curves(fit, name):
            said.append(
                f"{name}: no neutral curves were measured. These numbers rest on the forces alone "
                "and take the EIBM as constant along the sheet; where it is not, B and the EIBM "
                "are off by more than their intervals. Curves (--curves) show it."
            )
    return said + [_sentence(note, fit.configurations) for note in fit.notes]


def _has_curves(fit: Fit, name: str) -> bool:
    return any(
        np.isfinite(row.curve_rmse_m["varying"])
        for row in fit.residuals
        if row.configuration == name
    )


def _sentence(text: str, names: Collection[str]) -> str:
    """Return a note as a sentence; one that begins with a configuration keeps its name."""
    named = any(text.startswith(f"{name}, ") for name in names)
    return (text[:1] if named else text[:1].upper()) + text[1:].rstrip(".") + "."
