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

Measure = Callable[[Hidden], float]
_ROUNDS = 12


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
    return size_for(case, wanted, lambda hidden: gap(hidden, bare), tolerance)


def size_for(case: Case, wanted: float, measure: Measure, tolerance: float = 0.05) -> float:
    """The size of the case's one effect at which `measure` is within `tolerance` of `wanted`.

    `measure` takes the session and must grow with the size, about in proportion: a gap, or a
    detectability. Raises ValueError where even the largest size that makes sense is too small.
    """
    (hiding,) = case.hidden
    form = form_of(hiding.effect, hiding.form)

    def found(size: float) -> float:
        return measure(hidden_session(replace(case, hidden=(replace(hiding, size=size),))))

    size, low, high = form.size if hiding.size is None else hiding.size, 0.0, form.largest
    for _ in range(_ROUNDS):
        value = found(size)
        if abs(value - wanted) <= tolerance * wanted:
            return size
        if value < wanted:
            if size >= form.largest:
                raise ValueError(
                    f"{form.effect} ({form.form}) of {size:g} makes {value:.3g}, not {wanted:g}"
                )
            low = max(low, size)
        else:
            high = min(high, size)
        guess = size * wanted / value if value > 0 else high
        if not low < guess < high:
            guess = high if high == form.largest and guess >= high else _between(low, high)
        size = guess
    raise ValueError(f"{form.effect} ({form.form}): no size found at which it makes {wanted:g}")


def _between(low: float, high: float) -> float:
    return math.sqrt(low * high) if low > 0 else high / 4
