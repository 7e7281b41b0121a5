"""What `diagnose` found as tables and sentences, in the order of a reader's questions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from labrig.report.parts.table import Table, fixed, interval, number, volts, with_sigma
from model import Parameter
from model.discrepancy.verdict.result import Diagnosis, ErrorRow, Gap, Next, Ranked, Where
from model.effects import catalogue
from model.measurements import FloatArray

VERDICTS = {
    "effect_named": "an effect is named",
    "nothing_missing": "nothing is missing",
    "indistinguishable": "it is one of a class that these data cannot tell apart",
    "unknown_effect": "something is missing that is in no catalogue",
    "cannot_tell": "these data do not allow a verdict",
}
MOST_RANKED = 8
_BASE = {"B_Nm2": "bending stiffness B"}
MOST_PLACES = 8
_SCATTER = {  # name in a diagnosis -> text and factor
    "position": ("contact's place {} mm", 1e3),
    "eibm": ("EIBM {} %", 100.0),
    "stiffness": ("stiffness {} %", 100.0),
    "clamp_tilt": ("clamp's direction {} mrad", 1e3),
    "force_zero": ("load cell's zero {} mN", 1e3),
}


def gap_sentence(found: Diagnosis) -> str:
    """How far the model that was started from is from the data."""
    gap = found.fitted.before
    parts = []
    if np.isfinite(gap.force_rmse_mN):
        parts.append(f"{fixed(gap.force_rmse_mN, 3)} mN in the forces")
    if np.isfinite(gap.curve_rmse_mm):
        parts.append(f"{fixed(gap.curve_rmse_mm, 3)} mm in the neutral curves")
    return (
        f"Before: the simulation misses the measurement by {' and '.join(parts) or 'nothing'}"
        f" (RMS); chi2 per degree of freedom {number(gap.chi2_per_dof)}."
    )


def where_table(found: Diagnosis) -> Table:
    """Return the cells in which simulation and measurement disagree most."""
    rows = tuple(_where(one) for one in found.where[:MOST_PLACES])
    note = "z: measured less simulated, in standard uncertainties with the set-ups' scatter."
    if not rows:
        note = "No place stands out of the noise and the set-ups' scatter."
    columns = ("observable", "sheet", "voltage", "at p, mm", "along s, mm", "z", "reading or time")
    return Table(
        title="Where simulation and measurement disagree", columns=columns, rows=rows, note=note
    )


def _where(one: Where) -> tuple[str, ...]:
    return (
        one.observable,
        one.configuration,
        volts(one.voltage_V),
        "free" if one.position_mm is None else f"{one.position_mm:g}",
        "-" if one.s_mm is None else f"{one.s_mm:.0f}",
        f"{one.z:+.1f}",
        one.detail or "-",
    )


def visibility(found: Diagnosis) -> list[str]:
    """Return what the data could have shown at all: a sentence or two."""
    names = found.signatures.names
    seen = len(names) - len([n for n in names if n in found.invisible])
    said = []
    if names:
        said.append(f"These data would show {seen} of {len(names)} effects at a plausible size.")
    said += [f"They cannot tell {_listed(one)} apart." for one in found.classes]
    return said


def _listed(names: tuple[str, ...]) -> str:
    return " and ".join(names) if len(names) < 3 else f"{', '.join(names[:-1])} and {names[-1]}"


def invisible_table(found: Diagnosis) -> Table | None:
    """Effects that these data cannot show, and what would."""
    if not found.invisible:
        return None
    rows = tuple(found.invisible.items())
    return Table(
        title="Invisible in these data", columns=("effect", "what would show it"), rows=rows
    )


def ranking_table(found: Diagnosis) -> Table:
    """Candidates, best first, with the threshold that they had to pass."""
    shown = list(found.ranking[:MOST_RANKED])
    rows = tuple(
        (
            one.name.replace("unknown:", "unknown, "),
            one.location.replace("_", " "),
            fixed(one.log_bayes, 1),
            number(one.size, 2),
            number(one.detectability, 3),
            one.why_not or _standing(one, found),
        )
        for one in shown
    )
    columns = ("candidate", "acts on", "ln Bayes factor", "size", "visible with, sigma", "remark")
    note = (
        f"To be named: ln of the Bayes factor of {fixed(found.threshold, 1)} or more"
        f" ({found.threshold_from}). Size: the most likely one over a plausible one."
    )
    return Table(title="Candidates", columns=columns, rows=rows, note=note)


def _standing(one: Ranked, found: Diagnosis) -> str:
    if one.name in {effect.name for effect in found.effects}:
        return "named"
    return "explains less" if one.log_bayes >= found.threshold else "below the threshold"


def verdict_sentences(found: Diagnosis) -> list[str]:
    """Return the verdict, and what it means."""
    said = [f"Verdict: {found.sentence}"]
    for one in found.effects:
        meaning = catalogue()[one.name].meaning if one.name in catalogue() else ""
        if meaning:
            said.append(f"{one.name}: {meaning}")
        if one.confusable_with:
            names = _listed((one.name, *one.confusable_with))
            said.append(f"One of {names}: {percent(one.confidence)} that it is one of these.")
    if found.unknown is not None:
        some = found.unknown
        said.append(
            f"It shows most clearly in the {some.configuration} sheet, at {some.peak_mm:.3g}"
            f" {some.at_unit}{_coordinate(some.along)}."
        )
    return said


def _coordinate(along: str) -> str:
    return {"s": " from the clamp", "position": " on the arc"}.get(along, "")


def percent(share: float) -> str:
    """Return a probability, never rounded to certainty."""
    if share > 0.999:
        return "more than 99.9 %"
    return f"{100 * share:.3g} %"


def parameter_table(found: Diagnosis) -> Table | None:
    """Return the effects' parameters, and what else the model has."""
    rows = [row for one in found.effects for row in _effect_rows(one.name, found)]
    rows += [
        (f"{name}: {_BASE.get(key, key)}", *_cells(p), "-", "-")
        for name, parts in found.base.items()
        for key, p in parts.items()
    ]
    if not rows:
        return None
    columns = ("parameter", "value", "90 %", "unit", "probability", "form of its own")
    note = "Form of its own: the share of the effect that is no part of the catalogue's form."
    return Table(
        title="Parameters", columns=columns, rows=tuple(rows), note=note if found.effects else ""
    )


