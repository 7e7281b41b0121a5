"""How B and EIBM settle as positions are added: a fit to what was measured up to each of them."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import replace
from typing import Any

from labrig.analysis.results.parameters import plain_parameter
from model import Fit, FitOptions, Measurements, ModelError
from model.identification.base_model import not_weighed, weighs
from model.identification.data.swinging_shapes import without_swinging
from model.identification.joint import Joint, joint_fit
from model.identification.observations import observe

Convergence = dict[str, list[dict[str, Any]]]  # by configuration; see `result_of`
Cancelled = Callable[[], bool]


def converging(
    measurements: Measurements,
    known: Convergence | None = None,
    options: FitOptions | None = None,
    cancelled: Cancelled = lambda: False,
    whole: Fit | None = None,
) -> Convergence:
    """Fit what was measured up to each position; returns all steps of `converging_steps`.

    `cancelled` is asked before each fit.
    """
    found: Convergence = {}
    steps = converging_steps(measurements, known, options, whole)
    while not cancelled() and (step := next(steps, None)) is not None:
        found.setdefault(step[0], []).append(step[1])
    return found


def converging_steps(
    measurements: Measurements,
    known: Convergence | None = None,
    options: FitOptions | None = None,
    whole: Fit | None = None,
) -> Iterator[tuple[str, dict[str, Any]]]:
    """Yield configuration and fit of each step, in the order in which positions were measured.

    Steps that `known` has are not computed again: during a run that is all but the last. A step
    that allows no fit says why. `whole` is the fit of all these measurements, where there is one.
    """
    earlier = {
        (name, one["positions"], one["conditions"]): one
        for name, points in (known or {}).items()
        for one in points
    }
    fits = _Fits(measurements, options or FitOptions(), None if whole is None else whole.joint)
    for name, count, end in _steps(measurements):
        step = earlier.get((name, count, end))
        yield name, step or _step(measurements, name, count, end, fits)


def _steps(measurements: Measurements) -> list[tuple[str, int, int]]:
    """Return configuration, positions measured so far, and conditions up to there."""
    seen: dict[str, set[tuple[float | None, int, int]]] = {}
    last: dict[tuple[str, int], int] = {}
    for i, condition in enumerate(measurements.conditions):
        own = seen.setdefault(condition.configuration, set())
        if condition.position_m is not None:
            own.add((condition.position_m, condition.mounting, condition.run))
        if own:
            last[condition.configuration, len(own)] = i + 1
    return [(name, count, end) for (name, count), end in sorted(last.items(), key=lambda x: x[1])]


def _step(
    measurements: Measurements, name: str, count: int, end: int, fits: _Fits
) -> dict[str, Any]:
    so_far = replace(measurements, conditions=measurements.conditions[:end])
    newest = measurements.conditions[end - 1].position_m
    point: dict[str, Any] = {
        "positions": count,
        "position_mm": None if newest is None else round(1e3 * newest, 6),
        "conditions": end,
        "B_uNm2": None,
        "EIBM_uNm": {},
        "why": "",
    }
    try:
        joint, n = fits.fitted(so_far, name)
    except ModelError as error:
        return {**point, "why": f"{error}."}
    if not weighs(joint.forward.data_vectors[n]):
        return {**point, "why": f"{not_weighed(name, joint.stiffness(n).value)}."}
    voltages = sorted({c.voltage_V for c in so_far.conditions if c.configuration == name} - {0.0})
    return {
        **point,
        "B_uNm2": plain_parameter(joint.stiffness(n), 1e6),
        "EIBM_uNm": {
            str(float(v)): plain_parameter(joint.constant_eibm(n, v), 1e6) for v in voltages
        },
    }


class _Fits:
    """Fits of more and more data; each begins with what the one before has found."""

    def __init__(
        self, measurements: Measurements, options: FitOptions, whole: Joint | None
    ) -> None:
        self._all = len(measurements.conditions)
        self._options = options
        self._whole = whole
        self._last: Joint | None = None

    def fitted(self, measurements: Measurements, name: str) -> tuple[Joint, int]:
        """Fit all configurations together, or one alone while the others do not allow it."""
        present = dict.fromkeys(c.configuration for c in measurements.conditions)
        names = [one for one in measurements.sheets if one in present]
        try:
            return self._joint(measurements, names), names.index(name)
        except ModelError:
            if len(names) == 1:
                raise
            return self._joint(measurements, [name]), 0

    def _joint(self, measurements: Measurements, names: list[str]) -> Joint:
        whole = self._whole
        if whole and len(measurements.conditions) == self._all and whole.forward.names == names:
            return whole
        still, _ = without_swinging(measurements, where_touched=True)
        observed = [observe(still, name) for name in names]
        self._last = joint_fit(still, observed, self._options, self._last)
        return self._last
