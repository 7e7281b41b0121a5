"""What every location of discrepancy must fulfil: `faults` finds nothing in a good one.

Only NumPy is needed, no solver: what a location is given here is made up, but of the right kind.
"""

from __future__ import annotations

from collections.abc import Iterator
from copy import deepcopy
from dataclasses import fields
from functools import partial

import numpy as np

from model.locations.basis import perturbation
from model.locations.contract import Basis, BasisTerm, Linearised, Location
from model.locations.examples import example_linearised
from model.locations.quantities import Perturbation
from model.measurements import FloatArray
from model.plugins import first_faults

TEXTS = ("meaning", "depends", "unit")
COORDINATES = {"s": (0.0, 0.05), "position": (0.005, 0.025), "force": (-3e-3, 3e-3)}


def faults(location: object) -> list[str]:
    """Return what is wrong with a location, a sentence each without its full stop."""
    if not isinstance(location, Location):
        return [f"it is of type {type(location).__name__}, not a model.locations.Location"]
    return first_faults(partial(check, location) for check in (_description, _terms, _bases))


def _description(location: Location) -> Iterator[str]:
    if not (isinstance(location.name, str) and location.name.isidentifier()):
        yield f"its name {location.name!r} must be one word of letters, digits and underscores"
    for name in TEXTS:
        text = getattr(location, name)
        if not (isinstance(text, str) and text.strip()):
            yield f"its {name} is empty"
    if not isinstance(location.order, int):  # other people's may be anything
        yield "its order must be a whole number"  # type: ignore[unreachable]


def _bases(location: Location) -> Iterator[str]:
    """Its basis shapes are finite, of the right shape, and some of them change something."""
    at = example_linearised()
    bases = list(location.bases(at))
    if not all(isinstance(one, Basis) for one in bases):
        yield "its `bases` must yield objects of type Basis"
    elif not any(_changes(one.step) for one in bases):
        yield "none of its basis shapes changes anything"
    else:
        for one in bases:
            yield from _faults_of_step(one.step, at, f"a basis shape of '{one.part}'")
            if one.function is not None and not _finite(one.function(np.linspace(0.0, 1.0, 9))):
                yield f"the function of a basis shape of '{one.part}' is not finite on 0 .. 1"
            if one.function is not None and not one.unit:
                yield f"a basis shape of '{one.part}' has no unit"


def _terms(location: Location) -> Iterator[str]:
    """Its terms act without harm; nothing of them is nothing, and they change no argument."""
    for along in COORDINATES:
        at = example_linearised()
        beam, weighed, points = (deepcopy(one) for one in (at.beam, at.weighed, at.points))
        yield from _faults_of_step(
            perturbation(location, at, _term(along, 0.1)), at, f"a term along {along}"
        )
        if _changes(perturbation(location, at, _term(along, 0.0))):
            yield f"a term along {along} that is 0 changes something"
        for old, new in ((beam, at.beam), (weighed, at.weighed), (points, at.points)):
            if not _equal(old, new):
                yield f"a term along {along} changes its argument {type(old).__name__}"


def _term(along: str, amplitude: float) -> BasisTerm:
    low, high = COORDINATES[along]

    def line(t: FloatArray) -> FloatArray:
        return amplitude * (1.0 + t)

    return BasisTerm(along=along, low=low, high=high, function=line)


def _faults_of_step(step: Perturbation, at: Linearised, what: str) -> Iterator[str]:
    nothing = at.nothing()
    for one in fields(Perturbation):
        values, wanted = getattr(step, one.name), getattr(nothing, one.name)
        if np.shape(values) != wanted.shape:
            yield f"{one.name} of {what} has the shape {np.shape(values)}, not {wanted.shape}"
        elif not _finite(values):
            yield f"{one.name} of {what} is not finite"


def _changes(step: Perturbation) -> bool:
    return any(np.any(getattr(step, one.name)) for one in fields(Perturbation))


def _finite(values: FloatArray) -> bool:
    return bool(np.all(np.isfinite(values)))


def _equal(one: object, other: object) -> bool:
    return all(
        np.array_equal(np.asarray(a), np.asarray(b), equal_nan=True)
        for a, b in ((getattr(one, n), getattr(other, n)) for n in _numbers(one))
    )


def _numbers(one: object) -> list[str]:
    """Return the names of its numeric fields."""
    return [n for n, value in vars(one).items() if isinstance(value, float | np.ndarray)]
