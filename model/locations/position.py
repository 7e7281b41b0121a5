"""The place on the arc where the load cell touches the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import bases_of, cosine_wave
from model.locations.contract import Basis, Linearised, Location, Term
from model.locations.quantities import BeamProblem

AMPLITUDE_MM = 1.0
WAVES_ON_ARC = 7  # one for each position of the paper: a screw's error may be anything


@dataclass(frozen=True, kw_only=True)
class Position(Location):
    """An error of the position, from position to position."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.along != "position":
            return beam
        on_arc = term.share(beam.voltage_V) * term(np.nan_to_num(beam.stated_m))
        return replace(beam, shift_m=beam.shift_m + 1e-3 * on_arc)

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = [cosine_wave(j, AMPLITUDE_MM) for j in range(WAVES_ON_ARC)]
        for part, under, count in (
            ("position", "", WAVES_ON_ARC), ("polarity", "polarity", WAVES_ON_ARC), ("zero", "", 1)
        ):  # fmt: skip
            yield from bases_of(
                self, at, waves[:count], along="position", part=part, under=under, shared=True
            )


LOCATION = Position(
    name="position",
    meaning="where and how the sheet is touched",
    depends="goes with the position on the arc",
    unit="mm",
    order=50,
)
