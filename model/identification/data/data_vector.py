"""The data vector of `diagnose`: the readings of all conditions in time order, curves and pulses.

Ten readings become a few numbers: their mean, and how they go with time (orthonormal polynomials up
to the third degree; what is left of them only says how noisy a reading is). The readings of the
first pulses, which are in no mean, stand for themselves, less that mean. A curve becomes the
coefficients of its distance from the prediction ("modes"). A recorded series becomes the force in
parts of a pulse, relative to the sampling point, averaged over the pulses of a run.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, field, replace
from functools import cached_property, partial
from typing import TypedDict

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre

from model.effects.interface import AcquisitionTimes
from model.identification.data.acquisition_times import (
    ReadingTimes,
    SessionTimes,
    first_pulses,
)
from model.identification.data.preceding_eibm import PrecedingEibm
from model.identification.data.pulses import BINS_S, begin_from_rest, parts_of_pulses
from model.identification.data.run_key import RunKey, run_key
from model.identification.data.zero_voltage import zero_voltage_V
from model.identification.observations import check_sheet, checked_curve
from model.measurements import (
    CameraUncertainty,
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
    TimeSeries,
    in_volts,
)

TRENDS = 4  # the mean, and polynomials in time up to the third degree
FEWEST_PULSES = 3  # of one polarity, to know how much they scatter
EDGE_STEPS = 0.3  # the uncertainty of an edge's time, in sampling intervals (uniform: 1/sqrt(12))
Index = npt.NDArray[np.int64]
Which = npt.NDArray[np.bool_]


class _OfMean(TypedDict, total=False):
    """What `ConditionData` has of a force that is a mean."""

    mean_of: int
    spread_N: float | None


@dataclass(frozen=True, kw_only=True)
class ConditionData:
    """One condition."""

    name: str
    configuration: str
    run: RunKey
    position_m: float  # NaN: free
    voltage_V: float
    up: float
    force_N: FloatArray  # (n,) readings in time order; none where there is no load cell
    clock: AcquisitionTimes  # of these readings, arrays (n,)
    counts: Which  # (n,) whether a reading is in the mean: not those of the discarded first pulses
    curve: Curve | None  # of the mean image, or the mean of the readings' curves
    # of each reading, or of those that count; empty: not recorded one by one
    own_curves: tuple[Curve, ...]
    identical: bool = False  # the readings were, which no load cell's are
    tilt_rad: float = 0.0  # of the rig about the sheet's long axis
    zero: bool = False  # the load cell's own, with nothing to touch: no shape of the sheet
    session: int = 1  # its number among those analysed together
    # of the one force that counts, where it was written down as a mean: readings in it, and their
    # standard deviation, N; None: not stated
    mean_of: int = 1
    spread_N: float | None = None

    @property
    def free(self) -> bool:
        """Whether nothing touches the sheet."""
        return bool(np.isnan(self.position_m))

    @cached_property
    def own_points_m(self) -> FloatArray:
        """X and y of the readings' own curves, (2, readings, points)."""
        curves = self.own_curves
        return np.array([[c.x_m for c in curves], [c.y_m for c in curves]])

    @property
    def kept_N(self) -> FloatArray:
        """The readings that count."""
        return self.force_N[self.counts]

    @property
    def kept_clock(self) -> AcquisitionTimes:
        """Return the acquisition times of the kept readings."""
        return self.clock.of(self.counts)


@dataclass(frozen=True, kw_only=True)
class PulseSeries:
    """The force in parts of the pulses of one run at one voltage, less that at the sample."""

    configuration: str
    run: RunKey
    condition: int  # index among the configuration's conditions
    middle_s: FloatArray  # (bins,) times in the pulse
    width_s: FloatArray
    force_N: FloatArray  # (bins,) mean over the pulses
    variance_N2: FloatArray  # (bins,) of that mean
    edge_s: float  # how well the edges' times are known


@dataclass(frozen=True, kw_only=True)
class DataVector:
    """One configuration."""

    sheet: SheetGeometry
    seen: tuple[ConditionData, ...]
    pulses: tuple[PulseSeries, ...]
    session_s: float = 0.0  # from the first reading of the longest session to its last; 0: unknown
    trends: int = TRENDS  # of the readings of a condition, the mean among them
    zero_V: float = 0.0  # at the sheet while no voltage is asked for, as read back
    camera: CameraUncertainty = field(default_factory=CameraUncertainty)

    @property
    def voltages_V(self) -> list[float]:
        """Driving voltages, ascending."""
        return sorted({s.voltage_V for s in self.seen if s.voltage_V != 0.0})


