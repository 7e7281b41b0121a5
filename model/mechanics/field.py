"""A quantity along the sheet, k0(s), Me(s) or 1/B(s), as polynomials in panels.

Panels end where the quantity has a kink or a jump, so that it is smooth within each. Numbers are
kept as coefficients of powers of t, t = -1 .. 1 over the panel.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from functools import cache, cached_property
from itertools import pairwise
from typing import TypeVar

import numpy as np
from numpy.polynomial import chebyshev, legendre

from model.measurements import FloatArray, ModelError

HIGHEST_DEGREE = 15
SMALLEST_SHARE = 1e-9  # panels narrower than this share of the length are merged
Made = TypeVar("Made")


@dataclass(frozen=True)
class Field:
    """Piecewise polynomial over [breaks_m[0], breaks_m[-1]]."""

    breaks_m: FloatArray  # (P + 1,) ascending
    coefficients: FloatArray  # (P, D) of t**0 .. t**(D - 1)

    @staticmethod
    def constant(value: float, length_m: float) -> Field:
        """Return the same value from the clamp to the end."""
        return Field(np.array([0.0, length_m]), np.array([[float(value)]]))

    @staticmethod
    def linear(s_m: FloatArray, values: FloatArray, length_m: float) -> Field:
        """Straight lines between nodes, as sheet.toml means them; constant beyond the outer."""
        s, v = np.asarray(s_m, dtype=float), np.asarray(values, dtype=float)
        if (
            len(s) != len(v)
            or len(s) < 1
            or not (np.all(np.isfinite(s)) and np.all(np.isfinite(v)))
        ):
            raise ModelError(
                "a quantity along the sheet needs as many finite values as places along the sheet"
            )
        if np.any(np.diff(s) <= 0.0):
            raise ModelError("the places s of a quantity along the sheet must ascend")
        inner = s[(s > SMALLEST_SHARE * length_m) & (s < (1.0 - SMALLEST_SHARE) * length_m)]
        breaks = np.concatenate([[0.0], inner, [length_m]])
        ends = np.interp(breaks, s, v)
        if np.ptp(ends) == 0.0:
            return Field.constant(ends[0], length_m)
        mean, half = 0.5 * (ends[1:] + ends[:-1]), 0.5 * (ends[1:] - ends[:-1])
        return Field(breaks, np.stack([mean, half], axis=1))

    @staticmethod
    def smooth(
        function: Callable[[FloatArray], FloatArray],
        length_m: float,
        kinks_m: Iterable[float] = (),
        tolerance: float = 1e-13,
    ) -> Field:
        """Return a function of s; panels are halved until polynomials follow it to `tolerance`."""
        return smooth_each(function, length_m, kinks_m, tolerance)[0]

    @cached_property
    def length_m(self) -> float:
        """The end of the last panel."""
        return float(self.breaks_m[-1])

    def __call__(self, s_m: FloatArray | float) -> FloatArray:
        """Return values at `s_m`; the outer panels go on beyond the ends."""
        s = np.asarray(s_m, dtype=float)
        panel, t, _ = self._local(s)
        return _horner(self.coefficients[panel], t)

    def integral(self, s_m: FloatArray | float) -> FloatArray:
        """Return integral from the clamp to `s_m`."""
        s = np.asarray(s_m, dtype=float)
        panel, t, half = self._local(s)
        powers = np.arange(1, self.coefficients.shape[1] + 1)
        anti = np.concatenate(
            [np.zeros((len(self.coefficients), 1)), self.coefficients / powers], axis=1
        )
        widths = 0.5 * np.diff(self.breaks_m)
        ends = np.ones(len(anti))
        whole = widths * (_horner(anti, ends) - _horner(anti, -ends))
        before = np.concatenate([[0.0], np.cumsum(whole)])[panel]
        value: FloatArray = before + half * (
            _horner(anti[panel], t) - _horner(anti[panel], np.full_like(t, -1.0))
        )
        return value

    @staticmethod
    def integral_weights(breaks_m: FloatArray, degree: int, s_m: FloatArray) -> FloatArray:
        """Return the matrix (S, P degree) from coefficients on these panels to `integral` at s."""
        panel, t, half = _places(breaks_m, s_m)
        powers = np.arange(1, degree + 1)
        low = (-1.0) ** powers
        whole = 0.5 * np.diff(breaks_m)[:, None] * ((1.0 - low) / powers)
        before = np.arange(len(breaks_m) - 1) < panel[:, None]
        result: FloatArray = before[:, :, None] * whole
        own = half[:, None] * (t[:, None] ** powers - low) / powers
        result[np.arange(len(panel)), panel] = own
        return result.reshape(len(panel), -1)

    def mean(self, end_m: float) -> float:
        """Return mean over [0, end_m]."""
        return float(self.integral(end_m)) / end_m

    def on(self, breaks_m: FloatArray) -> Field:
        """Return the same quantity on other panels; exact where the panels only get finer."""
        if breaks_m is self.breaks_m or np.array_equal(breaks_m, self.breaks_m):
            return self
        degree = self.coefficients.shape[1]
        x = _chebyshev(degree)[0]
        low, high = breaks_m[:-1, None], breaks_m[1:, None]
        middle = (0.5 * (low + high))[:, 0]
        panel = np.clip(np.searchsorted(self.breaks_m, middle) - 1, 0, len(self.coefficients) - 1)
        s = 0.5 * (low + high) + 0.5 * (high - low) * x[None, :]
        left, right = self.breaks_m[panel][:, None], self.breaks_m[panel + 1][:, None]
        t = (2.0 * s - left - right) / (right - left)
        values = _horner(self.coefficients[panel][:, None, :], t)
        return Field(np.asarray(breaks_m, dtype=float), _powers(values))

    def __add__(self, other: Field) -> Field:
        breaks = merged_breaks([self.breaks_m, other.breaks_m])
        one, two = self.on(breaks).coefficients, other.on(breaks).coefficients
        degree = max(one.shape[1], two.shape[1])
        return Field(breaks, padded(one, degree) + padded(two, degree))

    def __mul__(self, factor: float) -> Field:
        return Field(self.breaks_m, self.coefficients * float(factor))

    __rmul__ = __mul__

    @cached_property
    def largest(self) -> float:
        """An upper bound of the magnitude."""
        return float(np.abs(self.coefficients).sum(axis=1).max())

    def _local(self, s: FloatArray) -> tuple[np.ndarray, FloatArray, FloatArray]:
        return _places(self.breaks_m, s)


def _places(breaks_m: FloatArray, s: FloatArray) -> tuple[np.ndarray, FloatArray, FloatArray]:
    """Return the panel of each s, the place in it (-1 .. 1), and half the panel's width."""
    panel = np.clip(np.searchsorted(breaks_m, s, side="right") - 1, 0, len(breaks_m) - 2)
    low, high = breaks_m[panel], breaks_m[panel + 1]
    half = 0.5 * (high - low)
    return panel, (s - 0.5 * (low + high)) / half, half


