"""The initial curvature of the sheet."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import bases_of, cosine_wave, perturbation, power, waves_along_sheet
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import BeamProblem, ContactSolution, ImagePoints
from model.measurements import FloatArray

AMPLITUDE_PER_M = 5.0
KINK_RAD = 5e-2
BOW_MM, BOWS = 1.0, (1, 2, 3)  # of the elongation at its end, by powers of the place on it
KINK_WIDTH = 0.02  # of the free length, over which a kink is drawn


@dataclass(frozen=True, kw_only=True)
class RestCurvature(Location):
    """A curvature along the sheet, a kink at the clamp, and an elongation that is not straight."""

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.along == "clamp":
            return replace(beam, tilt_rad=beam.tilt_rad + term(np.zeros_like(beam.tilt_rad)))
        if term.along != "s" or term.adds == "bow":
            return beam
        return replace(beam, rest=beam.rest + term.share(beam.voltage_V)[:, None] * term(beam.s_m))

    def bent(self, beam: BeamProblem, contact: ContactSolution, term: Term) -> BeamProblem:
        """See `Location.bent`: the load cell touches the elongation where it is."""
        if term.adds != "bow":
            return self.beam(beam, term)
        off = _bow_m(term, np.nan_to_num(contact.s_hat_m), beam.sheet.free_length_m)
        return replace(beam, offset_m=beam.offset_m + off)

    def curve(self, points: ImagePoints, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """See `Location.curve`: the picture shows the elongation as it is."""
        if term.adds != "bow":
            return None
        off = _bow_m(term, points.s_m, points.free_length_m)
        return off * points.normal_x, off * points.normal_y

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = (
            cosine_wave(j, AMPLITUDE_PER_M / at.scale.length) for j in range(waves_along_sheet(at))
        )
        yield from bases_of(self, at, waves, along="s", part="s")
        yield from self._elongation(at)
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

    def _elongation(self, at: Linearised) -> Iterator[Basis]:
        """Return bows of the elongation, which is the same in all that is measured of its sheet."""
        begin, length_m = at.beam.sheet.free_length_m, at.beam.sheet.elongation_m
        if not length_m:
            return
        for number in BOWS:
            function = power(number, BOW_MM * at.scale.length)
            term = BasisTerm(
                along="s", function=function, low=begin, high=begin + length_m, adds="bow"
            )
            yield Basis(
                part="elongation", along="s", function=function, unit="mm",
                span=(1e3 * begin, 1e3 * (begin + length_m), "mm"),
                step=perturbation(self, at, term), term=term, alone=True,
                shows=", a bow of the elongation",
            )  # fmt: skip


def _bow_m(term: Term, s_m: FloatArray, free_length_m: float) -> FloatArray:
    """Return how far the elongation is off its straight line at places along sheet and it, m."""
    return np.where(s_m > free_length_m, 1e-3 * term(s_m), 0.0)


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
