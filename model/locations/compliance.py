"""The bending compliance of the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import bases_of, cosine_wave, perturbation, waves_along_sheet
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution
from model.measurements import FloatArray

AMPLITUDE = 0.3  # relative
WAVES_UNDER_VOLTAGE = 3  # along the sheet, of what is there under voltage only
BENT_PER_M = 30.0  # bending at which a compliance that goes with it has changed by AMPLITUDE


@dataclass(frozen=True, kw_only=True)
class Compliance(Location):
    """A relative change of the compliance along the sheet, or with the bending."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.along != "s":
            return beam
        share = term.share(beam.voltage_V)[:, None]
        return replace(beam, soft=beam.soft * (1.0 + share * term(beam.s_m)))

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """See `Location.bent`."""
        if term.along != "curvature":
            return self.beam(beam, term)
        return replace(
            beam, soft=beam.soft * (1.0 + term(np.abs(contact.curvature - contact.at_rest)))
        )

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = [cosine_wave(j, AMPLITUDE) for j in range(waves_along_sheet(at))]
        yield from bases_of(self, at, waves, along="s", part="s")
        few = waves[:WAVES_UNDER_VOLTAGE]
        yield from bases_of(self, at, few, along="s", part="voltage", under="voltage")
        most = float(np.max(np.abs(at.contact.curvature - at.initial_curvature_per_m)))
        for power in (1, 2):
            function = _power(most / BENT_PER_M, power)
            term = BasisTerm(
                along="curvature", function=function, low=0.0, high=max(most, BENT_PER_M * 1e-9)
            )
            yield Basis(
                part="curvature", along="curvature", function=None, unit=self.unit,
                span=(0.0, 1e3 * at.beam.sheet.free_length_m, "mm"),
                step=perturbation(self, at, term), term=term,
            )  # fmt: skip


def _power(most: float, power: int) -> Function:
    """Return what a compliance changes by that goes with the bending, 0 .. 1 of the largest."""

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = AMPLITUDE * (most * t) ** power
        return result

    return value


LOCATION = Compliance(
    name="compliance",
    meaning="what gives way",
    depends="in proportion to the moment, at all voltages",
    unit="relative",
    order=40,
)
