"""Basis functions, and how a location's own methods turn them into basis shapes."""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np
from numpy.polynomial import legendre

from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution, Perturbation
from model.measurements import FloatArray
from model.measurements.pulse_train import DRIVEN_S, PULSE_S

FEW_NODES, FEW_WAVES, WAVES = 8, 3, 9  # waves along a sheet of few nodes, and of more
# how long that takes along which a function of time goes, with its unit
SPANS_S = {
    "session": (1.0, "of the session"), "run": (20.0, "s into the run"),
    "pulse": (PULSE_S, "s into the pulse"), "train": (DRIVEN_S, "s under voltage"),
}  # fmt: skip
LEAST_BENDING_PER_M = 1e-6
# parts that several functions make up together
EACH_POLARITY, WHICH_WAY = "each polarity", "bending, which way"
STEEP = 8.0  # of what depends on which way the sheet is bent, and hardly on how far
FALLING = 0.4  # by which each finer wave is smaller: 1/(1 + FALLING j)


def cosine_wave(j: int, amplitude: float = 1.0) -> Function:
    """Return a cosine of a coordinate 0 .. 1, of unit mean square; finer ones are smaller."""
    share = amplitude / (1.0 + FALLING * j)

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = share * (np.cos(j * np.pi * t) * (np.sqrt(2.0) if j else 1.0))
        return result

    return value


def step_at(place: float, amplitude: float) -> Function:
    """Return a step at a place of a coordinate 0 .. 1: nothing before it."""

    def value(t: FloatArray) -> FloatArray:
        return np.asarray(amplitude * np.heaviside(t - place, 1.0))

    return value


def polynomial(degree: int, amplitude: float) -> Function:
    """Return Legendre's of a coordinate 0 .. 1, of unit mean square; higher ones are smaller."""
    share = amplitude / (1.0 + FALLING * degree)

    def value(t: FloatArray) -> FloatArray:
        number = [0.0] * degree + [np.sqrt(2.0 * degree + 1.0)]
        return np.asarray(share * legendre.legval(2.0 * t - 1.0, number))

    return value


def power(exponent: int, amplitude: float) -> Function:
    """Return a power of a coordinate 0 .. 1."""

    def value(t: FloatArray) -> FloatArray:
        return np.asarray(amplitude * t**exponent)

    return value


def bending_per_m(contact: ContactSolution) -> FloatArray:
    """Return by how much the sheet is bent from its initial shape, 1/m, whichever way: (K, G)."""
    return np.asarray(np.abs(signed_bending_per_m(contact)))


def signed_bending_per_m(contact: ContactSolution) -> FloatArray:
    """Return the same with its sign."""
    return np.asarray(contact.curvature - contact.at_rest)


def bending_along(along: str, contact: ContactSolution) -> FloatArray | None:
    """Return the bending that is a term's coordinate, 1/m; None: its coordinate is another one."""
    how = {"curvature": bending_per_m, "bending": signed_bending_per_m}.get(along)
    return None if how is None else how(contact)


def odd(t: FloatArray) -> FloatArray:
    """Return -1 .. 1 of 0 .. 1, and no more beyond."""
    return np.asarray(np.clip(2.0 * t - 1.0, -1.0, 1.0))


def odd_functions(amplitude: float) -> tuple[Function, ...]:
    """Return functions of a coordinate 0 .. 1 that are odd about its middle.

    The last one hardly goes with the size: one way it is the same everywhere.
    """
    return (
        lambda t: amplitude * odd(t),
        lambda t: amplitude * odd(t) ** 3,
        lambda t: amplitude * np.tanh(STEEP * odd(t)),
    )


def decay(length: float, amplitude: float) -> Function:
    """Return an exponential of a coordinate 0 .. 1 that falls to 1/e within `length`."""

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = amplitude * np.exp(-t / length)
        return result

    return value


def sinusoids(amplitude: float) -> Iterator[Function]:
    """Return cosine and sine of a phase in periods."""
    for part in (np.cos, np.sin):

        def value(phase: FloatArray, part: np.ufunc = part) -> FloatArray:
            return np.asarray(amplitude * part(2.0 * np.pi * phase))

        yield value


def waves_along_sheet(at: Linearised) -> int:
    """Return how many waves along the sheet its nodes can carry."""
    return WAVES if len(at.beam.s_m) > FEW_NODES else FEW_WAVES


def bases_of(
    location: Location,
    at: Linearised,
    functions: Iterable[Function],
    *,
    along: str,
    part: str,
    under: str = "",
    adds: str = "",
    shared: bool = False,
    alone: bool = False,
    shows: str = "",
) -> Iterator[Basis]:
    """Return basis shapes that act as the location's terms do."""
    low, high = _range(at, along)
    factor, unit = _DISPLAYED[along]
    for function in functions:
        term = BasisTerm(along=along, function=function, low=low, high=high, under=under, adds=adds)
        yield Basis(
            part=part, along=along, function=function, unit=location.unit,
            span=(factor * low, factor * high, unit),
            step=perturbation(location, at, term), shared=shared, term=term, alone=alone,
            shows=shows,
        )  # fmt: skip


def bending_bases(location: Location, at: Linearised, amplitude: float) -> Iterator[Basis]:
    """Return what goes with the bending of the sheet and differs from one way to the other.

    What acts one way alone is even and odd in the bending, half each: both are one part.
    """
    ways = {"bending": odd_functions(amplitude), "curvature": [power(n, amplitude) for n in (1, 2)]}
    for along, functions in ways.items():
        yield from bases_of(
            location, at, functions, along=along, part=WHICH_WAY, shared=True,
            alone=True,
        )  # fmt: skip


# factor from SI, and unit, in which a coordinate is reported
_DISPLAYED = {
    "s": (1e3, "mm"), "position": (1e3, "mm"), "force": (1e3, "mN"), "curvature": (1.0, "1/m"),
    "bending": (1.0, "1/m"),
}  # fmt: skip


def _range(at: Linearised, along: str) -> tuple[float, float]:
    """Return the ends of a coordinate, in m, N or 1/m."""
    if along == "position":
        return at.positions_m
    if along == "force":
        return at.forces_N
    if along in ("curvature", "bending"):
        most = max(at.bent_per_m, LEAST_BENDING_PER_M / at.scale.length)
        return (0.0 if along == "curvature" else -most), most
    return 0.0, at.beam.sheet.free_length_m


def perturbation(location: Location, at: Linearised, term: Term) -> Perturbation:
    """Return what a term changes, to first order."""
    step = beam_step(at, location.bent(at.beam, at.contact, term))
    force = location.force(at.weighed, term)
    if force is not None:
        step.force_N = force
    moved = location.curve(at.points, term)
    if moved is not None:
        step.points_m = moved[0] * at.points.normal_x + moved[1] * at.points.normal_y
    seen = location.in_image(at.clock, at.position_m, term)
    if seen is not None:
        step.frame_eibm = seen
    return step


def beam_step(at: Linearised, changed: BeamProblem) -> Perturbation:
    """Return a change of the beam problem, to first order."""
    step = at.nothing()
    if changed is not at.beam:
        step.beam = at.change(changed)
    return step


def time_span(part: str) -> tuple[float, float, str]:
    """Return the ends and the unit of the time that a part is named after: "EIBM, run"."""
    return 0.0, *SPANS_S[part.rpartition(", ")[2]]
