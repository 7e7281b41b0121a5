"""Conformance of a data check: `faults` returns what is wrong with it."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from copy import deepcopy
from dataclasses import fields, is_dataclass

import numpy as np

from model.discrepancy.data_checks.contract import Change, DataCheck, Suspicion
from model.measurements import Condition, Curve, Measurements, Reading, SheetGeometry


def faults(check: object) -> list[str]:
    """Return what is wrong with a data check, a sentence each without its full stop."""
    if not isinstance(check, DataCheck):
        return [f"it is of type {type(check).__name__}, not a model.discrepancy.DataCheck"]
    for one in (_description, _behaviour):
        if found := list(one(check)):
            return found
    return []


def _description(check: DataCheck) -> Iterator[str]:
    if not (isinstance(check.name, str) and check.name.isidentifier()):
        yield f"its name {check.name!r} must be one word of letters, digits and underscores"
    if not (isinstance(check.meaning, str) and check.meaning.strip()):
        yield "its meaning is empty"
    if not isinstance(check.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]


def _behaviour(check: DataCheck) -> Iterator[str]:
    """Check that it says nothing of good data and leaves its arguments as they are."""
    data = example_measurements()
    before = deepcopy(data)
    answers: dict[str, object] = {
        "suspicions": check.suspicions(data),
        "of_stiffness": check.of_stiffness(data, {"example": 1e-6}),
        "of_failed_fit": check.of_failed_fit(data),
        "changes": check.changes(data),
    }
    for method, answer in answers.items():
        if not isinstance(answer, Iterable):  # other people's may return anything
            yield f"its `{method}` returned {type(answer).__name__}; it must yield what it finds"
            return
    suspicions = [*check.suspicions(data), *check.of_stiffness(data, {"example": 1e-6})]
    of_failed = check.of_failed_fit(data)  # of other data than good ones: it may say anything
    if not all(isinstance(one, Suspicion) for one in (*suspicions, *of_failed)):
        yield "it must yield objects of type Suspicion"
    elif suspicions:
        yield f"it suspects data in which nothing is wrong: {suspicions[0].sentence}"
    for change in check.changes(data):
        yield from _faults_of_change(change, data)
    if not _same(before, data):
        yield "it changes the measurements that it is given"


def _same(one: object, other: object) -> bool:
    """Return whether two measurements, or parts of them, hold the same."""
    if isinstance(one, np.ndarray) and isinstance(other, np.ndarray):
        return np.array_equal(one, other, equal_nan=True)
    if is_dataclass(one) and not isinstance(one, type):
        values = (_same(getattr(one, f.name), getattr(other, f.name)) for f in fields(one))
        return type(one) is type(other) and all(values)
    if isinstance(one, tuple) and isinstance(other, tuple):
        return len(one) == len(other) and all(map(_same, one, other))
    if isinstance(one, dict) and isinstance(other, dict):
        return one.keys() == other.keys() and all(_same(one[key], other[key]) for key in one)
    return one == other


def _faults_of_change(change: object, data: Measurements) -> Iterator[str]:
    if not isinstance(change, Change):
        yield "its `changes` must yield objects of type Change"
    elif not change.values:
        yield f"its change of {change.where} has no value to try"
    else:
        if not isinstance(change.apply(data, change.values[0]), Measurements):
            yield f"its change of {change.where} does not return Measurements"
        text = change.sentence("'example'", change.values[0], 1e-3)
        if not (isinstance(text, str) and text.strip()):
            yield f"its change of {change.where} has no sentence"
        if change.continuous and not np.isfinite(change.stated):
            yield f"its change of {change.where} is continuous and must give the value `stated`"


def example_measurements() -> Measurements:
    """Return made-up measurements of the right kind: a straight sheet at three positions."""
    sheet = SheetGeometry(
        configuration="example", free_length_m=0.05, width_m=0.01, thickness_m=2e-4,
        elongation_m=0.0, arc_radius_m=0.04, arc_origin_rad=0.0,
        initial_curvature=(np.array([0.0, 0.05]), np.array([1.0, 1.0])),
    )  # fmt: skip
    s = np.linspace(0.0, 0.05, 21)
    conditions = tuple(
        Condition(
            configuration="example", position_m=position_m, voltage_V=voltage_V,
            readings=tuple(
                Reading(index=i, kind="kept", force_N=1e-3 * voltage_V + 1e-5 * i)
                for i in range(3)
            ),
            curve=Curve(s_m=s, x_m=s.copy(), y_m=np.zeros(21)),
        )
        for position_m in (0.0, 0.01, 0.02)
        for voltage_V in (0.0, 2.0, -2.0)
    )  # fmt: skip
    return Measurements(sheets={"example": sheet}, conditions=conditions)
