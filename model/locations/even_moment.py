"""A moment that has the same sign at both polarities."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    bases_of,
    bending_per_m,
    cosine_wave,
    power,
    waves_along_sheet,
)
from model.locations.contract import Basis, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution
from model.measurements import FloatArray

AMPLITUDE = 0.3  # of the EIBM
POWERS = (1, 2)  # of the bending


@dataclass(frozen=True, kw_only=True)
class EvenMoment(Location):
    """A moment along the sheet under voltage, relative to the mean size of the EIBM."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        return self._added(beam, term, term(beam.s_m)) if term.along == "s" else beam

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """See `Location.bent`."""
        if term.along != "curvature":
            return self.beam(beam, term)
        return self._added(beam, term, term(bending_per_m(contact)))

    def _added(self, beam: BeamProblem, term: Term, values: FloatArray) -> BeamProblem:
        driven = beam.voltage_V != 0.0
        typical = float(np.mean(np.abs(beam.eibm[driven]))) if np.any(driven) else 0.0
        # the size of the EIBM goes with the voltage already
        volts = beam.voltage_V
        beyond = term.even(volts) / np.where(driven, term.part(volts), 1.0)
        share = typical * driven * term.share(volts) * beyond
        return replace(beam, bend=beam.bend + share[:, None] * values)

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = (cosine_wave(j, AMPLITUDE) for j in range(waves_along_sheet(at)))
        yield from bases_of(self, at, waves, along="s", part="s")
        by_bending = (power(number, AMPLITUDE) for number in POWERS)
        yield from bases_of(
            self, at, by_bending, along="curvature", part="curvature", shared=True, alone=True
        )


LOCATION = EvenMoment(
    name="even_moment",
    meaning="a moment that does not change its sign with the voltage",
    depends="only under voltage, with the same sign at both polarities",
    unit="relative to the EIBM",
    order=30,
)