def data_vector_of(measurements: Measurements, configuration: str) -> DataVector:
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
    session = SessionTimes.of(every)
    zeros = first_pulses(own)
    series = [s for s in measurements.series if s.configuration == configuration and not s.extra]
    rests = bool(series) and all(begin_from_rest(s) for s in series)
    before = PrecedingEibm.of(own, rests=rests)
    begun = {
        number: min((session.share(c, r) for c in some for r in c.used()), default=0.5)
        for number, some in _by_session(own).items()
    }
    found = [_seen(c, sheet, session, zeros, before, begun[c.session]) for c in own]
    seen = tuple(s for s in found if s is not None)
    if not seen:
        reasons = sorted({r.why for c in own for r in c.readings if r.why})
        why = f" ({'; '.join(reasons)})" if reasons else ""
        raise ModelError(f"configuration '{configuration}' has no valid readings at all{why}")
    zeros_N = (_load_cell_zero(c, session, begun[c.session]) for c in own)
    seen += tuple(s for s in zeros_N if s is not None)
    pulses = [p for s in series for p in _pulses(s, seen)]
    return DataVector(
        sheet=sheet, seen=seen, pulses=tuple(pulses), session_s=session.session_s,
        zero_V=zero_voltage_V(measurements, configuration), camera=measurements.camera,
    )  # fmt: skip


def _by_session(conditions: Sequence[Condition]) -> dict[int, list[Condition]]:
    found: dict[int, list[Condition]] = {}
    for one in conditions:
        found.setdefault(one.session, []).append(one)
    return found


def means_of(whole: DataVector) -> DataVector:
    """Return the time-independent data: mean forces, with their noise, and mean curves.

    Trends, first pulses, single curves and pulses do not inform parameters that are constant in
    time, and make up most of the rows.
    """
    seen = tuple(
        replace(
            one, force_N=one.kept_N, clock=one.kept_clock, own_curves=(),
            counts=np.ones(len(one.kept_N), dtype=bool),
        )
        for one in whole.seen
    )  # fmt: skip
    return replace(whole, seen=seen, pulses=(), trends=1)


def _told_apart(conditions: Sequence[Condition]) -> list[Condition]:
    """Give conditions that are approached from above a run of their own, where none is stated."""
    below = {run_key(one) for one in conditions if one.approach != "down"}
    beyond = 1 + max((one.run for one in conditions), default=0)  # no run of theirs has it yet
    return [
        replace(one, run=beyond + one.run)
        if one.approach == "down" and run_key(one) in below else one
        for one in conditions
    ]  # fmt: skip


def _seen(
    condition: Condition,
    sheet: SheetGeometry,
    session: SessionTimes,
    zeros: dict[RunKey, int],
    before: PrecedingEibm,
    begun: float,
) -> ConditionData | None:
    """Return the data of a condition; None where nothing is usable.

    Raises `ModelError` where a number is not finite. `begun` is when the first position begins.
    """
    at_m, free = condition.position_m, condition.position_m is None
    place = "free" if at_m is None else f"{at_m * 1e3:g} mm"
    name = f"{condition.configuration}, {place}, {in_volts(condition.voltage_V)}"
    readings = sorted(condition.used(), key=_index)
    shape_alone = not condition.readings and condition.curve is not None
    if condition.curve is None if free else not (readings or shape_alone):
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
    forces = np.array([] if free else [r.force_N for r in readings], dtype=float)
    if not np.all(np.isfinite(forces)):
        raise ModelError(f"a force of condition {name} is not a finite number; mark it invalid")
    key = run_key(condition)
    timing = ReadingTimes(
        voltage_V=condition.voltage_V, zeros=zeros.get(key, 0), before=before,
        rise_s=sheet.rise_time_s, worked_s=session.worked_s.get(key, 0.0),
        driven_s=session.driven_s.get(key, 0.0), position_m=np.nan if at_m is None else float(at_m),
        overall=partial(session.overall, condition), session_s=session.session_s,
    )  # fmt: skip
    at = [session.share(condition, r) for r in readings]
    return ConditionData(
        name=name, configuration=condition.configuration, run=key,
        position_m=np.nan if at_m is None else float(at_m), voltage_V=condition.voltage_V,
        up=-1.0 if condition.approach == "down" else 1.0, force_N=forces,
        clock=(
            timing.of(readings, at, key) if len(forces)
            else timing.of_no_reading(_taken(condition, session, begun))
        ),
        counts=np.arange(len(forces)) >= len(early), curve=curve, own_curves=() if free else own,
        identical=identical, tilt_rad=condition.tilt_rad, session=condition.session,
        **_of_a_mean(readings[len(early) :]),
    )  # fmt: skip


def _taken(condition: Condition, session: SessionTimes, begun: float) -> float:
    """Return when a shape without forces was acquired.

    Where nobody wrote it down: before the positions.
    """
    timed = [r for r in condition.readings if r.valid and r.session_s is not None]
    if not timed:
        return begun
    return float(np.mean([session.share(condition, r) for r in timed]))


def _of_a_mean(counting: list[Reading]) -> _OfMean:
    """Return what is stated of a force that is the mean of readings nobody wrote down."""
    if len(counting) != 1:
        return {}
    (one,) = counting
    return {"mean_of": one.mean_of, "spread_N": one.sd_N}


