"""How large a hidden effect is to be: by what it does to the data, or by how it can be seen."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.registry import form_of
from benchmarks.hidden_effects.sessions import Hidden, hidden_session
from model import Measurements

_ROUNDS = 12
_MOST_FACTOR = 10.0  # from one guess to the next


def force_gap_mN(hidden: Hidden, bare: Measurements | None = None) -> float:
    """RMS over the conditions of the mean forces less those of the same seed without the effect."""
    other = bare or hidden_session(hidden.case.bare).measurements
    gaps = []
    for a, b in zip(hidden.measurements.conditions, other.conditions, strict=True):
        if a.position_m is not None:
            means = [np.mean([r.force_N for r in c.used()]) for c in (a, b)]
            gaps.append(means[0] - means[1])
    return float(np.sqrt(np.mean(np.square(gaps)))) * 1e3


def curve_gap_mm(hidden: Hidden, bare: Measurements | None = None) -> float:
    """The same of all points of the curves of the mean images."""
    other = bare or hidden_session(hidden.case.bare).measurements
    gaps = []
    for a, b in zip(hidden.measurements.conditions, other.conditions, strict=True):
        if a.curve is not None and b.curve is not None:
            gaps.append(np.hypot(a.curve.x_m - b.curve.x_m, a.curve.y_m - b.curve.y_m))
    return float(np.sqrt(np.mean(np.square(np.concatenate(gaps))))) * 1e3


def size_for_gap(case: Case, wanted: float, tolerance: float = 0.05) -> float:
    """The size of the case's one effect that makes a gap so large.

    In mN RMS of force, or in mm RMS of the curves for an effect that forces do not feel.
    """
    bare = hidden_session(case.bare).measurements
    curves = form_of(case.hidden[0].effect, case.hidden[0].form).felt_by == "curve"
    gap = curve_gap_mm if curves else force_gap_mN
    return _size_for(case, wanted, lambda hidden: gap(hidden, bare), tolerance)


def size_for(
    case: Case, wanted: float, measure: Callable[[Measurements], float], tolerance: float = 0.05
) -> float:
    """The size of the case's one effect at which `measure` is within `tolerance` of `wanted`.

    `measure` is the caller's, such as a detectability; it must grow with the size, about in
    proportion. Raises ValueError where even the largest size that makes sense is too small.
    """
    return _size_for(case, wanted, lambda hidden: measure(hidden.measurements), tolerance)


def _size_for(
    case: Case, wanted: float, measure: Callable[[Hidden], float], tolerance: float
) -> float:
    (hiding,) = case.hidden
    form = form_of(hiding.effect, hiding.form)

    def made(size: float) -> float:
        return measure(hidden_session(replace(case, hidden=(replace(hiding, size=size),))))

    first = form.size if hiding.size is None else hiding.size
    try:
        return found_size(made, wanted, first, form.largest, tolerance)
    except ValueError as error:
        raise ValueError(f"{form.effect} ({form.form}) of {error}") from None


def found_size(
    measure: Callable[[float], float], wanted: float, first: float, largest: float,
    tolerance: float,
) -> float:  # fmt: skip
    """Return the size whose measure is within `tolerance` of `wanted`, searched from `first`.

    Raises ValueError where even the largest is too small, or none is found.
    """
    size = first
    low: tuple[float, float] | None = None  # a size that is too small, and what it makes
    high: tuple[float, float] | None = None
    for _ in range(_ROUNDS):
        value = measure(size)
        if abs(value - wanted) <= tolerance * wanted:
            return size
        if value < wanted and size >= largest:
            raise ValueError(f"{size:g} makes {value:.3g}, not {wanted:g}")
        low, high = ((size, value), high) if value < wanted else (low, (size, value))
        size = min(_guess(low, high, wanted), largest)
    raise ValueError(f"no size that was tried makes {wanted:g}")


def _guess(
    low: tuple[float, float] | None, high: tuple[float, float] | None, wanted: float
) -> float:
    """Between two sizes by the power of the size that both follow; beyond one in proportion."""
    if low is not None and high is not None:
        if low[1] <= 0.0:
            return (low[0] + high[0]) / 2
        power = math.log(high[1] / low[1]) / math.log(high[0] / low[0])
        return float(low[0] * (wanted / low[1]) ** (1 / power))
    size, value = low or high or (0.0, 0.0)
    return size * min(_MOST_FACTOR, wanted / max(value, 1e-300))
