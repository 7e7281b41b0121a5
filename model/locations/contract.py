"""The contract of a location of discrepancy: a component of the model that may be wrong.

A location says how a nonparametric term acts there, and which terms are looked for. A term is a
function of one coordinate (`Term`), in the location's unit. The same methods act for prediction,
where a model file brings a term with numbers, and for inference, where the terms are basis shapes:
    `beam`      change the beam problem
    `bent`      change it, given a solution: where a term goes with the bending
    `course`    change EIBM and stiffness in the course of time, relative
    `force`     add to the force that the load cell reads, N
    `curve`     add to the points of the curve that the camera sees, m
    `in_image`  change the EIBM in the image of a reading, relative
Each is called often, must not block, keeps no state, changes none of its arguments, and returns
what it is given, or None, where the term's coordinate is none of its own. It raises nothing.

`bases` yields the basis shapes of one configuration, at its typical amplitude each. It is called
once for each candidate.
"""

# ruff: noqa: ARG002 - the methods that a location may override do nothing with what they are given

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from model.locations.quantities import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    ImagePoints,
    LoadCellInput,
    Perturbation,
)
from model.measurements import FloatArray, RigScale

Function = Callable[[FloatArray], FloatArray]  # of a coordinate 0 .. 1


class Term(Protocol):
    """A nonparametric term: a function of one coordinate, in the unit of its location."""

    @property
    def along(self) -> str:
        """Return the coordinate; `model.sheet.beam_problem.Profile` says which there are."""

    @property
    def adds(self) -> str:
        """Return to what it is added; empty: that follows from the coordinate."""

    def __call__(self, at: FloatArray) -> FloatArray:
        """Return its values there."""

    def share(self, voltage_V: FloatArray) -> FloatArray:
        """Return 1, 0 or -1, or between: in which sense it acts at these voltages."""

    def part(self, voltage_V: FloatArray) -> FloatArray:
        """Return the share of the voltage at which it was inferred, at most 1."""

    def even(self, voltage_V: FloatArray) -> FloatArray:
        """Return the share of what is the same at both polarities, at most 1."""


@dataclass(frozen=True, kw_only=True)
class BasisTerm:
    """A basis function as a term: of a coordinate `low` .. `high`."""

    along: str
    function: Function
    low: float
    high: float
    under: str = ""
    adds: str = ""
    nodes: int = 51  # of straight lines that are near enough

    def __call__(self, at: FloatArray) -> FloatArray:
        """Return its values; in the middle where there is no coordinate."""
        span = self.high - self.low
        if span <= 0.0:
            return self.function(np.full_like(at, 0.5))
        return self.function(np.nan_to_num((at - self.low) / span, nan=0.5))

    def share(self, voltage_V: FloatArray) -> FloatArray:
        """Return 1, 0 or -1: in which sense it acts at these voltages."""
        sign = np.sign(voltage_V)
        return {"": np.ones_like(sign), "voltage": np.abs(sign), "polarity": sign}[self.under]

    def part(self, voltage_V: FloatArray) -> FloatArray:
        """Return 1: it is a function of what was measured."""
        return np.ones_like(voltage_V)

    def even(self, voltage_V: FloatArray) -> FloatArray:
        """Return 1, as `part`."""
        return np.ones_like(voltage_V)


@dataclass(frozen=True, kw_only=True)
class Basis:
    """One basis shape of one configuration."""

    part: str  # what it changes, and along what: one of several that a location may have
    along: str  # s | position | force | time | place | curvature, as it is reported
    # of `span` brought to 0 .. 1, in `unit`; None: it has no profile
    function: Function | None
    unit: str
    span: tuple[float, float, str]  # of the coordinate, with its unit
    step: Perturbation
    shared: bool = False  # whether the rig does it to all configurations alike
    # whether its part is looked for by itself only, and is none of the location as a whole
    alone: bool = False
    # what a model file has of it; None: nothing that a prediction of means could show
    term: BasisTerm | None = None
    # how it shows, for messages: follows what the location says; empty: its coordinate says it
    shows: str = ""


@dataclass(frozen=True, kw_only=True)
class Linearised:
    """One configuration at the point about which the data are linear: what `bases` works on."""

    configuration: str
    beam: BeamProblem
    contact: ContactSolution
    weighed: LoadCellInput  # of the readings
    points: ImagePoints
    clock: AcquisitionTimes  # of the readings (n,)
    position_m: FloatArray  # (n,) of each reading; NaN: free
    reading_of: npt.NDArray[np.int64]  # (n,) condition of each reading
    initial_curvature_per_m: FloatArray  # (G,)
    force_at_0V_N: FloatArray  # (K,) what the force would be without the EIBM
    measured_at: FloatArray  # (K,) when each condition was measured, 0 .. 1 over the session
    has_curve: npt.NDArray[np.bool_]  # (K,)
    positions_m: tuple[float, float]  # range over all configurations
    pictured: tuple[tuple[float, float], ...]  # first and last picture of each, as `measured_at`
    forces_N: tuple[float, float]  # range of what was measured
    bent_per_m: float  # the largest bending over all configurations
    scale: RigScale  # of the session: amplitudes that are lengths or forces go with it
    bin_clock: AcquisitionTimes  # parts of the pulses (m,)
    bin_sample: AcquisitionTimes  # the sampling points of the same pulses (m,)
    bin_mean: Function  # mean over the pulses, (m,) to (b,)
    nothing: Callable[[], Perturbation]  # a change of nothing
    change: Callable[[BeamProblem], FloatArray]  # from `beam` to another one, as in a Perturbation


@dataclass(frozen=True, kw_only=True)
class Location:
    """A component of the model that may be wrong."""

    name: str  # also of its file
    meaning: str  # a noun phrase for headings
    depends: str  # how a term shows, for messages: "the same at all voltages and positions"
    unit: str  # of its terms
    order: int  # of presentation; that of the catalogue of effects, too
    # whether it concerns single readings rather than their means: then it needs series in time
    in_time: bool = False

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """Return the beam problem with the term in it."""
        return beam

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """Return the beam problem with the term in it, given a solution."""
        return self.beam(beam, term)

    def course(self, clock: AcquisitionTimes, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """Return the relative change of EIBM and of stiffness at each time."""
        return None

    def force(self, weighed: LoadCellInput, term: Term) -> FloatArray | None:
        """Return what is added to the force of each reading, N."""
        return None

    def curve(self, points: ImagePoints, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """Return what is added to x and y of the points, m."""
        return None

    def in_image(
        self, clock: AcquisitionTimes, position_m: FloatArray, term: Term
    ) -> FloatArray | None:
        """Return the relative change of the EIBM in the image of each reading."""
        return None

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """Return the basis shapes of one configuration."""
        yield from ()
