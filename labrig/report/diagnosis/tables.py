"""What `diagnose` found as tables and sentences, in the order of a reader's questions."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from labrig.files import typed
from labrig.report.diagnosis.limits import visibility
from labrig.report.diagnosis.parameters import percent
from labrig.report.parts.table import Table, fixed, number, volts
from model.discrepancy.data_checks import Suspicion
from model.discrepancy.thresholds import SEPARATION_SIGMA
from model.discrepancy.verdict.messages import (
    answer_title,
    closed_sentence,
    listed,
    nothing_separates,
    shortened,
)
from model.discrepancy.verdict.result import (
    Diagnosis,
    ErrorRow,
    Gap,
    Named,
    Next,
    Ranked,
    Where,
)
from model.effects import catalogue, title
from model.measurements import rms

VERDICTS = {
    "effect_named": "effects that are not in the model",
    "nothing_missing": "nothing seen that is not in the model",
    "indistinguishable": "one of several answers that these data cannot tell apart",
    "unknown_effect": "something that is neither in the model nor in the catalogue",
    "cannot_tell": "no verdict from these data",
}
_PERHAPS_KNOWN = "something that is not in the model, and perhaps not in the catalogue"
BEFORE_AFTER = (  # what the two columns of a comparison are
    "Before: the base model with constant EIBM; B and EIBM refitted, k0 held where sheet.toml"
    " states it. After: the same with the effects found; B, EIBM and effects refitted together."
)
MOST_RANKED = 8
MOST_PLACES = 8
_SCATTER = {  # name in a diagnosis -> text and factor
    "position": ("position {} mm", 1e3),
    "eibm": ("EIBM {} %", 100.0),
    "stiffness": ("bending stiffness {} %", 100.0),
    "clamp_tilt": ("clamp angle {} mrad", 1e3),
    "force_zero": ("load cell's zero {} mN", 1e3),
}


def verdict_title(found: Diagnosis) -> str:
    """Return the verdict in a few words; what is unknown may have a name all the same."""
    of_unknown = found.unknown if found.verdict == "unknown_effect" else None
    named = of_unknown is not None and of_unknown.confusable_with
    return _PERHAPS_KNOWN if named else VERDICTS[found.verdict]


def gap_sentence(found: Diagnosis) -> str:
    """Return how far the base model is from the data."""
    gap = found.fitted.before
    parts = []
    if np.isfinite(gap.force_rmse_mN):
        parts.append(f"{fixed(gap.force_rmse_mN, 3)} mN in the forces")
    if np.isfinite(gap.curve_rmse_mm):
        parts.append(f"{fixed(gap.curve_rmse_mm, 3)} mm in the neutral curves")
    return (
        f"Error of the base model (RMS): {' and '.join(parts) or 'not measured'};"
        f" chi2 per degree of freedom {number(gap.chi2_per_dof)}."
    )


def where_table(found: Diagnosis) -> Table:
    """Return the cells in which simulation and measurement disagree most."""
    rows = tuple(_where(one) for one in found.where[:MOST_PLACES])
    note = (
        "z: measured − simulated by the base model, in standard uncertainties; these include the"
        " scatter between set-ups."
    )
    if not rows:
        note = "No residual exceeds the noise and the scatter between set-ups."
    columns = ("observable", "sheet", "voltage", "p, mm", "s, mm", "z", "reading or time")
    return Table(title="Largest residuals", columns=columns, rows=rows, note=note)


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


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def invisible_table(found: Diagnosis) -> Table | None:
    """Effects that these data cannot show, and what would."""
    if not found.invisible:
        return None
    rows = tuple((title(name), shows) for name, shows in found.invisible.items())
    return Table(
        title="Invisible in these data",
        columns=("effect", "measurement that shows it"),
        rows=rows,
        text=True,
    )


def best_and_named(found: Diagnosis, most: int) -> list[Ranked]:
    """Return so many of the best candidates, and all that are named, best first."""
    named = {effect.name for effect in found.effects}
    return [one for i, one in enumerate(found.ranking) if i < most or one.name in named]


def ranking_table(found: Diagnosis) -> Table:
    """List the best candidates and whatever is named, best first, with the threshold for a name."""
    rows = tuple(
        (
            title(one.name),
            title(one.location),
            fixed(one.log_bayes, 1),
            number(one.size, 2),
            number(one.detectability, 3),
            one.why_not or _standing(one, found),
        )
        for one in best_and_named(found, MOST_RANKED)
    )
    columns = (
        "candidate", "location", "ln Bayes factor", "relative size", "detectability", "remark",
    )  # fmt: skip
    limit = f"ln Bayes factor {fixed(found.threshold, 1)}" if _names(found) else "none"
    note = (
        f"Threshold for a name: {limit} ({found.threshold_from}). The factors are those of each"
        " candidate alone, against the base model; a further name needs the threshold beside the"
        " names before it. Relative size: most likely amplitude over its prior scale."
        " Detectability: size of the effect at its prior scale, in standard uncertainties."
    )
    return Table(title="Candidates", columns=columns, rows=rows, note=note)


def _names(found: Diagnosis) -> bool:
    """Whether anything may be named at all; with too few set-ups nothing is."""
    return bool(np.isfinite(found.threshold))


def _standing(one: Ranked, found: Diagnosis) -> str:
    if not _names(found):
        return "not judged"
    if one.name in {effect.name for effect in found.effects}:
        return "named"
    if found.unknown is not None and one.name == f"unknown:{found.unknown.location}":
        return "reported"
    if one.log_bayes < found.threshold:
        return "below the threshold"
    failed = [check for check in found.checks if one.name in check.effects and not check.passed]
    return "failed a check" if failed else "explains less"


def verdict_sentences(found: Diagnosis) -> list[str]:
    """Return the verdict, and what it means."""
    said = [f"Verdict: {found.sentence}"]
    for one in found.effects:
        meaning = catalogue()[one.name].meaning if one.name in catalogue() else ""
        if meaning:
            said.append(f"{_capital(title(one.name))}: {meaning}")
        if one.confusable_with or one.or_else:
            said.append(_class_sentence(one))
    if found.unknown is not None:
        some = found.unknown
        said.append(
            f"It is seen most clearly in the {some.configuration} sheet, at {some.peak_mm:.3g}"
            f" {some.at_unit}{_coordinate(some.along)}."
        )
    return said


def _class_sentence(one: Named) -> str:
    """Return the members of a class, their probability together, and that of each."""
    names = [title(name) for name in (one.name, *one.confusable_with)]
    members = listed([*shortened(names), *map(answer_title, one.or_else)], "or")
    each = ", ".join(f"{answer_title(name)} {percent(p)}" for name, p in one.probabilities.items())
    known = "this class" if len(names) > 1 else names[0]
    text = f"One of {members}: {percent(one.confidence)} probability of {known}"
    return f"{text} ({each})." if each else f"{text}."


def _coordinate(along: str) -> str:
    return {"s": " from the clamp", "position": " on the arc"}.get(along, "")


def improvement_table(found: Diagnosis) -> Table:
    """Before and after in mN and mm, as the paper's table 6, fitted and left out."""
    rows = [*_gap_rows("all, fitted", found.fitted.before, found.fitted.after)]
    note = BEFORE_AFTER
    if len({row.position_m for row in found.rows if row.position_m is not None}) > 1:
        rows += _gap_rows("all, left out", found.held_out.before, found.held_out.after)
        note += " Left out: each position predicted by fits without it."
    sheets = list(dict.fromkeys(row.configuration for row in found.rows))
    for name in sheets if len(sheets) > 1 else ():
        own = [row for row in found.rows if row.configuration == name]
        rows += _gap_rows(f"{name}, fitted", *(_rms_gap(own, when) for when in ("before", "after")))
    if found.closed_gap is not None:
        note += f" {closed_sentence(found.closed_gap)}"
    columns = ("root mean squared errors", "before", "after")
    return Table(title="Errors before and after", columns=columns, rows=tuple(rows), note=note)


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
        force_rmse_mN=1e3 * rms(force),
        curve_rmse_mm=1e3 * float(np.sqrt(np.mean(means))) if len(means) else np.nan,
        chi2_per_dof=1.0,
    )


