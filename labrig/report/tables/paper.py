"""Tables 3 to 6 of the paper from a session, compared with the numbers of the paper."""

from __future__ import annotations

from collections.abc import Callable
from typing import Literal

import numpy as np

from labrig.report.data.models import ALONG, CONSTANT, HELD
from labrig.report.data.paper import PAPER, Quoted
from labrig.report.data.separate_sessions import base
from labrig.report.parts.table import Table, fixed, interval, number, volts, with_sigma
from model import Condition, ConfigurationFit, Fit, Measurements, Parameter, SheetGeometry

_MICRO, _MILLI = 1e6, 1e3
Kind = Literal["varying", "constant"]
_KINDS: tuple[tuple[Kind, str], ...] = (
    ("varying", ALONG),
    ("constant", CONSTANT),
)


def table_3(measurements: Measurements, names: list[str], fit: Fit | None) -> Table:
    """Return the sheet configurations."""
    rows: list[tuple[str, Callable[[SheetGeometry], str], Callable[[Quoted], float] | None]] = [
        ("free length l, mm", lambda g: _mm(g.free_length_m), lambda q: q.free_length_mm),
        ("held in the clamp, mm", lambda g: _mm(g.clamped_length_m), lambda q: q.clamped_length_mm),
        ("width w, mm", lambda g: _mm(g.width_m), lambda q: q.width_mm),
        ("thickness d, mm", lambda g: _mm(g.thickness_m), lambda q: q.thickness_mm),
        ("rigid elongation, mm", lambda g: _mm(g.elongation_m), None),
        ("radius of the arc R, mm", lambda g: _mm(g.arc_radius_m), None),
        ("initial curvature k0, 1/m", lambda g: _rest(g, fit), None),
    ]
    cells, quotes = [], _quotes(names)
    for label, ours, theirs in rows:
        row = [label]
        for name in names:
            row.append(ours(measurements.sheets[name]))
            if name in quotes:
                row.append("-" if theirs is None else number(theirs(quotes[name])))
        cells.append(tuple(row))
    note = "k0: from the clamp to the end of the free length, and its mean."
    return _beside_paper("Table 3. Sheet configurations", names, cells, note)


def _mm(value_m: float) -> str:
    return f"{_MILLI * value_m:.6g}"


def _rest(sheet: SheetGeometry, fit: Fit | None) -> str:
    one = None if fit is None else fit.configurations.get(sheet.configuration)
    if one is not None:
        k0 = one.rest_per_m
    elif sheet.initial_curvature is not None:
        k0 = np.interp(np.linspace(0, sheet.free_length_m, 51), *sheet.initial_curvature)
    else:
        return "-"
    if np.ptp(k0) < 0.005 * np.max(np.abs(k0)):
        return fixed(float(np.mean(k0)), 1)
    return f"{k0[0]:.1f} to {k0[-1]:.1f}, mean {np.mean(k0):.1f}"


def _beside_paper(title: str, names: list[str], rows: list[tuple[str, ...]], note: str) -> Table:
    """Columns for each configuration: this session, and the paper where it has that sheet."""
    columns, quotes = [""], _quotes(names)
    quoted = set()
    for name in names:
        columns.append(name if name != base(name) else f"{name}, this session")
        if name in quotes:
            quoted.add(len(columns))
            columns.append(f"{base(name)}, paper")
    return Table(
        title=title, columns=tuple(columns), rows=tuple(rows), note=note, quoted=frozenset(quoted)
    )


def _quotes(names: list[str]) -> dict[str, Quoted]:
    """Return the paper's sheets, by the column they stand beside: the last one of that sheet."""
    last = {base(name): name for name in names}
    return {name: PAPER[sheet] for sheet, name in last.items() if sheet in PAPER}


def table_4(fit: Fit) -> Table:
    """Return the parameters, each with its standard uncertainty and its 90 % interval."""
    names = list(fit.configurations)
    columns = [""]
    for name in names:
        columns += [name, f"{name}, 90 %"]
    rows = [_parameter_row(text, pick, scale, fit) for text, pick, scale in _parameters(fit)]
    note = (
        "± one standard uncertainty, with the scatter between set-ups. Constant EIBM (9): mean of"
        " the EIBM along the sheet (8) over the loaded length, averaged over the positions. The"
        " paper's text states no numbers of its table 4."
    )
    return Table(title="Table 4. Parameters", columns=tuple(columns), rows=tuple(rows), note=note)


_Pick = Callable[[ConfigurationFit], Parameter | None]


