"""The electrically induced bending moment along the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    bases_of,
    bending_along,
    bending_bases,
    cosine_wave,
    power,
    waves_along_sheet,
)
from model.locations.contract import Basis, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution

AMPLITUDE_ON_ARC = 0.1  # relative
WAVES_ON_ARC = 4
AMPLITUDE_BENT = 0.3  # relative, where the sheet is bent most
POWERS = (1, 2)  # of the bending


@dataclass(frozen=True, kw_only=True)
class Eibm(Location):
    """A relative change of the EIBM, along the sheet, with the bending or the position."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        share = term.share(beam.voltage_V)
        if term.along == "s":
            return replace(beam, eibm=beam.eibm * (1.0 + share[:, None] * term(beam.s_m)))
        if term.along == "position":
            on_arc = share * term(np.nan_to_num(beam.stated_m))
            return replace(beam, eibm=beam.eibm * (1.0 + on_arc[:, None]))
        return beam

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """See `Location.bent`."""
        bending = bending_along(term.along, contact)
        if bending is None:
            return self.beam(beam, term)
        share = term.share(beam.voltage_V)[:, None]
        return replace(beam, eibm=beam.eibm * (1.0 + share * term(bending)))

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        along_sheet = (cosine_wave(j) for j in range(1, waves_along_sheet(at)))
        yield from bases_of(self, at, along_sheet, along="s", part="s")
        on_arc = (cosine_wave(j, AMPLITUDE_ON_ARC) for j in range(1, WAVES_ON_ARC + 1))
        for one in bases_of(self, at, on_arc, along="position", part="position"):
            # a sheet knows nothing of the load cell's place: it was so when it stood there
            yield replace(one, term=None)
        by_bending = (power(number, AMPLITUDE_BENT) for number in POWERS)
        yield from bases_of(
            self, at, by_bending, along="curvature", part="curvature", shared=True, alone=True
        )
        yield from bending_bases(self, at, AMPLITUDE_BENT)


LOCATION = Eibm(
    name="eibm",
    meaning="the EIBM along the sheet",
    depends="in proportion to the EIBM, so it changes sign with the voltage",
    unit="relative",
    order=20,
)