def for_each_field(make: Callable[[Field], Made], fields: Sequence[Field]) -> list[Made]:
    """Return what `make` makes of each field; of one that occurs several times it is made once."""
    made = {key: make(one) for key, one in {id(one): one for one in fields}.items()}
    return [made[id(one)] for one in fields]


def values_of_each(fields: Sequence[Field], s_m: FloatArray) -> FloatArray:
    """Return the values of fields of one length at s (n,): (K, n)."""
    if any(not np.array_equal(f.breaks_m, fields[0].breaks_m) for f in fields[1:]):
        return np.stack([f(s_m) for f in fields])
    degree = max(f.coefficients.shape[1] for f in fields)
    rows = np.stack([padded(f.coefficients, degree) for f in fields])
    panel, t, _ = _places(fields[0].breaks_m, s_m)
    return _horner(rows[:, panel], t)


def merged_breaks(all_breaks: Iterable[FloatArray]) -> FloatArray:
    """Return the ends of all panels, those that coincide but for rounding counted once."""
    every = np.unique(np.concatenate([np.asarray(b, dtype=float) for b in all_breaks]))
    keep = np.concatenate([[True], np.diff(every) > SMALLEST_SHARE * (every[-1] - every[0])])
    kept = every[keep]
    kept[-1] = every[-1]
    result: FloatArray = kept
    return result


