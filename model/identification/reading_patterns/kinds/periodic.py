"""A periodic term in the readings: of the force that the load cell reads, or of the EIBM.

Readings are looked at by their means and slow trends; what swings faster would only make them look
noisy. A period and a phase that explain most of what the trends leave of all readings at once, of
their forces or of how far out their curves are, are no noise, nor a wander, which keeps no time.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import product
from typing import Literal, get_args

import numpy as np

from model.identification.data.data_vector import TRENDS, ConditionData, DataVector, trends
from model.identification.reading_patterns.contract import ReadingPattern, ReadingsOf
from model.locations.basis import sinusoids
from model.locations.contract import Basis, Function, Linearised
from model.locations.quantities import AcquisitionTimes, Perturbation
from model.measurements import Curve, FloatArray, RigScale

What = Literal["force", "EIBM"]
Since = Literal["run", "worked", "session"]
LONGEST_S, SHORTEST_S = 12.0, 1.25  # slower is a trend; quicker looks like a slower one
MOST = 0.8  # share of what the trends leave that a wave must explain
LEAST_N = 1e-4  # amplitude in the forces: a load cell's wander may be a smaller wave by itself
FEWEST = 40  # numbers in which it is looked for
FINE, MOST_TRIED = 3, 10_000  # rates tried for each that the readings can tell apart, and in all
NEAR = 41  # tried once more about the best one
MORE = 0.01  # of the share that another clock must explain more
RELATIVE, FORCE_MN = 0.1, 2.0  # amplitudes of the basis shapes


def cosine(phase: FloatArray) -> FloatArray:
    """Of a phase in periods."""
    return np.asarray(np.cos(2.0 * np.pi * phase))


def sine(phase: FloatArray) -> FloatArray:
    """Of a phase in periods."""
    return np.asarray(np.sin(2.0 * np.pi * phase))


def cosines_and_sines(at_s: FloatArray, rates: FloatArray) -> tuple[FloatArray, FloatArray]:
    """Return cosines and sines (n, m) of times (n,) at evenly spaced rates (m,), 1/s.

    As products of a coarse and a fine table of exp(i phase), which has few sines to work out.
    """
    fine = max(1, round(len(rates) ** 0.5))
    step = rates[1] - rates[0] if len(rates) > 1 else 0.0
    coarse = np.exp(2j * np.pi * at_s[:, None] * rates[::fine])
    table = np.exp(2j * np.pi * at_s[:, None] * (step * np.arange(fine)))
    product = (coarse[:, :, None] * table[:, None, :]).reshape(len(at_s), -1)[:, : len(rates)]
    return product.real, product.imag


@dataclass(frozen=True, kw_only=True)
class PeriodicTerm:
    """A periodic term of all readings, always in the same phase."""

    what: What  # adds to the force, or to the EIBM in proportion to it
    period_s: float
    since: Since  # anew in each run, or on through the session, or through its time under voltage
    session_s: float  # length of the session
    amplitudes: tuple[float, float]  # of cosine and sine: N, or relative

    def phase(self, clock: AcquisitionTimes) -> FloatArray:
        """In periods: (n,)."""
        return _seconds(clock, self.since, self.session_s) / self.period_s

    @property
    def location(self) -> str:
        """Return where its basis shapes are."""
        return "load_cell" if self.what == "force" else "time"

    def without(self, readings: ReadingsOf) -> FloatArray:
        """Return the forces without what it adds to them; one of the EIBM is left in: (n,) N."""
        if self.what != "force":
            return readings.force_N
        phase = self.phase(readings.clock)
        a, b = self.amplitudes
        return np.asarray(readings.force_N - (a * cosine(phase) + b * sine(phase)))

    def bases(self, at: Linearised) -> Iterator[Basis]:
        """Return a cosine and a sine of the phase."""
        amplitude = FORCE_MN * at.scale.force if self.what == "force" else RELATIVE
        for wave in sinusoids(amplitude):
            yield Basis(
                part=f"{self.what}, period", along="time", function=wave,
                unit="mN" if self.what == "force" else "relative",
                span=(0.0, self.period_s, f"s into the period of {self.period_s:.3g} s"),
                step=self._step(at, wave), shared=True,
            )  # fmt: skip

    def _step(self, at: Linearised, wave: Function) -> Perturbation:
        """Return what a function of the phase changes."""
        values = wave(self.phase(at.clock))
        if self.what == "force":
            return replace(at.nothing(), force_N=1e-3 * values)
        parts, sample = wave(self.phase(at.bin_clock)), wave(self.phase(at.bin_sample))
        return replace(
            at.nothing(), eibm=values * (at.clock.voltage_V != 0.0),
            bin_eibm=at.bin_mean(parts) - at.bin_mean(sample),
        )  # fmt: skip

    def in_other_data(self, data_vectors: Sequence[DataVector]) -> PeriodicTerm:  # noqa: ARG002
        """Return itself: it goes with the clock."""
        return self


@dataclass(frozen=True, kw_only=True)
class _Series:
    """A number of each reading, of all conditions that have more of them than trends."""

    values: FloatArray  # (n,) N, or m times the root of a curve's points
    clock: AcquisitionTimes
    lever: FloatArray  # (n,) how much of the values the EIBM makes
    trends: tuple[FloatArray, ...]  # of each condition (rows, own readings), orthonormal
    session_s: float
    least: float  # amplitude of a wave in the values that counts

    @staticmethod
    def of(
        found: Sequence[tuple[ConditionData, FloatArray, float]],
        session_s: float,
        least: float = 0.0,
    ) -> _Series | None:
        """Of conditions with their numbers and levers; None: too few, or not measured yet."""
        T = [_orthonormal(one.kept_clock) for one, _, _ in found]
        few = sum(rows.shape[1] - len(rows) for rows in T) < FEWEST
        if few or not any(np.any(values) for _, values, _ in found):
            return None
        levers = [np.full(len(values), lever) for _, values, lever in found]
        return _Series(
            values=np.concatenate([values for _, values, _ in found]),
            clock=AcquisitionTimes.joined([one.kept_clock for one, _, _ in found]),
            lever=np.concatenate(levers), trends=tuple(T), session_s=session_s, least=least,
        )  # fmt: skip

    def left(self, values: FloatArray) -> FloatArray:
        """Return values (n, ...) with their trends removed."""
        result, start = values.copy(), 0
        for T in self.trends:
            own = slice(start, start + T.shape[1])
            result[own] -= T.T @ (T @ values[own])
            start = own.stop
        return result

    def best(self, what: What, since: Since) -> tuple[PeriodicTerm, float] | None:
        """Return the wave that explains most of the detrended values, and the share it explains."""
        at_s = _seconds(self.clock, since, self.session_s)
        rates = _rates(float(np.ptp(at_s)))
        if not len(rates):
            return None
        lever = self.lever if what == "EIBM" else np.ones(len(at_s))
        i = int(np.argmax(self._fitted(lever, at_s, rates)[2]))
        near = rates[i] + np.linspace(-1.0, 1.0, NEAR) * (rates[1] - rates[0])
        near = near[near > 0.0]
        a, b, share = self._fitted(lever, at_s, near)
        i = int(np.argmax(share))
        amplitudes = float(a[i]), float(b[i])
        if np.hypot(*amplitudes) * np.sqrt(np.mean(lever**2)) < self.least:
            return None
        return PeriodicTerm(
            what=what,
            period_s=float(1.0 / near[i]),
            since=since,
            session_s=self.session_s,
            amplitudes=amplitudes,
        ), float(share[i])

    def _fitted(
        self, lever: FloatArray, at_s: FloatArray, rates: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Amplitudes of cosine and sine at each rate (evenly spaced, 1/s), and what they explain.

        That is a share of all.
        """
        y = self.left(self.values)
        c, s = (self.left(lever[:, None] * wave) for wave in cosines_and_sines(at_s, rates))
        # of each rate, two normal equations by hand
        cc, ss, cs, cy, sy = np.sum(c * c, 0), np.sum(s * s, 0), np.sum(c * s, 0), y @ c, y @ s
        det = cc * ss - cs**2
        det = np.where(det > 1e-6 * cc * ss, det, np.inf)
        a, b = (ss * cy - cs * sy) / det, (cc * sy - cs * cy) / det
        return a, b, (a * cy + b * sy) / max(float(y @ y), 1e-300)


