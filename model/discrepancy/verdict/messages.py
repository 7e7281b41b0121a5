"""Sentences for verdicts and notes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence

from model.discrepancy.thresholds import FEWEST_SETUPS, REPORTED_FORM_SHARE, REPORTED_GAP_RATIO
from model.discrepancy.verdict.result import (
    BeforeAfter,
    ClosedGap,
    Named,
    Promise,
    Unknown,
    Verdict,
)
from model.effects import title
from model.effects.between_sessions import session_of
from model.parameter import Parameter

DIFFERS = {
    "stiffness": "the sheet's stiffness", "eibm": "the EIBM", "position": "the place on the arc",
    "force_zero": "the load cell's zero",
}  # fmt: skip


def sentence(
    verdict: Verdict,
    named: Sequence[Named],
    unknown: Unknown | None,
    left_out: BeforeAfter,
    doubt: str,
    closed: ClosedGap | None = None,
) -> str:
    """Return the verdict in sentences; `doubt` says why the data do not allow one.

    `closed` is the gap that is closed on left-out positions; None: none stands out of the noise.
    """
    if verdict == "cannot_tell":
        return f"These data do not allow a verdict: {doubt}."
    if verdict == "nothing_missing":
        return "Nothing is seen that is not in the model: what is left is noise and scatter."
    if unknown is not None:
        more = f" besides {listed([class_name(n) for n in named])}" if named else ""
        return (
            f"Something is seen{more} that is neither in the model nor in the catalogue: it acts on"
            f" {unknown.location.replace('_', ' ')}, {unknown.depends}, most of all at"
            f" {unknown.peak_mm:.3g} {unknown.at_unit}."
        )
    is_not = "are not" if len(named) > 1 else "is not"
    names = listed([class_name(n) for n in named])
    values = "".join(
        f" {_capital(title(one.name))}: {in_sessions(one)}." for one in named if in_sessions(one)
    )
    said = f"{_capital(names)} {is_not} in the model.{values} {_gap(left_out)}."
    return said if closed is None else f"{said} {closed_sentence(closed)}"


def class_name(one: Named) -> str:
    """Return the name of an effect, or all names of its class with their common probability."""
    if not one.confusable_with:
        return title(one.name)
    names = " or ".join(title(name) for name in (one.name, *one.confusable_with))
    return f"{names} (which these data cannot tell apart; together {percent(one.confidence)})"


def _capital(text: str) -> str:
    return text[:1].upper() + text[1:]


def in_sessions(one: Named) -> str:
    """Return an effect's values in each session with their 90 % intervals; empty: it has none."""
    sheets = one.by_configuration or {"": one.parameters}
    return "; ".join(
        f"{name}{': ' * bool(name)}{told}" for name, own in sheets.items() if (told := _told(own))
    )


def _told(parameters: Mapping[str, Parameter]) -> str:
    own = {session_of(name): p for name, p in parameters.items() if session_of(name)}
    less = " less session 1" if own and 1 not in own else ""
    return ", ".join(f"session {number}{less} {_with_interval(p)}" for number, p in own.items())


def _with_interval(parameter: Parameter) -> str:
    p = parameter if parameter.unit else parameter.scaled(100.0, "%")
    low, high = p.interval()
    return f"{p.value:+.3g} {p.unit} ({low:+.3g} to {high:+.3g})"


def percent(share: float) -> str:
    """Return a probability or share in whole percent, never rounded to all or nothing."""
    if share >= 0.995:
        return "more than 99 %"
    return "less than 1 %" if share < 0.005 else f"{100 * share:.0f} %"


def closed_sentence(one: ClosedGap) -> str:
    """Return the share of a gap that is closed, with the errors that it is made of."""
    digits = 2 if one.unit == "times the noise" else 4 if "along a run" in one.quantity else 3
    before, after, floor = (f"{v:.{digits}f}" for v in (one.before, one.after, one.floor))
    return (
        f"Gap closed above the noise floor: {percent(one.share)} of {one.quantity}"
        f" ({before} → {after} {one.unit}, floor {floor})."
    )


