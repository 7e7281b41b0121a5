"""Check units, signs, order, lengths and outliers of the data before the search.

What is stated of a measurement is compared with what the data say. A configuration that the base
model fits is left at that. Where it does not fit, it is fitted again with one datum changed, for
each change that a data check proposes; the best one is told if it leaves next to nothing of the
misfit. A base fit that fails and that no change mends is told, too: no effect explains it. What is
wrong is said by the data checks that need no fit for it, if any of them knows.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.data_checks.catalogue import data_checks
from model.discrepancy.data_checks.changed_data import (
    EXPLAINED_MISFIT,
    Compared,
    Trial,
    compared,
    of_one,
)
from model.discrepancy.data_checks.content_digest import content_digest
from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion
from model.discrepancy.data_checks.few_voltages import with_few_voltages
from model.discrepancy.data_checks.kinds._data import quoted
from model.discrepancy.data_checks.quick_fit import (
    QuickFit,
    Tolerances,
    bare,
    fit_with,
    quick_fit,
)
from model.discrepancy.thresholds import (
    FAILED_CURVE_SHARE,
    FAILED_FORCE_SHARE,
    LEFT_BY_CHANGED_DATUM,
    SUSPICIOUS_MISFIT,
)
from model.identification.data.outlier_readings import without_outliers
from model.identification.data.swinging_shapes import without_swinging
from model.measurements import Measurements, in_digits

SAME_SIGMA, SAME_SHARE = 5.0, 0.02  # within which two configurations ask for the same value
# beyond which one of them contradicts a value that the others ask for
APART_SIGMA, APART_SHARE = 3.0, 0.01
OTHER_SIGN = (-1.0,)  # the values of a change that exchanges a sign
KEPT = 4  # data of which the suspicions are kept in memory


@dataclass(frozen=True, kw_only=True)
class CheckedData:
    """Measurements with what is suspicious about them."""

    # without readings far from the others, what still swings, and more voltages than are needed
    measurements: Measurements
    suspicions: tuple[Suspicion, ...] = ()
    notes: tuple[str, ...] = ()  # what was left out

    @property
    def stops(self) -> tuple[Suspicion, ...]:
        """Those with which no search makes sense."""
        return tuple(one for one in self.suspicions if one.severity == "stop")

    @property
    def sentences(self) -> tuple[str, ...]:
        """Return a sentence for each suspicion, and for what was left out."""
        return (*(one.sentence for one in self.suspicions), *self.notes)


@dataclass(frozen=True, kw_only=True)
class ProposedChange:
    """A change that mends some configurations, with the suspicion it raises."""

    change: Change
    value: float
    sigma: float
    suspicion: Suspicion


def check_data(measurements: Measurements) -> CheckedData:
    """Return measurements without wild readings, and what is suspicious; raise nothing."""
    cleaned = without_outliers(measurements)
    data = cleaned.measurements
    checks = tuple(data_checks().values())
    found = [one for check in checks for one in check.suspicions(data)]
    stops = [one for one in found if one.severity == "stop"]
    # what else seems wrong follows from these, as a rule
    at_rest, swinging = without_swinging(data)
    few, left_out = with_few_voltages(at_rest)
    found = stops or [*found, *_once(few, checks)]
    return CheckedData(
        measurements=few,
        suspicions=tuple(found),
        notes=(*cleaned.sentences(), *swinging, *left_out),
    )


# What was found of the last data, in the order of their use; with the checks, for their identity.
_KEPT = dict[bytes, tuple[tuple[Suspicion, ...], Sequence[DataCheck]]]()


def _once(data: Measurements, checks: Sequence[DataCheck]) -> tuple[Suspicion, ...]:
    """Fit the same data once: a fit, a diagnosis and a report in one process ask for the same."""
    numbers = replace(data, source="", checksum="")  # a file also changes when results are kept
    key = content_digest(numbers, [id(check) for check in checks])
    kept = _KEPT.pop(key, None)
    if kept is None:
        kept = tuple(_of_the_fit(data, checks)), checks
    _KEPT[key] = kept
    for old in list(_KEPT)[:-KEPT]:
        _KEPT.pop(old, None)
    return kept[0]


def _of_the_fit(data: Measurements, checks: Sequence[DataCheck]) -> Iterator[Suspicion]:
    few = bare(data)
    tolerances = Tolerances.of(few)
    stiffness, mended, left = dict[str, float](), list[Compared](), list[Compared]()
    as_stated = dict[str, tuple[Measurements, QuickFit | None]]()
    for name in data.sheets:
        own = of_one(few, name)
        if not any(c.readings and c.position_m is not None for c in own.conditions):
            continue
        stated = quick_fit(own, tolerances)
        as_stated[name] = own, stated
        if stated is not None and stated.misfit < SUSPICIOUS_MISFIT:
            stiffness[name] = float(np.exp(stated.theta[stated.bases.parts[0].stiffness]))
            continue
        found = compared(name, own, stated, tolerances, checks)
        explained = _changes_along(found, own, tolerances)
        if _mended(found) and not explained:
            mended.append(found)
        elif (along := _changed_along(found, own, tolerances)) is not None:
            mended.append(along)
        elif not explained:
            left.append(found)
    for one in _changed(mended):
        yield _unless_refused(one, as_stated, tolerances)
    for failed in left:
        if _fails(failed.stated, data):
            own = as_stated[failed.name][0]
            known = [one for check in checks for one in check.of_failed_fit(own)]
            if known or _fails_along(own, tolerances):
                yield from known or [_failed(failed)]
    for check in checks:
        yield from check.of_stiffness(data, stiffness)


def _mended(one: Compared) -> Trial | None:
    """Return the change that leaves next to nothing of the misfit."""
    if not one.trials:
        return None
    best = one.trials[0]
    if one.stated is None:
        return best if best.fit.misfit < SUSPICIOUS_MISFIT else None
    return best if one.share(best) < LEFT_BY_CHANGED_DATUM else None


def _changes_along(one: Compared, own: Measurements, tolerances: Tolerances) -> bool:
    """Whether an EIBM that changes along the sheet explains more than the change that mends it.

    It bends the curves more than the forces ask for, as a wrong datum may.
    """
    best = _mended(one)
    if best is None:
        return False
    along = quick_fit(own, tolerances, along=True)
    return along is not None and along.squares < best.fit.squares


def _changed_along(one: Compared, own: Measurements, tolerances: Tolerances) -> Compared | None:
    """Return what mends a configuration if its EIBM changes along the sheet; None: nothing does.

    A constant EIBM fits such a sheet badly, whatever is changed. Of a sign (of forces, voltages)
    the other one then leaves next to nothing, where the stated one leaves much. What else may be
    changed could be an effect.
    """
    trials = [trial for trial in one.trials if trial.change.values == OTHER_SIGN]
    stated = quick_fit(own, tolerances, along=True) if trials else None
    if stated is None or stated.misfit < EXPLAINED_MISFIT:
        return None
    for trial in trials:
        data, value = trial.change.apply(own, trial.fit.value), trial.fit.value
        fit = quick_fit(data, tolerances, value, stated=stated, along=True)
        if fit is None or fit.misfit > EXPLAINED_MISFIT:
            continue
        if fit.squares < LEFT_BY_CHANGED_DATUM * stated.squares:
            return replace(one, stated=stated, trials=(replace(trial, fit=fit),))
    return None


def _unless_refused(
    proposed: ProposedChange,
    as_stated: Mapping[str, tuple[Measurements, QuickFit | None]],
    limits: Tolerances,
) -> Suspicion:
    """Return the suspicion; only a warning where another configuration asks for another value.

    Then it is no datum of the rig: an effect does to each configuration what it does.
    """
    change, suspicion = proposed.change, proposed.suspicion
    if not change.of_rig:
        return suspicion
    for name, (own, stated) in as_stated.items():
        if name in suspicion.configurations or stated is None:
            continue
        begin = replace(stated, value=change.stated)
        other = fit_with(own, limits, change, begin)
        if other is None or not np.isfinite(other.sigma):
            continue
        difference = abs(other.value - proposed.value)
        near = max(
            APART_SHARE * abs(proposed.value), APART_SIGMA * np.hypot(proposed.sigma, other.sigma)
        )
        if difference > near:
            doubt = (
                f"; '{name}' asks for {other.value * change.factor:.4g} {change.unit}, so an"
                " effect may be the reason"
            )
            return replace(suspicion, severity="warn", sentence=f"{suspicion.sentence}{doubt}")
    return suspicion


def _changed(mended: Sequence[Compared]) -> Iterator[ProposedChange]:
    """Yield each change once, with all configurations that ask for it."""
    left = list(mended)
    while left:
        first = left[0].trials[0]
        alike = [one for one in left if _same(first, one.trials[0])]
        left = [one for one in left if one not in alike]
        names = [one.name for one in alike]
        values = np.array([one.trials[0].fit.value for one in alike])
        sigma = np.array([one.trials[0].fit.sigma for one in alike])
        sure = np.all(np.isfinite(sigma)) and np.all(sigma > 0.0)
        weights = sigma**-2.0 if sure else np.ones(len(alike))
        value = float(weights @ values / weights.sum())
        # configurations that differ by more than each is sure of are no surer together
        error = (
            float(max(weights.sum() ** -0.5, np.std(values))) if first.change.continuous else 0.0
        )
        change = first.change
        gap = _gap(alike)
        suspicion = Suspicion(
            check=first.check, severity="stop", where=change.where, configurations=tuple(names),
            value=value * change.factor, sigma=error * change.factor if change.continuous else None,
            unit=change.unit,
            sentence=f"{change.sentence(quoted(names), value, error)}{gap}",
        )  # fmt: skip
        yield ProposedChange(change=change, value=value, sigma=error, suspicion=suspicion)


def _same(one: Trial, other: Trial) -> bool:
    if one.check != other.check or one.change.where != other.change.where:
        return False
    difference, size = abs(one.fit.value - other.fit.value), max(abs(one.fit.value), 1e-12)
    if not one.change.continuous:
        return one.change.sentence("", 0.0, 0.0) == other.change.sentence("", 0.0, 0.0)
    near = max(SAME_SHARE * size, SAME_SIGMA * float(np.hypot(one.fit.sigma, other.fit.sigma)))
    return difference < near


def _gap(alike: Sequence[Compared]) -> str:
    """Return the base model's errors before and after, of the configuration that gains most."""
    known = [one for one in alike if one.stated is not None]
    if not known:
        return "; as they are stated the model has no answer"
    one = min(known, key=lambda each: each.share(each.trials[0]))
    before, after = one.stated, one.trials[0].fit
    if before is None:
        return ""
    return f" (base model, '{one.name}': {_errors(before)} → {_errors(after)})"


