"""The initial curvature of the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import bases_of, cosine_wave, perturbation, waves_along_sheet
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import BeamProblem
from model.measurements import FloatArray

AMPLITUDE_PER_M = 5.0
KINK_RAD = 5e-2
KINK_WIDTH = 0.02  # of the free length, over which a kink is drawn


@dataclass(frozen=True, kw_only=True)
class RestCurvature(Location):
    """A curvature along the sheet, and a kink at the clamp, which is one of zero length."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.along == "clamp":
            return replace(beam, tilt_rad=beam.tilt_rad + term(np.zeros_like(beam.tilt_rad)))
        if term.along != "s":
            return beam
        return replace(beam, rest=beam.rest + term.share(beam.voltage_V)[:, None] * term(beam.s_m))

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = (
            cosine_wave(j, AMPLITUDE_PER_M / at.scale.length) for j in range(waves_along_sheet(at))
        )
        yield from bases_of(self, at, waves, along="s", part="s")
        length_m = at.beam.sheet.free_length_m
        turned = BasisTerm(
            along="clamp", function=lambda t: np.full_like(t, KINK_RAD), low=0.0, high=1.0, nodes=1
        )
        for part in ("s", "clamp"):
            yield Basis(
                part=part, along="s", function=_kink(length_m), unit=self.unit,
                span=(0.0, 1e3 * length_m, "mm"), step=perturbation(self, at, turned),
                term=turned, alone=part == "clamp",
            )  # fmt: skip


def _kink(length_m: float) -> Function:
    """Return the kink as the curvature of a short piece."""
    area = 0.5 * np.sqrt(np.pi) * KINK_WIDTH * length_m

    def value(t: FloatArray) -> FloatArray:
        result: FloatArray = KINK_RAD / area * np.exp(-((t / KINK_WIDTH) ** 2))
        return result

    return value


LOCATION = RestCurvature(
    name="rest_curvature",
    meaning="the curvature at rest",
    depends="the same at all voltages and positions",
    unit="1/m",
    order=10,
)
