"""The place on the arc where the load cell touches the sheet."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    SPANS_S,
    bases_of,
    beam_step,
    cosine_wave,
    perturbation,
    polynomial,
    time_span,
)
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution
from model.measurements import FloatArray

AMPLITUDE_MM = 1.0
DEGREES = range(1, 4)  # of the force
PLAY_N = (3e-4, 1.5e-3)  # forces that take up the play of a stage
MOMENT_PER_M = 1.0  # of the rolls, over the stiffness
MOMENTS = {"": 4, "voltage": 3, "polarity": 3}  # waves on the arc, by the voltages that turn them
OFF_ARC = ", off the arc (positive: farther from its centre)"
WAVES_IN_RUN = 3
WAVES_ON_ARC = 7  # one for each position of the paper: a screw's error may be anything


@dataclass(frozen=True, kw_only=True)
class Position(Location):
    """An error of the position, along the arc or off it, or by the force, and a moment there."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.along != "position" or term.adds == "moment":
            return beam
        moved = 1e-3 * term.share(beam.voltage_V) * term(np.nan_to_num(beam.stated_m))
        if term.adds == "reach":
            return replace(beam, reach_m=beam.reach_m + moved)
        return replace(beam, shift_m=beam.shift_m + moved)

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """See `Location.bent`: what takes the force up, and a moment from clamp to contact."""
        if term.along == "force":
            given_way = term.share(beam.voltage_V) * term(np.nan_to_num(contact.force_N))
            given_way = np.where(np.isfinite(contact.force_N), given_way, 0.0)
            return replace(beam, shift_m=beam.shift_m + 1e-3 * given_way)
        if term.along == "s":  # the place on the sheet that touches
            moved = 1e-3 * term.share(beam.voltage_V) * term(np.nan_to_num(contact.s_hat_m))
            return replace(beam, reach_m=beam.reach_m + moved)
        if term.along == "position" and term.adds == "moment":
            before = beam.s_m <= np.nan_to_num(contact.s_hat_m)[:, None]
            turned = term.share(beam.voltage_V) * term(np.nan_to_num(beam.stated_m))
            return replace(beam, bend=beam.bend + turned[:, None] * before)
        return self.beam(beam, term)

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        most_mm = AMPLITUDE_MM * at.scale.length
        waves = [cosine_wave(j, most_mm) for j in range(WAVES_ON_ARC)]
        for part, under, count in (
            ("position", "", WAVES_ON_ARC), ("polarity", "polarity", WAVES_ON_ARC), ("zero", "", 1)
        ):  # fmt: skip
            yield from bases_of(
                self, at, waves[:count], along="position", part=part, under=under, shared=True,
                alone=part == "zero",
            )  # fmt: skip
        for part, adds, shows in (
            ("reach", "reach", OFF_ARC),
            ("position and reach", "", ", along the arc, and off it"),
            ("position and reach", "reach", f"{OFF_ARC}, and along it"),
        ):
            yield from bases_of(
                self, at, waves, along="position", part=part, adds=adds, shared=True, alone=True,
                shows=shows,
            )  # fmt: skip
        by_force = [polynomial(degree, most_mm) for degree in DEGREES]
        by_force += [_play(at.forces_N, full_N * at.scale.force, most_mm) for full_N in PLAY_N]
        yield from bases_of(
            self, at, by_force, along="force", part="force", shared=True, alone=True
        )
        yield from self._by_place_on_sheet(at, waves[1:])
        yield from self._settling(at, most_mm)
        for under, count in MOMENTS.items():
            moments = (cosine_wave(j, MOMENT_PER_M / at.scale.length) for j in range(count))
            for one in bases_of(
                self, at, moments, along="position", part="moment", under=under, adds="moment",
                shared=True, alone=True,
            ):  # fmt: skip
                yield replace(one, unit="1/m")

    def _by_place_on_sheet(self, at: Linearised, waves: Sequence[Function]) -> Iterator[Basis]:
        """Return what a roll that runs out does as it is turned, or a sheet that is thicker."""
        end_m = at.beam.sheet.free_length_m + at.beam.sheet.elongation_m
        for wave in waves:
            term = BasisTerm(along="s", function=wave, low=0.0, high=end_m, adds="reach")
            yield Basis(
                part="reach, by place", along="s", function=wave, unit=self.unit,
                span=(0.0, 1e3 * end_m, "mm"), step=perturbation(self, at, term), term=term,
                alone=True, shows=f", by which place of the sheet is touched{OFF_ARC}",
            )  # fmt: skip

    def _settling(self, at: Linearised, most_mm: float) -> Iterator[Basis]:
        """Return how the load cell moves in the course of each run: a stage that creeps to a stop.

        The readings at 0 V come first, and have the most of it.
        """
        t = np.clip(at.clock.run_s / SPANS_S["run"][0], 0.0, 1.0)
        for j in range(1, WAVES_IN_RUN + 1 if len(t) and np.ptp(t) > 0.0 else 0):
            wave, part = cosine_wave(j, most_mm), "position, run"
            moved = np.bincount(at.reading_of, at.beam.share * wave(t), len(at.beam.voltage_V))
            other = replace(at.beam, shift_m=at.beam.shift_m + 1e-3 * moved)
            yield Basis(
                part=part, along="time", function=wave, unit=self.unit, span=time_span(part),
                step=beam_step(at, other), shared=True, alone=True,
            )  # fmt: skip


def _play(forces_N: tuple[float, float], full_N: float, most_mm: float) -> Function:
    """Return how far the force moves what has play, mm; 0 .. 1 of the range of the force."""
    low, high = forces_N

    def value(t: FloatArray) -> FloatArray:
        return np.asarray(most_mm * np.tanh((low + t * (high - low)) / full_N))

    return value


LOCATION = Position(
    name="position",
    meaning="where and how the sheet is touched",
    depends="goes with the position on the arc",
    unit="mm",
    order=50,
)
