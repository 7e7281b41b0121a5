"""What `diagnose` looks at: every condition's readings in time order, its curve, and the pulses.

Ten readings become a few numbers: their mean, and how they go with time (orthonormal polynomials up
to the third degree; what is left of them only says how noisy a reading is). The readings of the
first pulses, which are in no mean, stand for themselves, less that mean. A curve becomes the
coefficients of its distance from the prediction ("modes"). A recorded series becomes the force in
parts of a pulse, relative to the sampling point, averaged over the pulses of a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from model.discrepancy.pulses import BINS_S, SAMPLE_S, parts_of_pulses
from model.effects.interface import Clock
from model.measurements import (
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
    TimeSeries,
)
from model.observations import check_sheet, checked_curve

TRENDS = 4  # the mean, and polynomials in time up to the third degree
PULSE_S = 0.6
AMID = 10.0  # number of a pulse long after the first one
OFF_PULSE, MOST_DISCARDED = 0.1, 6  # of times that count pulses, in pulses
FEWEST_PULSES = 3  # of one polarity, to know how much they scatter
EDGE_STEPS = 0.3  # the uncertainty of an edge's time, in sampling intervals (uniform: 1/sqrt(12))
# configuration, position (inf: free), mounting, run, tilt of the rig
RunKey = tuple[str, float, int, int, float]
Index = npt.NDArray[np.int64]
Which = npt.NDArray[np.bool_]


@dataclass(frozen=True)
class Seen:
    """One condition."""

    name: str
    configuration: str
    run: RunKey
    position_m: float  # NaN: free
    voltage_V: float
    up: float
    force_N: FloatArray  # (n,) readings in time order; none where there is no load cell
    clock: Clock  # of these readings, arrays (n,)
    counts: Which  # (n,) whether a reading is in the mean: not those of the discarded first pulses
    curve: Curve | None  # of the mean image, or the mean of the readings' curves
    # of each reading, or of those that count; empty: not recorded one by one
    own_curves: tuple[Curve, ...]
    identical: bool = False  # the readings were, which no load cell's are
    tilt_rad: float = 0.0  # of the rig about the sheet's long axis

    @property
    def free(self) -> bool:
        """Whether nothing touches the sheet."""
        return bool(np.isnan(self.position_m))

    @property
    def kept_N(self) -> FloatArray:
        """The readings that count."""
        return self.force_N[self.counts]

    @property
    def kept_clock(self) -> Clock:
        """When these were taken."""
        return self.clock.of(self.counts)


@dataclass(frozen=True)
class Pulses:
    """The force in parts of the pulses of one run at one voltage, less that at the sample."""

    configuration: str
    run: RunKey
    condition: int  # index among the configuration's conditions
    middle_s: FloatArray  # (bins,) times in the pulse
    width_s: FloatArray
    force_N: FloatArray  # (bins,) mean over the pulses
    variance_N2: FloatArray  # (bins,) of that mean
    edge_s: float  # how well the edges' times are known


@dataclass(frozen=True)
class Look:
    """One configuration."""

    sheet: SheetGeometry
    seen: tuple[Seen, ...]
    pulses: tuple[Pulses, ...]

    @property
    def voltages_V(self) -> list[float]:
        """Driving voltages, ascending."""
        return sorted({s.voltage_V for s in self.seen if s.voltage_V != 0.0})


def look(measurements: Measurements, configuration: str) -> Look:
    """Everything usable of a configuration; a `ModelError` where there is nothing."""
    sheet = measurements.sheets.get(configuration)
    if sheet is None:
        known = ", ".join(sorted(measurements.sheets)) or "none"
        raise ModelError(f"there is no configuration '{configuration}' (known: {known})")
    check_sheet(sheet)
    every = _told_apart(measurements.conditions)
    own = [c for c in every if c.configuration == configuration]
    if not own:
        raise ModelError(f"configuration '{configuration}' has no conditions: nothing was measured")
    session = _Session.of(every)
    zeros = _first_pulses(own)
    ratio = _opposite_ratio(own)
    begun = min((session.share(c, r) for c in own for r in c.used()), default=0.5)
    found = [_seen(c, sheet, session, zeros, ratio, begun) for c in own]
    seen = tuple(s for s in found if s is not None)
    if not seen:
        reasons = sorted({r.why for c in own for r in c.readings if r.why})
        why = f" ({'; '.join(reasons)})" if reasons else ""
        raise ModelError(f"configuration '{configuration}' has no valid readings at all{why}")
    series = [s for s in measurements.series if s.configuration == configuration]
    pulses = [p for s in series for p in _pulses(s, seen)]
    return Look(sheet, seen, tuple(pulses))


def _told_apart(conditions: Sequence[Condition]) -> list[Condition]:
    """A position approached from above is a run of its own, also where nobody says so."""

    def place(one: Condition) -> tuple[object, ...]:
        return one.configuration, one.position_m, one.mounting, one.run, one.tilt_rad

    below = {place(one) for one in conditions if one.approach != "down"}
    return [
        replace(one, run=one.run + 1) if one.approach == "down" and place(one) in below else one
        for one in conditions
    ]


def _seen(
    condition: Condition,
    sheet: SheetGeometry,
    session: _Session,
    zeros: dict[RunKey, int],
    ratio: float,
    begun: float,
) -> Seen | None:
    """What a condition tells; None: nothing usable. A `ModelError` where a number is not finite.

    Free shapes are taken before the positions, so as the first of these begins, at `begun`.
    """
    at_m, free = condition.position_m, condition.position_m is None
    place = "free" if at_m is None else f"{at_m * 1e3:g} mm"
    name = f"{condition.configuration}, {place}, {condition.voltage_V:+g} V"
    readings = sorted(condition.used(), key=_index)
    if (not free and not readings) or (free and condition.curve is None):
        return None
    if not np.isfinite(condition.voltage_V):
        raise ModelError(f"the voltage of condition {name} is not a finite number")
    identical = not free and len(readings) > 1 and len({r.force_N for r in readings}) == 1
    if identical:  # one reading each, from the middle of them
        readings = readings[len(readings) // 2 :][:1]
    curve, own = _curves(condition, readings, name)
    early = [] if free or identical else _early(condition)
    own = (*_alike([r.curve for r in early], own, name), *own)
    readings = [*early, *readings]
    forces = np.array([] if free else [r.force_N for r in readings])
    if not np.all(np.isfinite(forces)):
        raise ModelError(f"a force of condition {name} is not a finite number; mark it invalid")
    key = run_key(condition)
    timing = _Timing(condition.voltage_V, zeros.get(key, 0), ratio, sheet.rise_time_s)
    return Seen(
        name, condition.configuration, key, np.nan if at_m is None else float(at_m),
        condition.voltage_V, -1.0 if condition.approach == "down" else 1.0, forces,
        timing.of_no_reading(begun)
        if free else timing.of(readings, [session.share(condition, r) for r in readings]),
        np.arange(len(forces)) >= len(early), curve, () if free else own, identical,
        condition.tilt_rad,
    )  # fmt: skip


def _alike(curves: list[Curve | None], others: tuple[Curve, ...], name: str) -> tuple[Curve, ...]:
    """Curves of as many points as the others have; none where one has not."""
    found = tuple(checked_curve(c, name) for c in curves if c is not None)
    lengths = {len(c.s_m) for c in (*found, *others)}
    return found if others and len(found) == len(curves) and len(lengths) == 1 else ()


def _index(reading: Reading) -> int:
    """Readings go by their numbers."""
    return reading.index


def _early(condition: Condition) -> list[Reading]:
    """The valid readings of the discarded first pulses, in time order.

    Without a reading that counts, there is nothing to which they might be compared; what is
    discarded later, such as while a sheet relaxes from a hold, is none of them.
    """
    first = min((r.index for r in condition.used()), default=-1)
    found = [r for r in condition.readings if r.kind == "discarded" and r.valid and r.index < first]
    return sorted(found, key=_index) if condition.voltage_V != 0.0 else []


def _curves(
    condition: Condition, readings: list[Reading], name: str
) -> tuple[Curve | None, tuple[Curve, ...]]:
    """The curve of the mean image, and those of all readings where they can be compared."""
    own = tuple(checked_curve(r.curve, name) for r in readings if r.curve is not None)
    alike = len({len(c.s_m) for c in own}) == 1
    curve = None if condition.curve is None else checked_curve(condition.curve, name)
    if curve is None and alike:
        curve = _mean_curve(own)
    if curve is None or not alike or not len(own) == len(readings) > 1:
        return curve, ()
    return curve, own if len(own[0].s_m) == len(curve.s_m) else ()


@dataclass(frozen=True)
class _Timing:
    """What the clocks of a condition's readings have in common."""

    voltage_V: float
    zeros: int  # readings of the run before its first pulse
    ratio: float  # |EIBM(-)/EIBM(+)|
    rise_s: float

    def of(self, readings: list[Reading], session: list[float]) -> Clock:
        """Of readings in time order; those without times are taken as spaced by the pulses."""
        index = np.array([r.index for r in readings], dtype=float)
        run_s = np.array(
            [r.index * PULSE_S + SAMPLE_S if r.time_s is None else r.time_s for r in readings]
        )
        wetted = np.array(
            [t if r.wetted_s is None else r.wetted_s for r, t in zip(readings, run_s, strict=True)]
        )
        return self._clock(index, run_s, np.array(session), wetted)

    def of_no_reading(self, session: float) -> Clock:
        """Of a free shape, at this time of the session, in a pulse amid others."""
        pulse = np.full(1, AMID)
        run_s = PULSE_S * pulse + SAMPLE_S
        return replace(self, zeros=0)._clock(pulse, run_s, np.full(1, session), run_s)

    def _clock(
        self, index: FloatArray, run_s: FloatArray, session: FloatArray, wetted: FloatArray
    ) -> Clock:
        shape = index.shape
        pulse = index - self.zeros if self.voltage_V else np.full(shape, -1.0)
        driven = PULSE_S * np.maximum(pulse, 0.0)
        before = -self.ratio if self.voltage_V > 0.0 else -1.0 / self.ratio
        opposite = np.where(pulse > 0.0, before, 0.0) if self.voltage_V else np.ones(shape)
        return Clock(
            np.full(shape, self.voltage_V), np.full(shape, SAMPLE_S), pulse, run_s, session,
            wetted, driven, opposite, np.full(shape, self.rise_s),
        )  # fmt: skip


