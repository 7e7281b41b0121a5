"""How the form of an effect differs from the catalogue's: factors 1 + the sum of its terms."""

from __future__ import annotations

from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    ImagePoints,
    LoadCellInput,
)
from model.measurements import FloatArray
from model.sheet.beam_problem import Adds, Coordinate, Profile


@dataclass(frozen=True)
class Form:
    """The terms of an effect in one configuration."""

    terms: tuple[Profile, ...] = ()

    def along_sheet(self, beam: BeamProblem, contact: ContactSolution) -> FloatArray:
        """Return the factor on what changes along the sheet, (K, G)."""
        factor = np.ones_like(beam.soft) + (self.of_conditions(beam) - 1.0)[:, None]
        for term in self._factors("s", "curvature"):
            at = beam.s_m if term.along == "s" else np.abs(contact.curvature - contact.at_rest)
            factor = factor + term.share(beam.voltage_V)[:, None] * term(at)
        return factor

    def of_conditions(self, beam: BeamProblem) -> FloatArray:
        """Return the factor on everything in a condition, (K,)."""
        return self._factor(beam.voltage_V, position=beam.stated_m)

    def of_readings(self, clock: AcquisitionTimes) -> FloatArray:
        """Return the factor at each time."""
        return self._factor(clock.voltage_V, position=clock.position_m, pulse=clock.pulse_s)

    def in_pulse(self, clock: AcquisitionTimes) -> FloatArray:
        """Return the factor at each time that depends on the time within the pulse."""
        own = Form(tuple(term for term in self.terms if term.along == "pulse"))
        return own.of_readings(clock)

    def without(self, along: Coordinate) -> Form:
        """Return the form without its terms along a coordinate."""
        return Form(tuple(term for term in self.terms if term.along != along))

    def of_forces(self, weighed: LoadCellInput) -> FloatArray:
        """Return the factor on what the load cell adds to each reading."""
        return self._factor(
            weighed.voltage_V, position=weighed.position_m, pulse=weighed.pulse_s,
            run=weighed.run_s,
        )  # fmt: skip

    def of_points(self, points: ImagePoints) -> FloatArray | float:
        """Return the factor on what the camera does to points, of their shape."""
        factor: FloatArray | float = 1.0
        for term in self._factors("s", "configuration"):
            factor = factor + term(points.s_m)
        return factor

    def added(self, adds: Adds, *, session: FloatArray, run_s: FloatArray | float) -> FloatArray:
        """Return what is added to something in the course of session and run."""
        times = {"session": session, "run": np.broadcast_to(run_s, np.shape(session))}
        total = np.zeros(np.shape(session))
        for term in self.terms:
            if term.adds == adds and term.along in times:
                total = total + term(times[term.along])
        return total

    def _factor(self, voltage_V: FloatArray, **at: FloatArray | float) -> FloatArray:
        """Return 1 + all terms along these coordinates, and those of the condition as a whole."""
        factor = np.ones_like(voltage_V)
        places = {**at, "voltage": voltage_V, "configuration": 0.0}
        for term in self._factors(*places):
            there = np.broadcast_to(np.asarray(places[term.along]), factor.shape)
            factor = factor + term.share(voltage_V) * term(there)
        return factor

    def _factors(self, *along: str) -> Iterator[Profile]:
        return (term for term in self.terms if not term.adds and term.along in along)


def form_in(terms: Sequence[Profile], configuration: str) -> Form | None:
    """Return the form in a configuration; None where it is the catalogue's."""
    own = tuple(t for t in terms if not t.configurations or configuration in t.configurations)
    return Form(own) if own else None


def key_of(term: Profile) -> tuple[object, ...]:
    """Return what terms share that are one when they are added."""
    return term.along, term.at, term.under, term.adds, term.configurations, term.full_V


def combined(terms: Iterable[Profile]) -> tuple[Profile, ...]:
    """Return the terms with those along the same nodes added up."""
    alike: dict[tuple[object, ...], list[Profile]] = {}
    for term in terms:
        alike.setdefault(key_of(term), []).append(term)
    return tuple(some[0] if len(some) == 1 else _total(some) for some in alike.values())


def _total(some: Sequence[Profile]) -> Profile:
    values = np.sum([one.values for one in some], axis=0)
    sigma = np.sqrt(np.sum(np.square([one.sigma for one in some]), axis=0))
    return replace(some[0], values=tuple(values.tolist()), sigma=tuple(sigma.tolist()))


def scaled(term: Profile, size: float) -> Profile:
    """Return a term times a number."""
    return replace(
        term, values=tuple(size * v for v in term.values),
        sigma=tuple(abs(size) * v for v in term.sigma),
    )  # fmt: skip
