"""What an effect is: one object that says what it is and what it changes.

An effect acts in up to six places, each a method that changes nothing unless it is overridden:
    `beam`    the beam problem: moments, stiffness, rest curvature, where clamp and contact are
    `course`  how EIBM and stiffness go with time, relative to the settled values
    `lagging` what its memory adds to the rest curvature from reading to reading
    `force`   what the load cell adds to the force
    `curve`   where the camera puts the points of a curve
    `in_image` the EIBM in the image of a reading
Values of further channels of the rig (humidity, temperature) are in `AcquisitionTimes`, which
`beam.clock` is, too, and in `LoadCellInput`: `clock.channel("humidity_percent", 50.0)` are those of
all readings, 50 where none was recorded. So `otherwise` has to be a value at which the effect does
nothing. A prediction has no channels. An effect names those that it reads in `channels`.

All work on arrays; a `BeamProblem` holds K conditions of one configuration, quantities along the
sheet are values at its G nodes.
"""

# ruff: noqa: ARG002 - the methods that an effect may override do nothing with what they are given

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from typing import Literal

import numpy as np

from model.locations.quantities import (
    AcquisitionTimes,
    BeamProblem,
    ContactSolution,
    ImagePoints,
    LoadCellInput,
    Values,
)
from model.measurements import FloatArray, RigScale, SheetGeometry

__all__ = [
    "AcquisitionTimes",
    "Along",
    "BeamProblem",
    "ContactSolution",
    "Effect",
    "EffectParameter",
    "ImagePoints",
    "LoadCellInput",
    "Values",
]

# "time": within a pulse, along a run and over the session; "session" and "wetted": only over the
# session, and only since the sheet was wetted, alike in all runs; "approach": at 0 V, after each
# side of approach; "polarity": for each sheet another way than for the others
Along = Literal[
    "s", "curvature", "position", "voltage", "time", "session", "wetted", "place", "run",
    "approach", "polarity",
]  # fmt: skip


NOTICED_POWER = 6.0  # of an amplitude over its limit: half the limit is noticed by one in 65


@dataclass(frozen=True, kw_only=True)
class EffectParameter:
    """A parameter of an effect, in the unit of its name."""

    name: str
    meaning: str
    unit: str
    prior_scale: float  # an amplitude that would surprise nobody; the width of its prior
    low: float = -np.inf
    high: float = np.inf
    neutral: float = 0.0  # the value at which the effect is absent
    log: bool = False  # positive, and refined in its logarithm
    # shapes to look for: values that are tried one by one; empty: the size, which is estimated
    starting_values: tuple[float, ...] = ()
    expected_sign: float = 0.0  # the sign that it has as a rule; the other one is a surprise
    one_sign: bool = False  # where each configuration has its own, all have the same sign
    estimated: bool = False  # though not the first: a further size, refined like that
    # |value| that every other laboratory would notice, and what is noticed, a sentence with {value}
    # in the parameter's unit or {degrees}; None: there is no such limit
    instrument_limit: float | None = None
    beyond: str = ""
    # the unit by which its usual size goes with that of the session; empty: its own
    scales_as: str = ""

    @property
    def unstated(self) -> float:
        """The value that it has where a model states none."""
        return self.neutral if self.estimated else self.prior_scale

    def at_scale(self, scale: RigScale) -> EffectParameter:
        """Return the parameter with what is usual in a session of another size."""
        factor = scale.of_unit(self.scales_as or self.unit)
        if factor == 1.0:
            return self
        limit = self.instrument_limit
        return replace(
            self, prior_scale=factor * self.prior_scale, low=factor * self.low,
            high=factor * self.high, neutral=factor * self.neutral,
            starting_values=tuple(factor * one for one in self.starting_values),
            instrument_limit=None if limit is None else factor * limit,
        )  # fmt: skip

    def overlooked(self, value: float) -> float:
        """Return the probability that nobody in the laboratory noticed a value, without an edge."""
        if self.instrument_limit is None:
            return 1.0
        return float(1.0 / (1.0 + (abs(value) / self.instrument_limit) ** NOTICED_POWER))

    def beyond_limit(self, value: float) -> str:
        """Return what somebody would have noticed."""
        return self.beyond.format(
            value=f"{abs(value):.2g}", degrees=f"{np.degrees(abs(value)):.0f}"
        )

    def meaning_of(self, value: float) -> str:
        """Return what a value stands for: by `meaning`, as in "0: evenly; 1: slower", or itself."""
        for clause in self.meaning.split("; "):
            number, colon, text = clause.partition(": ")
            if colon and number == f"{value:g}":
                return text
        return f"{value:g} {self.unit}".strip()


