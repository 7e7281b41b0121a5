"""The paper's observations about its sheets, and the same of this session's."""

from __future__ import annotations

import numpy as np

from labrig.report.data.paper import PAPER
from labrig.report.data.selection import (
    configurations,
    force_at_N,
    force_line,
    rest_position_m,
    voltages,
)
from labrig.report.parts.table import Table, fixed, number, volts
from model import ConfigurationFit, Fit, Measurements


def observations(measurements: Measurements, fit: Fit | None) -> Table:
    """One row for each observation that the data at hand allow."""
    rows: list[tuple[str, str, str]] = []
    for name in configurations(measurements):
        rows += _rest(measurements, name)
    rows += _initial_forces(measurements)
    if fit is not None:
        rows += _between_sheets(fit)
        for one in fit.configurations.values():
            rows += _eibm(one)
    for name in configurations(measurements):
        rows += _lines(measurements, name)
    columns = ("observation", "this session", "paper")
    note = "Straightness: RMS distance of F(p) from its line, over the range of F."
    return Table(
        title="Observations", columns=columns, rows=tuple(rows), note=note, quoted=frozenset({2})
    )


def _rest(measurements: Measurements, name: str) -> list[tuple[str, str, str]]:
    found = rest_position_m(measurements, name)
    theirs = number(PAPER[name].rest_position_mm) if name in PAPER else "-"
    ours = "not within the positions" if found is None else fixed(1e3 * found, 1)
    return [(f"rest position of the undriven {name} sheet, mm", ours, theirs)]


def _initial_forces(measurements: Measurements) -> list[tuple[str, str, str]]:
    """Compare the forces under voltage where the undriven sheet rests."""
    rows, largest = [], {}
    for name in configurations(measurements):
        at_m = rest_position_m(measurements, name)
        driven = [v for v in voltages(measurements, name) if v]
        if at_m is None:
            continue
        found = {v: force_at_N(measurements, name, v, at_m) for v in driven}
        forces = {v: force for v, force in found.items() if force is not None}
        if not forces:
            continue
        largest[name] = max(map(abs, forces.values()))
        at = ", ".join(volts(v) for v in forces)
        cells = ", ".join(fixed(1e3 * force, 2) for force in forces.values())
        rows.append((f"force at the rest position, {name} sheet, {at}, mN", cells, "-"))
    if {"long", "short"} <= set(largest):
        ratio = largest["short"] / largest["long"]
        what = "largest force at the rest position, short sheet over long one"
        rows.append((what, fixed(ratio, 2), "above 1"))
    return rows


def _between_sheets(fit: Fit) -> list[tuple[str, str, str]]:
    if not {"long", "short"} <= set(fit.configurations):
        return []
    long, short = fit.configurations["long"], fit.configurations["short"]
    stiffer = long.B.value / short.B.value
    weaker = long.eibm_mean_abs.value / short.eibm_mean_abs.value
    return [
        ("bending stiffness, long sheet over short one", fixed(stiffer, 2), "above 1"),
        (
            "mean |constant EIBM|, long sheet over short one",
            fixed(weaker, 2),
            "below 1",
        ),
    ]


def _eibm(one: ConfigurationFit) -> list[tuple[str, str, str]]:
    rows = []
    if one.eibm_along_Nm:
        top = max(one.eibm_along_Nm)
        Me = one.eibm_along_Nm[top][0]
        if np.isfinite(Me).all() and Me[0] != 0:
            what = f"EIBM along the {one.configuration} sheet, end over clamp"
            theirs = "towards 0" if one.configuration == "long" else "-"
            rows.append((what, fixed(float(Me[-1] / Me[0]), 2), theirs))
    if len(one.eibm) == 2 and min(one.eibm) < 0 < max(one.eibm):
        low, high = sorted(one.eibm)
        ratio = abs(one.eibm[low].value / one.eibm[high].value)
        what = f"|constant EIBM| at {volts(low)} over {volts(high)}, {one.configuration} sheet"
        rows.append((what, fixed(ratio, 2), "not 1"))
    return rows


def _lines(measurements: Measurements, name: str) -> list[tuple[str, str, str]]:
    found = {v: force_line(measurements, name, v) for v in voltages(measurements, name)}
    lines = {v: line for v, line in found.items() if line is not None}
    if not lines:
        return []
    share = ", ".join(f"{100 * line.deviation_share:.1f} %" for line in lines.values())
    slope = ", ".join(fixed(line.slope_N_per_m, 3) for line in lines.values())
    at = ", ".join(volts(v) for v in lines)
    theirs = {"long": "not straight", "short": "straight"}.get(name, "-")
    return [
        (f"straightness of F(p), {name} sheet, {at}", share, theirs),
        (f"slope of F(p), {name} sheet, mN/mm", slope, "-"),
    ]