def _parameters(fit: Fit) -> list[tuple[str, _Pick, float]]:
    driven = sorted({v for one in fit.configurations.values() for v in one.eibm}, reverse=True)
    found: list[tuple[str, _Pick, float]] = [
        ("bending stiffness B, µN·m²", lambda one: one.B, _MICRO),
        ("B/w, mN·m", lambda one: one.B_per_width, _MILLI),
        ("equivalent Young modulus E, MPa", lambda one: one.E, 1e-6),
    ]
    if not all(one.B_known for one in fit.configurations.values()):
        found += [(f"constant EIBM/B at {volts(v)}, 1/m", _ratio_at(v), 1.0) for v in driven]
    found += [(f"{CONSTANT} at {volts(v)}, µN·m", _constant_at(v), _MICRO) for v in driven]
    if len({abs(v) for v in driven}) == 1:  # of voltages that differ in size the mean says nothing
        found += [
            ("constant EIBM, mean absolute value, µN·m", lambda one: one.eibm_mean_abs, _MICRO),
            ("mean absolute value over width, mN", lambda one: one.eibm_mean_abs_per_width, _MILLI),
        ]
    found += [(f"{ALONG}, mean over [0, l], {volts(v)}, µN·m", _mean_at(v), _MICRO) for v in driven]
    return found


def _constant_at(voltage_V: float) -> _Pick:
    return lambda one: one.eibm.get(voltage_V)


def _ratio_at(voltage_V: float) -> _Pick:
    return lambda one: one.eibm_over_B.get(voltage_V)


def _mean_at(voltage_V: float) -> _Pick:
    return lambda one: one.eibm_mean.get(voltage_V)


def _parameter_row(text: str, pick: _Pick, scale: float, fit: Fit) -> tuple[str, ...]:
    row = [text]
    for one in fit.configurations.values():
        found = pick(one)
        if found is None:
            row += ["-", "-"]
            continue
        scaled = found.scaled(scale, "")
        if found in (one.B, one.B_per_width, one.E) and not one.B_known:
            row += [f"{number(scaled.value, 3)} (taken)", "-"]
            continue
        row += [with_sigma(scaled.value, scaled.sigma), interval(*scaled.interval())]
    return tuple(row)


def compared_conditions(measurements: Measurements, fit: Fit) -> list[Condition]:
    """Of each configuration the one of table 5: highest voltage, position nearest to 0."""
    found = []
    for name in fit.configurations:
        own = [
            c
            for c in measurements.conditions
            if c.configuration == name and c.curve is not None and c.position_m is not None
            if c.used()
        ]
        if own:
            top = max(c.voltage_V for c in own)
            found.append(
                min((c for c in own if c.voltage_V == top), key=lambda c: abs(c.position_m or 0.0))
            )
    return found


def table_5(fit: Fit, compared: list[Condition]) -> Table:
    """RMSE of the neutral curve of one condition of each configuration."""
    rows, quotes = [], _quotes([c.configuration for c in compared])
    for place, (kind, text) in enumerate(_KINDS):
        row = [text]
        for condition in compared:
            name = condition.configuration
            row.append(_mm_error(_condition_error_m(fit, condition, kind)))
            if name in quotes:
                row.append(fixed(quotes[name].curve_rmse_at_0_mm[place], 2))
        rows.append(tuple(row))
    places = {(c.voltage_V, c.position_m) for c in compared}
    at = ", ".join(f"{volts(v)} and p = {_MILLI * (p or 0):g} mm" for v, p in sorted(places))
    note = (
        f"At {at}; the paper's at +2 V and p = 0. Of the bending part, without its elongation."
        f" {HELD}"
    )
    title = "Table 5. RMSE of one neutral curve, mm"
    return _beside_paper(title, [c.configuration for c in compared], rows, note)


def _condition_error_m(fit: Fit, condition: Condition, kind: Kind) -> float | None:
    for row in fit.residuals:
        same = (row.configuration, row.position_m, row.voltage_V)
        if same == (condition.configuration, condition.position_m, condition.voltage_V):
            return row.curve_rmse_m[kind]
    return None


def _mm_error(value_m: float | None) -> str:
    if value_m is None or not np.isfinite(value_m):
        return "-"
    return fixed(_MILLI * value_m, 2 if value_m >= 1e-4 else 3)


def table_6(fit: Fit) -> Table:
    """RMSE of curves and forces over all conditions."""
    names = list(fit.configurations)
    rows, quotes = [], _quotes(names)
    for place, (kind, text) in enumerate(_KINDS):
        curve, force = [f"{text}: neutral curve, mm"], [f"{text}: force, mN"]
        for name in names:
            errors = fit.configurations[name].rmse[kind]
            curve.append(_mm_error(errors.curve_m))
            force.append(fixed(_MILLI * errors.force_N, 3))
            if name in quotes:
                curve.append(fixed(quotes[name].curve_rmse_mm[place], 2))
                force.append(fixed(quotes[name].force_rmse_mN[place], 3))
        rows += [tuple(curve), tuple(force)]
    note = f"Over all fitted positions and voltages. {HELD}"
    return _beside_paper("Table 6. Root mean squared errors", names, rows, note)