def _load_cell_zero(
    condition: Condition, session: SessionTimes, begun: float
) -> ConditionData | None:
    """Return the load cell's readings at 0 V without contact; None if absent or all equal.

    Readings acquired at a position belong to the run there; others are a set-up of their own.
    """
    chosen = [r for r in condition.readings if r.kind == "no_contact" and r.valid]
    readings = sorted(chosen, key=_index)
    forces = np.array([r.force_N for r in readings])
    if condition.voltage_V != 0.0 or len(set(forces.tolist())) < 2:
        return None
    name = f"{condition.configuration}, without contact, 0 V"
    if not np.all(np.isfinite(forces)):
        raise ModelError(f"a force of condition {name} is not a finite number; mark it invalid")
    times = [begun if r.session_s is None else session.share(condition, r) for r in readings]
    timing = ReadingTimes(
        voltage_V=0.0, zeros=0, rise_s=0.0, worked_s=0.0,
        overall=partial(session.overall, condition), session_s=session.session_s,
    )  # fmt: skip
    return ConditionData(
        name=name, configuration=condition.configuration, run=run_key(condition), position_m=np.nan,
        voltage_V=0.0, up=1.0, force_N=forces,
        clock=timing.of(readings, times),
        counts=np.ones(len(forces), dtype=bool), curve=None, own_curves=(),
        tilt_rad=condition.tilt_rad, zero=True, session=condition.session,
    )  # fmt: skip


def _alike(curves: list[Curve | None], others: tuple[Curve, ...], name: str) -> tuple[Curve, ...]:
    """Curves of as many points as the others have; none where one has not."""
    found = tuple(checked_curve(c, name) for c in curves if c is not None)
    lengths = {len(c.s_m) for c in (*found, *others)}
    return found if others and len(found) == len(curves) and len(lengths) == 1 else ()


def _index(reading: Reading) -> int:
    """Return the index by which readings are ordered."""
    return reading.index


def _early(condition: Condition) -> list[Reading]:
    """Return the valid readings of the discarded first pulses, in time order.

    Empty without kept readings, since nothing is there to compare with. Readings discarded later,
    such as while a sheet relaxes from a hold, are not included.
    """
    first = min((r.index for r in condition.used()), default=-1)
    found = [r for r in condition.readings if r.kind == "discarded" and r.valid and r.index < first]
    return sorted(found, key=_index) if condition.voltage_V != 0.0 else []


def _curves(
    condition: Condition, readings: list[Reading], name: str
) -> tuple[Curve | None, tuple[Curve, ...]]:
    """Return the curve of the mean image, and those of all readings where comparable."""
    own = tuple(checked_curve(r.curve, name) for r in readings if r.curve is not None)
    alike = len({len(c.s_m) for c in own}) == 1
    curve = None if condition.curve is None else checked_curve(condition.curve, name)
    if curve is None and alike:
        curve = _mean_curve(own)
    if curve is None or not alike or not len(own) == len(readings) > 1:
        return curve, ()
    return curve, own if len(own[0].s_m) == len(curve.s_m) else ()


def _mean_curve(curves: tuple[Curve, ...]) -> Curve:
    s, x, y = (np.mean([getattr(c, a) for c in curves], axis=0) for a in ("s_m", "x_m", "y_m"))
    return Curve(s_m=s, x_m=x, y_m=y)


def _pulses(series: TimeSeries, seen: tuple[ConditionData, ...]) -> Iterator[PulseSeries]:
    """Parts of the kept pulses of one run, for each driving voltage."""
    if series.position_m is None:
        return
    # a series does not say how the rig was tilted
    same = {i: one for i, one in enumerate(seen) if one.run[:4] == run_key(series)[:4]}
    parts = parts_of_pulses(series, {one.voltage_V for one in same.values()})
    for i, one in same.items():
        own = parts.get(one.voltage_V)
        if own is None or len(own) < FEWEST_PULSES:
            continue
        yield PulseSeries(
            configuration=one.configuration, run=one.run, condition=i,
            middle_s=0.5 * (BINS_S[1:] + BINS_S[:-1]), width_s=np.diff(BINS_S),
            force_N=own.mean(axis=0), variance_N2=np.var(own, axis=0, ddof=1) / len(own),
            edge_s=EDGE_STEPS * float(np.median(np.diff(series.time_s))),
        )  # fmt: skip


def shares(seen: ConditionData) -> FloatArray:
    """Of each reading in the mean of its condition: (n,)."""
    count = int(np.count_nonzero(seen.counts))
    return np.asarray(seen.counts / max(1, count), dtype=float)


def trends(clock: AcquisitionTimes, count: int = TRENDS) -> FloatArray:
    """Rows that turn n readings into their mean and orthonormal trends in time: (m, n)."""
    n = len(clock.run_s)
    if n == 0:
        return np.zeros((0, 0))
    t = clock.run_s - clock.run_s.mean()
    scale = float(np.max(np.abs(t))) or 1.0
    V = legendre.legvander(t / scale, min(count, n) - 1)
    Q, _ = np.linalg.qr(V)
    Q = Q * np.sign(Q[-1])
    rows: FloatArray = Q.T.copy()
    rows[0] = 1.0 / n
    return rows
