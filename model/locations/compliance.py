"""The bending compliance of the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    EACH_POLARITY,
    bases_of,
    bending_along,
    bending_bases,
    cosine_wave,
    perturbation,
    power,
    waves_along_sheet,
)
from model.locations.contract import Basis, BasisTerm, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution

AMPLITUDE = 0.3  # relative
WAVES_UNDER_VOLTAGE = 3  # along the sheet, of what is there under voltage only
POWERS, POWERS_UNDER_VOLTAGE = (1, 2, 4, 8), (0, 1, 2)  # of the bending, over the largest
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
        bending = bending_along(term.along, contact)
        if bending is None:
            return self.beam(beam, term)
        share = term.share(beam.voltage_V)[:, None]
        return replace(beam, soft=beam.soft * (1.0 + share * term(bending)))

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = [cosine_wave(j, AMPLITUDE) for j in range(waves_along_sheet(at))]
        yield from bases_of(self, at, waves, along="s", part="s")
        few = waves[:WAVES_UNDER_VOLTAGE]
        yield from bases_of(self, at, few, along="s", part="voltage", under="voltage")
        most = float(np.max(np.abs(at.contact.curvature - at.initial_curvature_per_m)))
        bent_per_m = BENT_PER_M / at.scale.length
        for number in (1, 2):
            function = power(number, AMPLITUDE * (most / bent_per_m) ** number)
            term = BasisTerm(
                along="curvature", function=function, low=0.0, high=max(most, bent_per_m * 1e-9)
            )
            yield Basis(
                part="curvature", along="curvature", function=None, unit=self.unit,
                span=(0.0, 1e3 * at.beam.sheet.free_length_m, "mm"),
                step=perturbation(self, at, term), term=term,
            )  # fmt: skip
        for part, under, powers in (
            ("bending", "", POWERS), ("bending, voltage", "voltage", POWERS_UNDER_VOLTAGE)
        ):  # fmt: skip
            functions = [power(number, AMPLITUDE) for number in powers]
            yield from bases_of(
                self, at, functions, along="curvature", part=part, under=under, shared=True,
                alone=True,
            )  # fmt: skip
        for under in ("voltage", "polarity"):  # together they are anything at either polarity
            yield from bases_of(
                self, at, few, along="s", part=EACH_POLARITY, under=under, alone=True
            )
        yield from bending_bases(self, at, AMPLITUDE)


LOCATION = Compliance(
    name="compliance",
    meaning="what gives way",
    depends="in proportion to the moment, at all voltages",
    unit="relative",
    order=40,
)