def padded(coefficients: FloatArray, degree: int) -> FloatArray:
    """Return coefficients with zeros added up to `degree` columns."""
    missing = degree - coefficients.shape[-1]
    if missing <= 0:
        return coefficients
    zeros = np.zeros((*coefficients.shape[:-1], missing))
    return np.concatenate([coefficients, zeros], axis=-1)


def _horner(coefficients: FloatArray, t: FloatArray) -> FloatArray:
    """Polynomials whose coefficients stand along the last axis, at t."""
    value = coefficients[..., -1] * np.ones_like(t)
    for k in range(coefficients.shape[-1] - 2, -1, -1):
        value = value * t + coefficients[..., k]
    return value


@cache
def _chebyshev(count: int) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Chebyshev points on [-1, 1]; values there -> Chebyshev coefficients -> powers of t."""
    x = np.cos(np.pi * (np.arange(count) + 0.5) / count)
    to_chebyshev = np.asarray(np.linalg.inv(chebyshev.chebvander(x, count - 1)), dtype=float)
    to_powers = np.zeros((count, count))
    for k in range(count):
        powers = chebyshev.cheb2poly(np.eye(count)[k])
        to_powers[: len(powers), k] = powers
    return x, to_chebyshev, to_powers


def _powers(values: FloatArray) -> FloatArray:
    """Return values at Chebyshev points (..., count) -> coefficients of powers of t."""
    _, to_chebyshev, to_powers = _chebyshev(values.shape[-1])
    coefficients = values @ to_chebyshev.T
    # rounding noise of high degree would grow by orders of magnitude in powers of t
    noise = 4e-16 * np.max(np.abs(values), axis=-1, keepdims=True)
    return np.where(np.abs(coefficients) > noise, coefficients, 0.0) @ to_powers.T


def smooth_each(
    function: Callable[[FloatArray], FloatArray],
    length_m: float,
    kinks_m: Iterable[float] = (),
    tolerance: float = 1e-13,
) -> list[Field]:
    """Return several functions of s as `Field.smooth` does, all on the panels that the worst needs.

    `function` returns the values of all of them at s (n,), an array (K, n); (n,) of one.
    """
    inner = sorted(k for k in kinks_m if 0.0 < k < length_m)
    edges = [0.0, *inner, float(length_m)]
    todo, done = list(pairwise(edges))[::-1], []
    while todo:
        low, high = todo.pop()
        coefficients, good = _interpolate(function, low, high, tolerance)
        if good or high - low < length_m / 256:
            done.append((low, high, coefficients))
        else:
            middle = 0.5 * (low + high)
            todo += [(middle, high), (low, middle)]
    breaks = np.array([done[0][0], *(high for _, high, _ in done)])
    return [Field(breaks, rows) for rows in np.stack([c for _, _, c in done], axis=1)]


def _interpolate(
    function: Callable[[FloatArray], FloatArray], low: float, high: float, tolerance: float
) -> tuple[FloatArray, bool]:
    """Powers of t for one panel (K, D), and whether they follow every function in between, too."""
    x = _chebyshev(HIGHEST_DEGREE + 1)[0]
    between = np.linspace(-1.0, 1.0, 2 * len(x) + 1)
    at_m = 0.5 * (low + high) + 0.5 * (high - low) * np.concatenate([x, between])
    every = np.atleast_2d(np.asarray(function(at_m), dtype=float))
    every = np.broadcast_to(every, (len(every), len(at_m)))
    values, wanted = every[:, : len(x)], every[:, len(x) :]
    if not np.all(np.isfinite(values)):
        near_mm = 0.5e3 * (low + high)
        raise ModelError(f"a quantity along the sheet is not finite near s = {near_mm:.3g} mm")
    coefficients = _powers(values)
    error = np.max(np.abs(_horner(coefficients[:, None], between) - wanted), axis=1)
    most = np.maximum(np.max(np.abs(wanted), axis=1), 1e-300)
    return coefficients, bool(np.all(error <= tolerance * most))


def legendre_field(degree: int, length_m: float) -> Field:
    """Return a Legendre polynomial over the sheet; its mean is 0 but for degree 0."""
    powers = legendre.leg2poly(np.eye(degree + 1)[degree])
    return Field(np.array([0.0, length_m]), np.asarray(powers, dtype=float)[None, :])
