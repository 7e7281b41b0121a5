"""The held sheet creeps."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects._memory import SPREAD, lagging, spread_about
from model.effects._values import finite
from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    Effect,
    EffectParameter,
    Values,
)
from model.measurements import FloatArray

NEUTRAL_S, FIRST_S, SAME_M = 5.0, 0.1, 1e-9
DECADE_S = (2.0, 20.0)  # in which an exponential change is what the logarithm's would be


@dataclass(frozen=True)
class ViscoelasticCreep(Effect):
    """What relaxes is the stress of a strain that stays: it becomes the new shape at rest.

    Taken strictly (`time_s` above 0) that is the strain at 0 V, in which the sheet is held all the
    time, or the mean of both polarities, which come and go too quickly; a standard linear solid.
    Taken loosely (`time_s` 0) the stiffness as a whole goes down with the logarithm of time.
    """

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """See `Effect.beam`."""
        rest = beam.rest
        for strain, much in remembered(beam, contact, p):
            rest = rest + _mean(much, beam)[:, None] * strain
        return replace(beam, rest=rest)

    def lagging(
        self, beam: BeamProblem, contact: ContactSolution, p: Values
    ) -> Sequence[tuple[FloatArray, FloatArray]]:
        """See `Effect.lagging`."""
        return [
            (strain, much - _mean(much, beam)[beam.reading_of])
            for strain, much in remembered(beam, contact, p)
        ]

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """See `Effect.course`."""
        if p["time_s"] > 0.0:
            return None
        decades = np.log10(np.maximum(clock.run_s, FIRST_S) / NEUTRAL_S)
        return np.zeros_like(decades), p["relative_change_per_decade"] * decades


def remembered(
    beam: BeamProblem, contact: ContactSolution, p: Values
) -> list[tuple[FloatArray, FloatArray]]:
    """Strains, 1/m (K, G), each with the share that has become the shape at rest by now (n,).

    The strain at 0 V stays from when the sheet was placed and wetted, or from when the run began;
    what the mean of the polarities adds to it, from the first pulse; half their difference comes
    and goes.
    """
    if p["time_s"] == 0.0:
        return []
    at_zero, mean, half = strains(beam, contact)
    clock = beam.clock
    driven = np.abs(np.sign(clock.voltage_V))
    held_s = clock.run_s if p["from_run"] > 0.5 else clock.wetted_s
    return [
        (at_zero, _share(lambda tau: -np.expm1(-held_s / tau), p)),
        (mean - at_zero, _share(lambda tau: -driven * np.expm1(-clock.driven_s / tau), p)),
        (half, _share(lambda tau: np.sign(clock.voltage_V) * lagging(clock, tau, -1.0), p)),
    ]


def _share(lag: Callable[[float], FloatArray], p: Values) -> FloatArray:
    """By which a strain with this lag has become the shape at rest."""
    times = spread_about(p["time_s"], p[SPREAD.name])
    decade = float(np.mean(np.exp(-DECADE_S[0] / times) - np.exp(-DECADE_S[1] / times)))
    lagging = np.mean([lag(float(tau)) for tau in times], axis=0)
    return np.asarray(-p["relative_change_per_decade"] / decade * lagging)


def strains(
    beam: BeamProblem, contact: ContactSolution
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """At 0 V, mean and half difference of the polarities, at the place of each: (K, G) each.

    Where a place lacks one of the polarities the voltage adds nothing to the strain at 0 V; where
    it lacks 0 V the mean of the polarities stands for that.
    """
    load = finite(contact.normal_N)[:, None] * finite(contact.lever) / beam.stiffness[:, None]
    strain = beam.soft * (beam.eibm + beam.bend - load)
    at, sign = beam.stated_m, np.sign(beam.voltage_V)
    same = (np.abs(at[:, None] - at) < SAME_M) | (np.isnan(at)[:, None] & np.isnan(at))

    def mean_at(v: float) -> tuple[FloatArray, FloatArray]:
        """Return the mean of those at the same place, and whether there is any: (K, G), (K, 1)."""
        use = (same & (sign == v)).astype(float)
        count = np.sum(use, axis=1, keepdims=True)
        return use @ strain / np.maximum(count, 1.0), np.minimum(count, 1.0)

    (at_zero, rested), (positive, one), (negative, other) = (mean_at(v) for v in (0.0, 1.0, -1.0))
    both = one * other
    mean, half = (0.5 * both * v for v in (positive + negative, positive - negative))
    at_zero = np.where(rested > 0.0, at_zero, mean)
    return at_zero, np.where(both > 0.0, mean, at_zero), half


def _mean(values: FloatArray, beam: BeamProblem) -> FloatArray:
    """Of the readings of each condition: (K,)."""
    return np.asarray(np.bincount(beam.reading_of, beam.share * values, len(beam.voltage_V)))


EFFECT = ViscoelasticCreep(
    name="viscoelastic_creep",
    meaning=(
        "Held in one place the polymer relaxes: its stiffness changes by the same share in each"
        " tenfold of the time in the run. Negative: it gives way, as what relaxes does."
    ),
    form=(
        "B = B at 5 s x (1 + c log10(t/5 s)), t since the run began; or k0 moves towards the strain"
        " that stays as 1 - exp(-t/tau), by -c between 2 and 20 s"
    ),
    location="time",
    signature=(
        "In every run anew, at 0 V too, the force changes quickly in the first seconds and ever"
        " more slowly later, in proportion to itself; not in the means."
    ),
    isolates="A long hold at 0 V far from the free position, the first seconds of it recorded.",
    source=(
        "Findley, Lai and Onaran 1976, Creep and Relaxation of Nonlinear Viscoelastic Materials;"
        " Newbury and Leo 2003, J. Intell. Mater. Syst. Struct. 14, 333"
    ),
    parameters=(
        EffectParameter(
            name="relative_change_per_decade",
            meaning="of the stiffness in each tenfold of time",
            unit="",
            prior_scale=-0.03,
            low=-0.4,
            high=0.0,
        ),
        EffectParameter(
            name="time_s",
            meaning="its time constant, where only the strain that stays relaxes; 0: the"
            " stiffness as a whole, with the logarithm of time",
            unit="s",
            prior_scale=0.0,
            low=0.0,
            high=1e4,
            starting_values=(0.0, 2.0, 8.0, 30.0),
        ),
        SPREAD,
        EffectParameter(
            name="from_run",
            meaning="0: held since it was wetted; 1: since the run began",
            unit="",
            prior_scale=0.0,
            low=0.0,
            high=1.0,
            starting_values=(0.0, 1.0),
        ),
    ),
    explained_by_dynamics=True,
    form_error_along=("time", "position"),
)