def periodic_term_in(
    data_vectors: Sequence[DataVector], least_N: float = LEAST_N
) -> PeriodicTerm | None:
    """Return the periodic term that explains most of the detrended readings, or None.

    `least_N`: amplitude in the forces of which it has to be.
    """
    session_s = max(data_vector.session_s for data_vector in data_vectors)
    forces = _Series.of(
        [x for data_vector in data_vectors for x in _forces(data_vector)], session_s, least_N
    )
    curves = _Series.of(
        [x for data_vector in data_vectors for x in _curves(data_vector)], session_s
    )
    kinds: list[tuple[_Series | None, What]]
    kinds = [(forces, "force"), (forces, "EIBM"), (curves, "EIBM")]
    best, most = None, MOST
    for (series, what), since in product(kinds, get_args(Since)):
        found = None if series is None else series.best(what, since)
        if found is not None and found[1] > most:
            best, most = found[0], found[1] + MORE
    return best


def _forces(data_vector: DataVector) -> Iterator[tuple[ConditionData, FloatArray, float]]:
    """Of each condition that is repeated; the EIBM makes what the force is more than at 0 V."""
    for one, rest in _with_rest(data_vector):
        known = one.voltage_V != 0.0 and rest is not None and len(rest.kept_N) > 0
        at_rest_N = np.mean(rest.kept_N) if known and rest is not None else np.mean(one.kept_N)
        yield one, one.kept_N, float(np.mean(one.kept_N) - at_rest_N)