def run_key(condition: Condition | TimeSeries) -> RunKey:
    """What the conditions of one set-up share."""
    position = np.inf if condition.position_m is None else condition.position_m
    # a series does not say how the rig was tilted
    tilt_rad = condition.tilt_rad if isinstance(condition, Condition) else 0.0
    return condition.configuration, float(position), condition.mounting, condition.run, tilt_rad


def _first_pulses(conditions: list[Condition]) -> dict[RunKey, int]:
    """The number that a reading of each run's first pulse has, or would have.

    Readings that are not recorded, such as those of discarded pulses, may have no number: then
    their times say how many there were.
    """
    readings: dict[RunKey, list[tuple[Reading, float]]] = {}
    for c in conditions:
        readings.setdefault(run_key(c), []).extend((r, c.voltage_V) for r in c.readings)
    result = {}
    for key, every in readings.items():
        zeros = [r for r, volts in every if volts == 0.0]
        pulses = [r for r, volts in every if volts != 0.0]
        if not zeros:
            continue
        last = max(zeros, key=lambda r: r.index)
        result[key] = 1 + last.index
        if pulses:
            first = min(pulses, key=lambda r: r.index)
            result[key] = first.index - _before(last, first)
    return result


def _before(last: Reading, first: Reading) -> int:
    """Pulses between the last reading at 0 V and the first one under voltage."""
    numbered = first.index - last.index - 1
    if last.time_s is None or first.time_s is None:
        return numbered
    timed = (first.time_s - last.time_s) / PULSE_S - 1.0
    whole = abs(timed - round(timed)) < OFF_PULSE and 0 <= round(timed) <= MOST_DISCARDED
    return round(timed) if whole else numbered