def next_sentences(found: Diagnosis, session: str | None = None) -> list[str]:
    """Return what to measure next, and how to get its protocol from the session that keeps this.

    `session`: its file; None: of tables, or of several.
    """
    pair = next((e for e in found.effects if e.confusable_with), None)
    if found.next_measurement is None:
        both = () if pair is None else (pair.name, pair.confusable_with[0])
        return [nothing_separates(both)] if both else []
    said = [next_sentence(found.next_measurement)]
    if session is not None:
        said.append(f"Its protocol: labrig next {typed(session)} -o protocol.toml")
    elif pair is not None:
        between = found.next_measurement.between or (pair.name, pair.confusable_with[0])
        said.append(
            "Its protocol: labrig next with the same files and "
            f"--between {' '.join(between[:2])} -o protocol.toml"
        )
    return said


def next_sentence(one: Next) -> str:
    """Why to measure something next."""
    text = f"Measure next: {one.why.rstrip('.')}."
    if np.isfinite(one.separation) and np.isfinite(one.expected):
        text += (
            f" Separation of the candidates: {one.separation:.1f} → {one.expected:.1f} sigma"
            f" (now → expected), after {one.minutes:.0f} min at the rig, mounting"
            " not counted."
        )
        if one.expected < SEPARATION_SIGMA:
            text += f" That is unlikely to tell them apart: it takes {SEPARATION_SIGMA:.0f} sigma."
    return text


def scatter_sentence(found: Diagnosis) -> str:
    """Return the scatter between set-ups."""
    parts = [
        text.format(number(factor * found.scatter[name], 2))
        for name, (text, factor) in _SCATTER.items()
        if name in found.scatter
    ]
    return f"Scatter between set-ups (standard deviation): {', '.join(parts)}." if parts else ""


def data_check_sentences(found: Diagnosis) -> list[str]:
    """Return what is suspicious about the data as they are stated, where the search went on."""
    return [suspicion_sentence(one) for one in found.data_checks] if found.searched else []


def suspicion_sentence(one: Suspicion) -> str:
    """Return a suspicion as a sentence of its own."""
    return f"Check the data: {one.sentence.rstrip('.')}."


def further_sentences(found: Diagnosis) -> list[str]:
    """Outliers and remarks of the procedure."""
    said = [*data_check_sentences(found)]
    return [*said, *(note.rstrip(".") + "." for note in found.notes)]


def limits_sentences(found: Diagnosis) -> list[str]:
    """Return what these data can show, the scatter between set-ups, outliers and remarks."""
    scatter = scatter_sentence(found)
    return [*visibility(found), *([scatter] if scatter else []), *further_sentences(found)]
