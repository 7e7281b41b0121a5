"""What `diagnose` looks at: every condition's readings in time order, its curve, and the pulses.

Ten readings become a few numbers: their mean, and how they go with time (orthonormal polynomials up
to the third degree; what is left of them only says how noisy a reading is). A curve becomes the
coefficients of its distance from the prediction ("modes"). A recorded series becomes the force in
parts of a pulse, relative to the sampling point, averaged over the pulses of a run.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.polynomial import legendre

from model.effects.interface import Clock
from model.measurements import (
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    SheetGeometry,
    TimeSeries,
)
from model.observations import check_sheet, checked_curve

TRENDS = 4  # the mean, and polynomials in time up to the third degree
PULSE_S, SAMPLE_S, WINDOW_S = 0.6, 0.5, 0.1
DISCARDED = 2
BINS_S = np.array([0.15, 0.19, 0.23, 0.28, 0.34, 0.40])  # edges of parts of a pulse
RunKey = tuple[str, float, int, int]


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
    curve: Curve | None  # of the mean image, or the mean of the readings' curves
    own_curves: tuple[Curve, ...]  # of each reading; empty: not recorded one by one
    identical: bool = False  # the readings were, which no load cell's are

    @property
    def free(self) -> bool:
        """Whether nothing touches the sheet."""
        return bool(np.isnan(self.position_m))


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
    own = [c for c in measurements.conditions if c.configuration == configuration]
    if not own:
        raise ModelError(f"configuration '{configuration}' has no conditions: nothing was measured")
    span = _session_span(measurements)
    zeros = _first_pulses(own)
    ratio = _opposite_ratio(own)
    found = [_seen(c, sheet, span, zeros, ratio) for c in own]
    seen = tuple(s for s in found if s is not None)
    if not seen:
        reasons = sorted({r.why for c in own for r in c.readings if r.why})
        why = f" ({'; '.join(reasons)})" if reasons else ""
        raise ModelError(f"configuration '{configuration}' has no valid readings at all{why}")
    series = [s for s in measurements.series if s.configuration == configuration]
    pulses = [p for s in series for p in _pulses(s, seen, span, ratio)]
    return Look(sheet, seen, tuple(pulses))


def _seen(
    condition: Condition,
    sheet: SheetGeometry,
    span: tuple[float, float],
    zeros: dict[RunKey, int],
    ratio: float,
) -> Seen | None:
    free = condition.position_m is None
    place = "free" if free else f"{condition.position_m * 1e3:g} mm"  # type: ignore[operator]
    name = f"{condition.configuration}, {place}, {condition.voltage_V:+g} V"
    readings = sorted(condition.used(), key=lambda r: r.index)
    if (not free and not readings) or (free and condition.curve is None):
        return None
    identical = not free and len(readings) > 1 and len({r.force_N for r in readings}) == 1
    if identical:
        readings = readings[len(readings) // 2 :][:1]
    forces = np.array([] if free else [r.force_N for r in readings])
    if not np.all(np.isfinite(forces)):
        raise ModelError(f"a force of condition {name} is not a finite number; mark it invalid")
    if not np.isfinite(condition.voltage_V):
        raise ModelError(f"the voltage of condition {name} is not a finite number")
    key = run_key(condition)
    own = tuple(checked_curve(r.curve, name) for r in readings if r.curve is not None)
    same = len(own) == len(readings) > 1 and len({len(c.s_m) for c in own}) == 1
    curve = None if condition.curve is None else checked_curve(condition.curve, name)
    if curve is None and own and len({len(c.s_m) for c in own}) == 1:
        curve = _mean_curve(own)
    index = np.array([r.index for r in readings], dtype=float)
    run_s = np.array(
        [r.index * PULSE_S + SAMPLE_S if r.time_s is None else r.time_s for r in readings]
    )
    session = np.array([_share(r.session_s, span) for r in readings])
    wetted = np.array(
        [t if r.wetted_s is None else r.wetted_s for r, t in zip(readings, run_s, strict=True)]
    )
    clock = _clock(condition.voltage_V, index, run_s, session, wetted, zeros.get(key, 0), ratio,
                   sheet.rise_time_s)  # fmt: skip
    if free:
        clock = _clock(condition.voltage_V, np.zeros(1), np.zeros(1), np.full(1, 0.5),
                       np.zeros(1), 0, ratio, sheet.rise_time_s)  # fmt: skip
    return Seen(
        name, condition.configuration, key, np.nan if free else float(condition.position_m or 0.0),
        condition.voltage_V, -1.0 if condition.approach == "down" else 1.0, forces, clock, curve,
        own if same and not free else (), identical,
    )  # fmt: skip


def run_key(condition: Condition | TimeSeries) -> RunKey:
    """What the conditions of one set-up share."""
    position = np.inf if condition.position_m is None else condition.position_m
    run = condition.run if isinstance(condition, Condition) else 0
    return condition.configuration, float(position), condition.mounting, run


def _clock(
    voltage_V: float,
    index: FloatArray,
    run_s: FloatArray,
    session: FloatArray,
    wetted: FloatArray,
    zeros: int,
    ratio: float,
    rise_s: float,
) -> Clock:
    shape = index.shape
    pulse = index - zeros if voltage_V else np.full(shape, -1.0)
    driven = PULSE_S * np.maximum(pulse, 0.0)
    before = -ratio if voltage_V > 0.0 else -1.0 / ratio
    opposite = np.where(pulse > 0.0, before, 0.0) if voltage_V else np.ones(shape)
    return Clock(
        np.full(shape, voltage_V), np.full(shape, SAMPLE_S), pulse, run_s, session, wetted, driven,
        opposite, np.full(shape, rise_s),
    )  # fmt: skip


def _first_pulses(conditions: list[Condition]) -> dict[RunKey, int]:
    """How many readings of a run come before its first pulse."""
    result: dict[RunKey, int] = {}
    for c in conditions:
        if c.voltage_V == 0.0 and c.readings:
            key = run_key(c)
            result[key] = max(result.get(key, 0), 1 + max(r.index for r in c.readings))
    return result


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


def _session_span(measurements: Measurements) -> tuple[float, float]:
    times = [r.session_s for c in measurements.conditions for r in c.readings]
    known = [t for t in times if t is not None]
    return (min(known), max(known)) if known else (0.0, 0.0)


def _share(session_s: float | None, span: tuple[float, float]) -> float:
    if session_s is None or span[1] <= span[0]:
        return 0.5
    return (session_s - span[0]) / (span[1] - span[0])


def _mean_curve(curves: tuple[Curve, ...]) -> Curve:
    s, x, y = (np.mean([getattr(c, a) for c in curves], axis=0) for a in ("s_m", "x_m", "y_m"))
    return Curve(s, x, y)


def _pulses(
    series: TimeSeries, seen: tuple[Seen, ...], span: tuple[float, float], ratio: float
) -> list[Pulses]:
    """Parts of the kept pulses of one run, for each driving voltage."""
    if series.force_N is None or series.position_m is None or len(series.time_s) < 20:
        return []
    t, drive = np.asarray(series.time_s), np.asarray(series.drive_V)
    force = np.asarray(series.force_N)
    if not (np.all(np.isfinite(t)) and np.all(np.isfinite(drive))):
        raise ModelError(f"the series of {series.configuration} holds a number that is not finite")
    level = np.round(drive / 0.25)  # steps of voltage, without the read-back's noise
    starts = np.concatenate([[0], 1 + np.flatnonzero(np.diff(level))])
    starts = starts[np.concatenate([np.diff(np.append(t[starts], t[-1])) > 0.8 * SAMPLE_S])]
    ends = np.append(starts[1:], len(t))
    result, driven = [], 0
    parts: dict[float, list[FloatArray]] = {}
    for a, b in zip(starts, ends, strict=True):
        volts = float(np.median(drive[a:b]))
        if abs(volts) < 0.25:
            continue
        driven += 1
        before = t[a - 1] if a else t[a]  # the edge lies between two samples
        part = _parts(t[a:b] - 0.5 * (before + t[a]), force[a:b])
        if driven > DISCARDED and part is not None:
            parts.setdefault(np.sign(volts), []).append(part)
    for i, one in enumerate(seen):
        if one.run[:3] != run_key(series)[:3] or one.voltage_V == 0.0:
            continue
        own = np.array(parts.get(np.sign(one.voltage_V), []))
        if len(own) < 3:
            continue
        middle = 0.5 * (BINS_S[1:] + BINS_S[:-1])
        variance = np.var(own, axis=0, ddof=1) / len(own)
        result.append(Pulses(one.configuration, one.run, i, middle, np.diff(BINS_S), own.mean(axis=0),
                             variance, 0.3 * float(np.median(np.diff(t)))))  # fmt: skip
    return result


def _parts(t: FloatArray, force: FloatArray) -> FloatArray | None:
    """Mean force in each part of a pulse, less that about the sampling point."""
    at = force[np.abs(t - SAMPLE_S) <= WINDOW_S]
    if not len(at) or not np.all(np.isfinite(at)):
        return None
    means = []
    for low, high in zip(BINS_S[:-1], BINS_S[1:], strict=True):
        inside = force[(t >= low) & (t < high)]
        if not len(inside) or not np.all(np.isfinite(inside)):
            return None
        means.append(float(np.mean(inside)))
    return np.array(means) - float(np.mean(at))


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
    rows = Q.T.copy()
    rows[0] = 1.0 / n
    return rows