def _opposite_ratio(conditions: list[Condition]) -> float:
    """Rough |EIBM(-)/EIBM(+)|, from how far the forces move."""
    mean: dict[float, list[float]] = {}
    for c in conditions:
        if c.position_m is not None and c.used():
            mean.setdefault(np.sign(c.voltage_V), []).append(
                float(np.mean([r.force_N for r in c.used()]))
            )
    if not {-1.0, 0.0, 1.0} <= set(mean):
        return 1.0
    zero, up, down = (float(np.mean(mean[k])) for k in (0.0, 1.0, -1.0))
    return float(np.clip(abs(down - zero) / max(abs(up - zero), 1e-9), 0.3, 3.0))


@dataclass(frozen=True)
class _Session:
    """When in the session readings were taken.

    Where nobody wrote it down, runs are taken to have been made in the order of the table.
    """

    first_s: float
    last_s: float
    runs: list[RunKey]  # in the order of the table; empty: times are known

    @staticmethod
    def of(conditions: Sequence[Condition]) -> _Session:
        """Of all readings of all configurations."""
        times = [r.session_s for c in conditions for r in c.readings]
        known = [t for t in times if t is not None]
        if known:
            return _Session(min(known), max(known), [])
        held = [c for c in conditions if c.position_m is not None]
        return _Session(0.0, 0.0, list(dict.fromkeys(run_key(c) for c in held)))

    def share(self, condition: Condition, reading: Reading) -> float:
        """0 to 1 over the session; 0.5 where only this reading's time is not known."""
        key = run_key(condition)
        if key in self.runs:
            return (self.runs.index(key) + 0.5) / len(self.runs)
        if reading.session_s is None or self.last_s <= self.first_s:
            return 0.5
        return (reading.session_s - self.first_s) / (self.last_s - self.first_s)