def promise_note(one: Promise) -> str:
    """Return what a proposed measurement promised, and what was found with it."""
    names = listed([title(name) for name in one.proposal.between])
    return (
        f"measured as proposed ({one.proposal.extra.replace('_', ' ')}): {names} were"
        f" {one.proposal.separation:.1f} sigma apart; promised {one.proposal.expected:.1f},"
        f" found {one.found:.1f}"
    )


def listed(names: Sequence[str]) -> str:
    """Return names as English has them: a, b and c."""
    return " and ".join(filter(None, [", ".join(names[:-1]), *names[-1:]]))


def too_few(setups: int) -> str:
    """Return the message that there are too few set-ups."""
    return (
        f"there are {setups} set-ups of the load cell, too few to estimate the scatter between"
        f" set-ups; measure at least {FEWEST_SETUPS} positions, or repeat three of them"
    )


def scattered(name: str, times: float) -> str:
    """Return the message that set-ups differ too much."""
    return (
        f"{DIFFERS[name]} differs from set-up to set-up {times:.0f} times as much as usual;"
        " repeat three positions to see whether that is chance"
    )


def refused(name: str) -> str:
    """Return why an effect that explains something is not named."""
    return (
        f"{title(name)} explains part of the residual, but not on left-out positions, or only in a"
        " form that is not its own"
    )


def _gap(left_out: BeforeAfter) -> str:
    """Return the errors on left-out positions, of the base model and of the final one."""
    before, after = left_out.before, left_out.after
    means = [
        (what, old, new, unit)
        for what, old, new, unit in (
            ("force", before.force_rmse_mN, after.force_rmse_mN, "mN"),
            ("neutral curve", before.curve_rmse_mm, after.curve_rmse_mm, "mm"),
        )
        if math.isfinite(old) and math.isfinite(new)
    ]
    changes = [f"{what} {old:.3f} → {new:.3f} {unit}" for what, old, new, unit in means]
    old, new = (math.sqrt(g.chi2_per_dof) for g in (before, after))
    if old > REPORTED_GAP_RATIO * new and not any(
        one > REPORTED_GAP_RATIO * other for _, one, other, _ in means
    ):
        changes.append(f"{old:.2f} → {new:.2f} times the noise")  # it is in fine shapes
    changes += [
        f"{what} {old:.{digits}f} → {new:.{digits}f} {unit}"
        for what, old, new, unit, digits in (
            ("force along a run", before.drift_rmse_mN, after.drift_rmse_mN, "mN", 3),
            ("neutral curve along a run", before.drift_rmse_mm, after.drift_rmse_mm, "mm", 4),
            ("force within a pulse", before.pulse_rmse_mN, after.pulse_rmse_mN, "mN", 3),
        )
        if old > REPORTED_GAP_RATIO * new
    ]
    if not changes:
        return "No position can be left out, so the prediction error is not known"
    return f"Prediction error on left-out positions (RMS), before → after: {', '.join(changes)}"


def notes(named: Sequence[Named], outliers: Sequence[str], chosen: Sequence[str]) -> Iterator[str]:
    """Yield further notes; `chosen` is the best name with each position left out."""
    if outliers:
        yield f"outliers, left out: {', '.join(outliers)}"
    other = sorted({c for c in chosen if c} - {n.name for n in named})
    if named and other:
        times = sum(c in other for c in chosen)
        yield (
            f"without one of the positions, {', '.join(map(title, other))} is chosen in {times} of"
            f" {len(chosen)} cases"
        )
    for n in named:
        if n.form_share > REPORTED_FORM_SHARE:
            yield (
                f"{title(n.name)}: the form differs from the catalogue's; the kind of effect is"
                " found, not its formula"
            )
