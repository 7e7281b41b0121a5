"""Time: how things go along the session, the run, the pulse."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from model.locations.basis import (
    SPANS_S,
    beam_step,
    cosine_wave,
    decay,
    time_span,
)
from model.locations.contract import Basis, BasisTerm, Function, Linearised, Location, Term
from model.locations.quantities import (
    AcquisitionTimes,
    BeamProblem,
    LoadCellInput,
    Perturbation,
)
from model.measurements import FloatArray
from model.measurements.pulse_train import PULSES

AMPLITUDE = 0.1  # relative
FORCE_MN, TURN_RAD, CURL_PER_M = 2.0, 0.3, 30.0  # times AMPLITUDE
WAVES = {"session": 8, "run": 3}
DECAYS_PULSES = (1.0, 3.0, 9.0)  # to 1/e, of the train's
WAVES_IN_PULSE = 3
# coordinates of terms; what goes with the pulse or a period is in no mean
ALONG = {"session": "session", "run": "run", "train": "driven"}


@dataclass(frozen=True, kw_only=True)
class Time(Location):
    """Courses of EIBM, stiffness, force or clamp.

    They concern single readings; a prediction of a condition has their mean, amid a session.
    """

    def course(self, clock: AcquisitionTimes, term: Term) -> tuple[FloatArray, FloatArray] | None:
        """See `Location.course`."""
        times = {"session": clock.session, "run": clock.run_s, "driven": clock.driven_s}
        if term.along not in times or term.adds not in ("EIBM", "stiffness"):
            return None
        values = term.share(clock.voltage_V) * term(np.asarray(times[term.along]))
        none = np.zeros(clock.voltage_V.shape)
        return (values, none) if term.adds == "EIBM" else (none, values)

    def beam(self, beam: BeamProblem, term: Term) -> BeamProblem:
        """See `Location.beam`."""
        if term.adds not in ("clamp", "curvature"):
            return beam
        count, session = len(beam.voltage_V), beam.share * beam.clock.session
        at = np.asarray(np.bincount(beam.reading_of, session, count), dtype=float)
        if term.adds == "curvature":
            return replace(beam, rest=beam.rest + term(at)[:, None])
        return replace(beam, tilt_rad=beam.tilt_rad + term(at))

    def force(self, weighed: LoadCellInput, term: Term) -> FloatArray | None:
        """See `Location.force`."""
        if term.along != "run" or term.adds not in ("force", "stress"):
            return None
        values = term(np.broadcast_to(weighed.run_s, weighed.force_N.shape))
        if term.adds == "force":
            return np.asarray(1e-3 * values)
        return np.asarray(_force_at_0V_N(weighed) * values)

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """See `Location.bases`."""
        for during, values in (("session", at.clock.session), ("run", at.clock.run_s)):
            t = np.clip(values / SPANS_S[during][0], 0.0, 1.0)
            if len(t) and np.ptp(t) > 0.0:
                for j in range(1, WAVES[during] + 1):
                    yield from self._slow(at, cosine_wave(j, AMPLITUDE), t, during)
        yield from self._train(at)
        yield from self._pulse(at)

    def _slow(self, at: Linearised, wave: Function, t: FloatArray, during: str) -> Iterator[Basis]:
        course, nothing = wave(t), at.nothing
        yield self._basis(wave, f"EIBM, {during}", replace(nothing(), eibm=course * _on(at)))
        yield self._basis(wave, f"stiffness, {during}", replace(nothing(), stiffness=course))
        if during == "session":
            yield from self._set_up(at, wave)
            return
        force_mN = FORCE_MN * at.scale.force
        force = replace(nothing(), force_N=1e-3 * force_mN * course)
        yield self._basis(_times(force_mN, wave), f"force, {during}", force, "mN")
        stress = replace(nothing(), force_N=at.force_at_0V_N[at.reading_of] * course)
        yield self._basis(wave, f"stress, {during}", stress)

    def _set_up(self, at: Linearised, wave: Function) -> Iterator[Basis]:
        """Return a course of the clamp, and of the initial curvature: a sheet that dries curls."""
        course = wave(at.measured_at)
        tilted = replace(at.beam, tilt_rad=at.beam.tilt_rad + TURN_RAD * course)
        step = beam_step(at, tilted)
        yield self._basis(_times(TURN_RAD, wave), "clamp, session", step, "rad")
        per_m = CURL_PER_M / at.scale.length
        curled = replace(at.beam, rest=at.beam.rest + per_m * course[:, None])
        one = self._basis(_times(per_m, wave), "curvature, session", beam_step(at, curled), "1/m")
        yield replace(one, alone=True)

    def _train(self, at: Linearised) -> Iterator[Basis]:
        """Return what goes with the time under voltage: of the EIBM, of one polarity, of B."""
        for pulses in DECAYS_PULSES:
            wave = decay(pulses / PULSES, AMPLITUDE)

            def course(clock: AcquisitionTimes, wave: Function = wave) -> FloatArray:
                t = np.clip(clock.driven_s / SPANS_S["train"][0], 0.0, 1.0)
                return np.asarray(wave(t) * (clock.voltage_V != 0.0))

            def polar(
                clock: AcquisitionTimes, course: Callable[..., FloatArray] = course
            ) -> FloatArray:
                return np.asarray(course(clock) * np.sign(clock.voltage_V))

            for of_time, under in ((course, ""), (polar, "polarity")):
                step = replace(
                    at.nothing(), eibm=of_time(at.clock), bin_eibm=_within_pulse(at, of_time)
                )
                yield self._basis(wave, "EIBM, train", step, under=under)
            step = replace(
                at.nothing(), stiffness=course(at.clock), bin_stiffness=_within_pulse(at, course)
            )
            yield self._basis(wave, "stiffness, train", step, under="voltage")

    def _pulse(self, at: Linearised) -> Iterator[Basis]:
        t = np.clip(at.bin_clock.pulse_s / SPANS_S["pulse"][0], 0.0, 1.0)
        for j in range(WAVES_IN_PULSE):
            wave = cosine_wave(j, AMPLITUDE)
            step = replace(at.nothing(), bin_eibm=at.bin_mean(wave(t)))
            yield self._basis(wave, "EIBM, pulse", step)

    def _basis(
        self, function: Function, part: str, step: Perturbation, unit: str = "",
        under: str = "",
    ) -> Basis:  # fmt: skip
        adds, _, during = part.partition(", ")
        span, along = time_span(part), ALONG.get(during)
        term = along and BasisTerm(
            along=along, function=function, low=0.0, high=span[1], adds=adds, under=under
        )
        return Basis(
            part=part, along="time", function=function, unit=unit or self.unit, span=span,
            step=step, shared=True, term=term or None,
        )  # fmt: skip


def _within_pulse(at: Linearised, course: Callable[[AcquisitionTimes], FloatArray]) -> FloatArray:
    """Return a course in the parts of the pulses, less that at the sampling points: (b,)."""
    return np.asarray(at.bin_mean(course(at.bin_clock)) - at.bin_mean(course(at.bin_sample)))


def _force_at_0V_N(weighed: LoadCellInput) -> FloatArray:
    """Return the mean force at 0 V at the position of each reading."""
    result = np.zeros_like(weighed.force_N)
    for at in np.unique(weighed.position_m):
        own = weighed.position_m == at
        at_rest = weighed.force_N[own & (weighed.voltage_V == 0.0)]
        result[own] = np.mean(at_rest) if len(at_rest) else 0.0
    return result


def _on(at: Linearised) -> FloatArray:
    """Return 1 for the readings under voltage, else 0."""
    return np.asarray(at.clock.voltage_V != 0.0, dtype=float)


def _times(factor: float, function: Function) -> Function:
    def value(t: FloatArray) -> FloatArray:
        return factor * function(t)

    return value


LOCATION = Time(
    name="time",
    meaning="time",
    depends="goes with time",
    unit="relative",
    order=80,
    in_time=True,
)
