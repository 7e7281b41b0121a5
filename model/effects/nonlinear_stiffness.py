"""Stiffness that depends on how far the sheet is bent."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.effects._values import finite
from model.effects.interface import BeamProblem, ContactSolution, Effect, EffectParameter, Values
from model.measurements import FloatArray, length_scale

# the change of curvature at which the relative change is stated, of a sheet of the paper's size
AT_PER_M = 10.0
MOST = 0.8  # of the moment under which a sheet that softens would give way
_STEPS = 30


@dataclass(frozen=True)
class NonlinearStiffness(Effect):
    """Moment over change of curvature grows as (1 + (change/10 per m)^2)^n, n from the size.

    Or with a power of the change, 1 + c (|change|/10 per m)^p; where that falls, as the p-th root
    of 1/(1 + c' (|change|/10 per m)^p).

    The sheet answers to all moments together, EIBM and load and whatever else bends it. The beam
    gets the law's tangent at the present moments: its slope as softness, its value through one more
    moment, so that solving and applying in turn are Newton's steps.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        load = -finite(contact.normal_N / beam.stiffness)[:, None] * finite(contact.lever)
        linear = (beam.eibm + beam.bend + load) * beam.soft
        change, size = p["relative_change_at_10_per_m"], length_scale(beam.sheet)
        linear = linear * size
        if p["power"] > 0.5:
            true, slope = bent_by_power(linear, change, p["power"])
        else:
            n = exponent(change)
            true = bent(linear, n)
            slope = steepness(true, n)
        soft = beam.soft / slope
        return replace(beam, soft=soft, bend=true / size / soft - beam.eibm - load)


def exponent(relative_change: float) -> float:
    """n, so that the stiffness at 10 per m is 1 + `relative_change` times that at 0."""
    return float(np.log2(1.0 + relative_change))


def steepness(change: FloatArray, n: float) -> FloatArray:
    """Return slope of the moment over B by the change of curvature."""
    u2 = (change / AT_PER_M) ** 2
    slope: FloatArray = (1.0 + u2) ** n * (1.0 + 2.0 * n * u2 / (1.0 + u2))
    return slope


def bent(linear: FloatArray, n: float) -> FloatArray:
    """Return the change of curvature where a sheet of constant stiffness would have `linear` (1/m).

    Solves u (1 + u^2)^n = m, u and m over 10 per m; there is one root for n > -1/2. By Newton in
    the logarithms, in which both ends of the curve are straight.
    """
    if n == 0.0:
        return linear
    m = np.abs(linear) / AT_PER_M
    log_m = np.log(np.maximum(m, 1e-30))
    log_u = np.where(m > 1.0, log_m / (1.0 + 2.0 * n), log_m)
    for _ in range(_STEPS):
        u2 = np.exp(2.0 * log_u)
        step = (log_u + n * np.log1p(u2) - log_m) / (1.0 + 2.0 * n * u2 / (1.0 + u2))
        log_u = log_u - step
        if np.max(np.abs(step), initial=0.0) < 1e-13:
            break
    return np.where(m > 1e-29, np.sign(linear) * AT_PER_M * np.exp(log_u), linear)


def bent_by_power(
    linear: FloatArray, relative_change: float, power: float
) -> tuple[FloatArray, FloatArray]:
    """Change of curvature (1/m) and slope of the moment, where the stiffness goes with its power.

    u (1 + c u^p) = m, or u (1 + c u^p)^(-1/p) = m where it falls; both have the stated change at
    10 per m. The latter bends without bound at m = c^(-1/p), and is cut before.
    """
    m = np.abs(linear) / AT_PER_M
    if relative_change < 0.0:
        c = (1.0 + relative_change) ** -power - 1.0
        m = np.minimum(m, (MOST / c) ** (1.0 / power))
        left = 1.0 - c * m**power
        return np.sign(linear) * AT_PER_M * m * left ** (-1.0 / power), left ** (1.0 + 1.0 / power)
    log_m = np.log(np.maximum(m, 1e-30))
    log_u = np.minimum(log_m, (log_m - np.log(max(relative_change, 1e-30))) / (1.0 + power))
    for _ in range(_STEPS):
        more = relative_change * np.exp(power * log_u)
        step = (log_u + np.log1p(more) - log_m) / (1.0 + power * more / (1.0 + more))
        log_u = log_u - step
        if np.max(np.abs(step), initial=0.0) < 1e-13:
            break
    u = np.where(m > 1e-29, np.exp(log_u), m)
    return np.sign(linear) * AT_PER_M * u, 1.0 + (1.0 + power) * relative_change * u**power


EFFECT = NonlinearStiffness(
    name="nonlinear_stiffness",
    meaning=(
        "The sheet stiffens (softens, when negative) as it is bent away from its shape at rest:"
        " moment and change of curvature are not in proportion."
    ),
    form=(
        "M + Me = B u (1 + (u/10 per m)^2)^n, u = k - k0, 2^n = 1 + c: Hooke's law when bent"
        " little, Ludwick's power law when bent far; or B u (1 + c (|u|/10 per m)^p)"
    ),
    location="compliance",
    signature=(
        "Where moments are large, near the clamp and under voltage, the sheet bends less than the"
        " others let expect; in the force a term that grows faster than the deflection."
    ),
    isolates="Half the voltage beside the full one; held shapes at 0 V far on either side.",
    source=(
        "Lewis and Monasa 1982, Int. J. Non-Linear Mech. 17, 1 (large deflections of cantilever"
        " beams of non-linear materials of the Ludwick type)"
    ),
    parameters=(
        EffectParameter(
            name="relative_change_at_10_per_m",
            meaning=(
                "of the stiffness where bent by 10 per m; on arcs far from 40 mm, by 0.4 over the"
                " arc's radius"
            ),
            unit="",
            prior_scale=0.05,
            low=-0.22,
            high=1.0,
        ),
        EffectParameter(
            name="power",
            meaning="0: Ludwick's law; else of the bending, with which the stiffness changes",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=2.0,
            starting_values=(0.0, 1.0, 2.0),
        ),
    ),
    form_error_along=("curvature", "voltage"),
)