def _errors(fit: QuickFit) -> str:
    parts = []
    if np.isfinite(fit.force_rms_N):
        parts.append(f"force error {in_digits(1e3 * fit.force_rms_N, 2)} mN")
    if np.isfinite(fit.curve_rms_m):
        parts.append(f"curve error {1e3 * fit.curve_rms_m:.2g} mm")
    return ", ".join(parts)


def _fails(stated: QuickFit | None, data: Measurements) -> bool:
    """Whether the base model explains so little that no effect could be what is missing."""
    if stated is None:
        return False  # what is missing for a fit is told where it is prepared
    (name,) = stated.forward.names
    sheet = data.sheets[name]
    curve_m = FAILED_CURVE_SHARE * (sheet.free_length_m + sheet.elongation_m)
    force_N = FAILED_FORCE_SHARE * _spread_N(stated)
    return bool(stated.force_rms_N > force_N or stated.curve_rms_m > curve_m)


def _fails_along(own: Measurements, tolerances: Tolerances) -> bool:
    """Whether it fails as well where the EIBM may change along the sheet.

    Where all voltages have one sign, forces spread little, and a constant EIBM is off by as much.
    """
    along = quick_fit(own, tolerances, along=True)
    return along is None or _fails(along, own)


def _spread_N(fit: QuickFit) -> float:
    """Return the standard deviation of the mean forces."""
    rows = [block.trend @ block.measured_N for block in fit.forward.row_index.blocks]
    means = np.concatenate(
        [r[p.is_mean] for r, p in zip(rows, fit.forward.row_index.blocks, strict=True)]
    )
    return float(np.std(means)) if len(means) > 1 else np.inf


def _failed(one: Compared) -> Suspicion:
    stated = one.stated
    errors, spread = ("", 0.0) if stated is None else (_errors(stated), _spread_N(stated))
    return Suspicion(
        check="base_fit", severity="stop", where="forces and curves", configurations=(one.name,),
        sentence=(
            f"the base model does not fit '{one.name}': {errors}, where the forces spread by"
            f" {in_digits(1e3 * spread, 2)} mN, more than any effect could explain; none of those"
            " that were tried (unit, sign, order, length) mends it, so check the tables against"
            " each other"
        ),
    )  # fmt: skip