def _curves(data_vector: DataVector) -> Iterator[tuple[ConditionData, FloatArray, float]]:
    """How far each reading's curve is from the mean one, the way that this is from that at 0 V."""
    for one, rest in _with_rest(data_vector):
        own = one.own_curves[-len(one.kept_N) :]
        if not own or not one.voltage_V or rest is None or rest.curve is None or one.curve is None:
            continue
        n = min(len(own[0].s_m), len(rest.curve.s_m), len(one.curve.s_m))
        mean, still = _points(one.curve, n), _points(rest.curve, n)
        reach = float(np.linalg.norm(mean - still))
        way = (mean - still) / max(reach, 1e-12)
        yield one, np.array([(_points(c, n) - mean) @ way for c in own]), reach


def _with_rest(data_vector: DataVector) -> Iterator[tuple[ConditionData, ConditionData | None]]:
    """Conditions that are repeated more often than there are trends, with their run's at 0 V."""
    rest = {one.run: one for one in data_vector.seen if not one.voltage_V and not one.zero}
    for one in data_vector.seen:
        if not one.free and len(one.kept_N) > TRENDS:
            yield one, rest.get(one.run)


def _points(curve: Curve, n: int) -> FloatArray:
    """Return x, then y, of the first n points."""
    return np.concatenate([curve.x_m[:n], curve.y_m[:n]])


def _orthonormal(clock: AcquisitionTimes) -> FloatArray:
    """Trends in time, the mean among them: (rows, n)."""
    T = trends(clock)
    T[0] *= np.sqrt(T.shape[1])
    return T


def _seconds(clock: AcquisitionTimes, since: Since, session_s: float) -> FloatArray:
    """Return the acquisition times of readings, s."""
    if since == "session":
        return clock.session * session_s
    return np.asarray(clock.run_s if since == "run" else clock.worked_s, dtype=float)


def _rates(span_s: float) -> FloatArray:
    """Inverse periods to try in readings over so long a time, evenly spaced (1/s)."""
    fastest, slowest = 1.0 / SHORTEST_S, 1.0 / LONGEST_S
    count = int(np.ceil((fastest - slowest) * span_s * FINE))
    return np.linspace(slowest, fastest, count) if 2 <= count <= MOST_TRIED else np.zeros(0)


@dataclass(frozen=True, kw_only=True)
class Periodic(ReadingPattern):
    """A wave of the forces, or of the EIBM."""

    def found_in(self, data_vectors: Sequence[DataVector], scale: RigScale) -> PeriodicTerm | None:
        """See `ReadingPattern.found_in`."""
        return periodic_term_in(data_vectors, LEAST_N * scale.force)


PATTERN = Periodic(name="periodic", meaning="a wave that is always in the same phase", order=10)
