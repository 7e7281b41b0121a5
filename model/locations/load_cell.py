"""The load cell: what it adds to the force."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    bases_of,
    cosine_wave,
    perturbation,
    polynomial,
    time_span,
)
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import LoadCellInput
from model.measurements import FloatArray

AMPLITUDE_MN = 0.2
GAIN = 0.1  # relative
DEGREES = range(6)  # of the force: a curve of response may have a zero of its own
WAVES_IN_SESSION = 8
WAVES_OF_GAIN = 5  # from position to position: the same everywhere is the sheet's stiffness


@dataclass(frozen=True, kw_only=True)
class LoadCell(Location):
    """A force that is added where the sheet touches, from position to position or by the force."""

    def force(self, weighed: LoadCellInput, term: Term) -> FloatArray | None:
        """See `Location.force`."""
        places = {
            "position": weighed.position_m, "force": weighed.force_N, "session": weighed.session
        }  # fmt: skip
        if term.along == "configuration":
            return np.asarray(1e-3 * term(np.zeros_like(weighed.force_N)))
        at = places.get(term.along)
        if at is None:
            return None
        if term.adds == "gain":
            return np.asarray(term(at) * weighed.force_N)
        acting = term.share(weighed.voltage_V)
        if term.along != "session":  # the load cell's own zero wanders without contact, too
            acting = acting * weighed.touching
        return np.asarray(1e-3 * term(at) * acting)

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        waves = [cosine_wave(j, AMPLITUDE_MN * at.scale.force) for j in range(7)]
        for part, under, count, shared in (
            ("position", "", 7, True), ("position, each sheet", "", 5, False),
            ("polarity", "polarity", 3, True), ("voltage", "voltage", 3, True),
        ):  # fmt: skip
            yield from bases_of(
                self, at, waves[:count], along="position", part=part, under=under, shared=shared
            )
        gain = (cosine_wave(j, GAIN) for j in range(1, WAVES_OF_GAIN + 1))
        for one in bases_of(
            self, at, gain, along="position", part="gain", adds="gain", shared=True, alone=True,
            shows=", the gain from position to position",
        ):  # fmt: skip
            yield replace(one, unit="relative")
        zero = np.full_like(at.weighed.force_N, waves[0](np.array(0.0)))
        constant = BasisTerm(along="configuration", function=waves[0], low=0.0, high=1.0, nodes=1)
        yield self._added(
            at, waves[0], zero, part="zero", along="position", term=constant, alone=True
        )
        for degree in DEGREES:
            power = polynomial(degree, AMPLITUDE_MN * at.scale.force)
            yield from bases_of(
                self, at, [power], along="force", part="force", shared=True,
                alone=degree == 0,  # of the whole it is a wave of the position
            )  # fmt: skip
        yield from self._in_time(at)

    def _in_time(self, at: Linearised) -> Iterator[Basis]:
        session = at.clock.session
        for j in range(1, WAVES_IN_SESSION + 1 if len(session) and np.ptp(session) > 0.0 else 0):
            wave = cosine_wave(j, AMPLITUDE_MN * at.scale.force)
            yield self._added(
                at, wave, wave(session), part="zero, session", along="time",
                term=BasisTerm(along="session", function=wave, low=0.0, high=1.0),
            )  # fmt: skip
            gain = BasisTerm(
                along="session", function=cosine_wave(j, GAIN), low=0.0, high=1.0, adds="gain"
            )
            yield Basis(
                part="gain, session", along="time", function=gain.function, unit="relative",
                span=time_span("gain, session"), step=perturbation(self, at, gain),
                shared=True, term=gain, alone=True,
            )  # fmt: skip

    def _added(
        self, at: Linearised, function: Function, added_mN: FloatArray, *, part: str, along: str,
        term: BasisTerm | None = None, alone: bool = False,
    ) -> Basis:  # fmt: skip
        """Return a force that is added to every reading, without contact, too."""
        step = at.nothing()
        step.force_N = 1e-3 * added_mN
        low, high = at.positions_m
        span = (1e3 * low, 1e3 * high, "mm") if along == "position" else time_span(part)
        return Basis(
            part=part, along=along, function=function, unit=self.unit, span=span, step=step,
            shared=True, term=term, alone=alone,
        )  # fmt: skip


LOCATION = LoadCell(
    name="load_cell",
    meaning="the load cell",
    depends="in the force alone, not in the shapes",
    unit="mN",
    order=60,
)
