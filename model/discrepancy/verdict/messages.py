"""Sentences for verdicts and notes."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

from model.discrepancy.thresholds import FEWEST_SETUPS, REPORTED_FORM_SHARE, REPORTED_GAP_RATIO
from model.discrepancy.verdict.result import BeforeAfter, Named, Unknown, Verdict

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
) -> str:
    """Return the verdict as a sentence; `doubt` says why the data cannot decide."""
    if verdict == "cannot_tell":
        return f"These data cannot tell what is missing: {doubt}."
    if verdict == "nothing_missing":
        return "Nothing is missing that these data could show: what is left is noise and scatter."
    names = " and ".join(n.name for n in named)
    if unknown is not None:
        more = f", beside {names}," if named else ""
        return (
            f"Something is missing{more} that is none of the known effects: it acts on"
            f" {unknown.location.replace('_', ' ')}, {unknown.depends}, most of all at"
            f" {unknown.peak_mm:.3g} {unknown.at_unit}."
        )
    gap = _gap(left_out)
    if verdict == "indistinguishable":
        also = " or ".join(sorted({c for n in named for c in n.confusable_with}))
        return f"{names} is missing, or {also}, which these data cannot tell apart; {gap}."
    is_it = "are missing: with them" if len(named) > 1 else "is missing: with it"
    return f"{names} {is_it} {gap}."


def too_few(setups: int) -> str:
    """Return the message that there are too few set-ups."""
    return (
        f"there are {setups} set-ups of the load cell, too few to know how much one set-up differs"
        f" from the next; measure at least {FEWEST_SETUPS} positions, or set three of them anew"
    )


def scattered(name: str, times: float) -> str:
    """Return the message that set-ups differ too much."""
    return (
        f"{DIFFERS[name]} differs from set-up to set-up {times:.0f} times as much as is usual;"
        " set three positions anew to see whether that is chance"
    )


def refused(name: str) -> str:
    """Return why an effect that explains something is not named."""
    return (
        f"{name} would explain some of what is left, but not on positions that are left out, or"
        " only in another form than its own"
    )


def _gap(left_out: BeforeAfter) -> str:
    before, after = left_out.before, left_out.after
    means = [
        (old, new, unit)
        for old, new, unit in (
            (before.force_rmse_mN, after.force_rmse_mN, "mN"),
            (before.curve_rmse_mm, after.curve_rmse_mm, "mm"),
        )
        if math.isfinite(old) and math.isfinite(new)
    ]
    changes = [f"from {old:.3f} to {new:.3f} {unit}" for old, new, unit in means]
    old, new = (math.sqrt(g.chi2_per_dof) for g in (before, after))
    if old > REPORTED_GAP_RATIO * new and not any(
        one > REPORTED_GAP_RATIO * other for one, other, _ in means
    ):
        changes.append(f"from {old:.2f} to {new:.2f} times the noise")  # it is in fine shapes
    changes += [
        f"{what} from {old:.{digits}f} to {new:.{digits}f} {unit}"
        for what, old, new, unit, digits in (
            ("along a run", before.drift_rmse_mN, after.drift_rmse_mN, "mN", 3),
            ("along a run", before.drift_rmse_mm, after.drift_rmse_mm, "mm", 4),
            ("within a pulse", before.pulse_rmse_mN, after.pulse_rmse_mN, "mN", 3),
        )
        if old > REPORTED_GAP_RATIO * new
    ]
    if not changes:
        return "there is no position to be left out, so that the gap cannot be told"
    first, last = changes[:-1], changes[-1]
    both = f"{', '.join(first)} and {last}" if first else last
    return f"the gap on left-out positions goes {both}"


def notes(named: Sequence[Named], outliers: Sequence[str], chosen: Sequence[str]) -> Iterator[str]:
    """Yield further notes; `chosen` is the best name with each position left out."""
    if outliers:
        yield f"left out, since nothing else is like it: {', '.join(outliers)}"
    other = sorted({c for c in chosen if c} - {n.name for n in named})
    if named and other:
        times = sum(c in other for c in chosen)
        yield (
            f"with a position left out, {', '.join(other)} was chosen {times} of"
            f" {len(chosen)} times"
        )
    for n in named:
        if n.form_share > REPORTED_FORM_SHARE:
            yield (
                f"{n.name}: its form differs from the catalogue's; take the family, not the formula"
            )