def _mean_curve(curves: tuple[Curve, ...]) -> Curve:
    s, x, y = (np.mean([getattr(c, a) for c in curves], axis=0) for a in ("s_m", "x_m", "y_m"))
    return Curve(s, x, y)


def _pulses(series: TimeSeries, seen: tuple[Seen, ...]) -> Iterator[Pulses]:
    """Parts of the kept pulses of one run, for each driving voltage."""
    if series.position_m is None:
        return
    parts = parts_of_pulses(series)
    for i, one in enumerate(seen):
        # a series does not say how the rig was tilted
        if one.run[:4] != run_key(series)[:4] or one.voltage_V == 0.0:
            continue
        own = parts.get(float(np.sign(one.voltage_V)))
        if own is None or len(own) < FEWEST_PULSES:
            continue
        yield Pulses(
            one.configuration, one.run, i, 0.5 * (BINS_S[1:] + BINS_S[:-1]), np.diff(BINS_S),
            own.mean(axis=0), np.var(own, axis=0, ddof=1) / len(own),
            EDGE_STEPS * float(np.median(np.diff(series.time_s))),
        )  # fmt: skip


def shares(seen: Seen) -> FloatArray:
    """Of each reading in the mean of its condition: (n,)."""
    count = int(np.count_nonzero(seen.counts))
    return np.asarray(seen.counts / max(1, count), dtype=float)


def trends(clock: Clock) -> FloatArray:
    """Rows that turn n readings into their mean and orthonormal trends in time: (m, n)."""
    n = len(clock.run_s)
    if n == 0:
        return np.zeros((0, 0))
    t = clock.run_s - clock.run_s.mean()
    scale = float(np.max(np.abs(t))) or 1.0
    V = legendre.legvander(t / scale, min(TRENDS, n) - 1)
    Q, _ = np.linalg.qr(V)
    Q = Q * np.sign(Q[-1])
    rows: FloatArray = Q.T.copy()
    rows[0] = 1.0 / n
    return rows