def _effect_rows(name: str, found: Diagnosis) -> Iterator[tuple[str, ...]]:
    one = next(e for e in found.effects if e.name == name)
    own = [(f", {conf}", parts) for conf, parts in one.by_configuration.items()]
    for suffix, parts in [("", one.parameters)] * (not own) + own:
        for key, p in parts.items():
            probability, form = percent(one.confidence), percent(one.form_share)
            yield (f"{name}{suffix}: {key}", *_cells(p), probability, form)


def _cells(parameter: Parameter) -> tuple[str, str, str]:
    factor, unit = readable(parameter.unit)
    p = parameter.scaled(factor, unit)
    return with_sigma(p.value, p.sigma), interval(*p.interval()), unit or "-"


def readable(unit: str) -> tuple[float, str]:
    """Return a factor and the customary unit of an SI quantity."""
    return {
        "N m^2": (1e6, "µN·m²"), "N m": (1e6, "µN·m"), "N": (1e3, "mN"), "Pa": (1e-6, "MPa"),
        "m": (1e3, "mm"),
    }.get(unit, (1.0, unit))  # fmt: skip


def improvement_table(found: Diagnosis) -> Table:
    """Before and after in mN and mm, as the paper's table 6, fitted and left out."""
    rows = [
        *_gap_rows("all, fitted", found.fitted.before, found.fitted.after),
        *_gap_rows("all, left out", found.held_out.before, found.held_out.after),
    ]
    for name in dict.fromkeys(row.configuration for row in found.rows):
        own = [row for row in found.rows if row.configuration == name]
        rows += _gap_rows(f"{name}, fitted", *(_rms_gap(own, when) for when in ("before", "after")))
    note = "Left out: each position predicted by models that were fitted without it."
    if np.isfinite(found.closed):
        note += f" What was found closes {100 * found.closed:.1f} % of the gap there."
    columns = ("root mean squared errors", "before", "after")
    return Table(title="Before and after", columns=columns, rows=tuple(rows), note=note)


def _gap_rows(title: str, before: Gap, after: Gap) -> Iterator[tuple[str, ...]]:
    for text, key, decimals in (
        ("force, mN", "force_rmse_mN", 3), ("neutral curve, mm", "curve_rmse_mm", 3),
        ("force along a run, mN", "drift_rmse_mN", 3),
        ("neutral curve along a run, mm", "drift_rmse_mm", 4),
        ("force within a pulse, mN", "pulse_rmse_mN", 3),
    ):  # fmt: skip
        values = [getattr(gap, key) for gap in (before, after)]
        if np.any(np.isfinite(values)):
            yield (f"{title}: {text}", *(fixed(v, decimals) for v in values))


def _rms_gap(rows: list[ErrorRow], when: str) -> Gap:
    force = np.array([row.force_N - getattr(row, f"{when}_N") for row in rows])
    curves = [getattr(row, f"{when}_off_m") for row in rows]
    means = np.array([np.mean(off**2) for off in curves if len(off)])
    return Gap(
        force_rmse_mN=1e3 * _rms(force),
        curve_rmse_mm=1e3 * float(np.sqrt(np.mean(means))) if len(means) else np.nan,
        chi2_per_dof=1.0,
    )


def _rms(values: FloatArray) -> float:
    good = values[np.isfinite(values)]
    return float(np.sqrt(np.mean(good**2))) if len(good) else float("nan")


def next_sentences(found: Diagnosis) -> list[str]:
    """Return what to measure to be sure."""
    if found.next_measurement is None:
        return []
    said = [next_sentence(found.next_measurement)]
    pair = next((e for e in found.effects if e.confusable_with), None)
    if pair is not None:
        said.append(
            f"Its protocol: labrig next SESSION --between {pair.name} {pair.confusable_with[0]}"
            " -o protocol.toml"
        )
    return said


def next_sentence(one: Next) -> str:
    """Why to measure something next."""
    text = f"Measure next: {one.why.rstrip('.')}."
    if np.isfinite(one.separation) and np.isfinite(one.expected):
        text += (
            f" The candidates are {one.separation:.1f} sigma apart now, and would be"
            f" {one.expected:.1f} after {one.minutes:.0f} min at the rig."
        )
    return text


def scatter_sentence(found: Diagnosis) -> str:
    """By what one set-up differs from the next."""
    parts = [
        text.format(number(factor * found.scatter[name], 2))
        for name, (text, factor) in _SCATTER.items()
        if name in found.scatter
    ]
    return f"From one set-up to the next: {', '.join(parts)}." if parts else ""


def further_sentences(found: Diagnosis) -> list[str]:
    """Outliers and remarks of the procedure."""
    said = [f"Left out as an outlier: {name}." for name in found.outliers]
    return [*said, *(note.rstrip(".") + "." for note in found.notes)]


def limits_sentences(found: Diagnosis) -> list[str]:
    """Return what these data can show, the scatter between set-ups, outliers and remarks."""
    scatter = scatter_sentence(found)
    return [*visibility(found), *([scatter] if scatter else []), *further_sentences(found)]