@dataclass(frozen=True, kw_only=True)
class Effect:
    """An entry of the catalogue."""

    name: str
    meaning: str
    form: str
    location: str  # the name of a location of discrepancy
    signature: str
    isolates: str
    source: str
    parameters: tuple[EffectParameter, ...]
    # along what its form may differ from the one written here
    form_error_along: tuple[Along, ...] = ("voltage",)
    waves: int = 3  # of a deviation along the sheet: more where the form itself has no shape
    # whether each configuration may have its own size
    by_configuration: bool = False
    of_the_rig: bool = False  # not of the sheet: the same for all configurations
    # whether at 0 V it depends on how the sheet came there, which its form cannot know
    by_history: bool = False
    # of the camera: whether it makes curves longer or shorter, as a scale does. A fit compares
    # curves across themselves, so that their lengths alone show it
    moves_along_sheet: bool = False
    extra: Mapping[str, str] = field(default_factory=dict)  # unit by name of derived quantities
    # whether the base model has its plain shape as a parameter, unless asked to be symmetric
    in_base_model: bool = False
    title: str = ""  # what readers are shown; empty: the name, in words
    channels: tuple[str, ...] = ()  # further channels it reads, by name and unit (humidity_percent)
    # compares the polarities: nothing but the EIBM along the sheet where one alone was applied
    needs_both_polarities: bool = False
    needs_session: bool = False  # says nothing of a single run, whose session has no course
    # part of what a model with dynamics says of charge, loss and swing: beside such a model it is
    # what the dynamics leave, never a second copy of them
    explained_by_dynamics: bool = False

    @property
    def amplitude(self) -> EffectParameter:
        """The parameter that measures the size of the effect."""
        return self.parameters[0]

    def at_scale(self, scale: RigScale) -> Effect:
        """Return the effect as it is looked for in a session of another size."""
        return replace(self, parameters=tuple(one.at_scale(scale) for one in self.parameters))

    @property
    def claims(self) -> int:
        """How many things it says that could be so one without the other."""
        return 1

    def for_sessions(self, count: int) -> Effect | None:
        """Return the effect for so many sessions analysed together; None: it needs more."""
        del count
        return self

    def in_order_of_positions(self) -> Effect:
        """Return the effect for data in which what goes with time may go with the position.

        Each sheet's positions were measured once, one after the other along the arc.
        """
        return self

    def outside_base(self) -> Effect | None:
        """Return what of the effect the usual base model lacks; None: it has all of it."""
        return None if self.in_base_model else self

    def differs(self, sizes: Sequence[float]) -> bool:
        """Return whether sizes found together are those of this effect, not of a simpler one."""
        del sizes
        return True

    @property
    def choices(self) -> tuple[EffectParameter, ...]:
        """Parameters that are chosen among the values tried and not estimated."""
        return tuple(p for p in self.parameters[1:] if not p.log and len(p.starting_values) > 1)

    def beam(self, beam: BeamProblem, contact: ContactSolution, p: Values) -> BeamProblem:
        """Return the changed problem; `contact` is its present solution."""
        return beam

    def course(self, clock: AcquisitionTimes, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """Return relative change of EIBM and of stiffness at each time."""
        return None

    def lagging(
        self, beam: BeamProblem, contact: ContactSolution, p: Values
    ) -> Sequence[tuple[FloatArray, FloatArray]]:
        """Change of the rest curvature at each reading of `beam` beyond the mean of its condition.

        As shapes (K, G), 1/m, each with how much of it there is at each reading (n,).
        """
        return ()

    def force(self, weighed: LoadCellInput, p: Values) -> FloatArray | None:
        """Return the contribution to the force, N; readings without contact get it, too."""
        return None

    def curve(self, points: ImagePoints, p: Values) -> tuple[FloatArray, FloatArray] | None:
        """Return the contribution to the points' x and y, m."""
        return None

    def in_image(self, clock: AcquisitionTimes, p: Values) -> FloatArray | None:
        """Return the relative change of the EIBM in the image of a reading, at each time."""
        return None

    def derived(self, p: Values, sheet: SheetGeometry) -> dict[str, float]:
        """Return further quantities people ask for, named as in `extra`."""
        return {}
