"""Candidate measurements: for each, how far apart it puts two candidate effects."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from model.discrepancy.search.evidence import Candidate, Projected, candidates
from model.discrepancy.thresholds import COMPARISON_SIGMA
from model.discrepancy.verdict.result import Next
from model.effects import title
from model.effects.interface import Effect
from model.identification.data.acquisition_times import ReadingTimes
from model.identification.data.data_vector import ConditionData, DataVector
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Bases, linearise
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import FitProblem, MixedModelFit
from model.identification.likelihood.row_noise import noise_of
from model.measurements import FloatArray, ModelError

PULSE_S = 0.6
LONGER = 3  # times as many pulses, in a long run
LONG_MINUTES = 1.5  # a position with so many
RUN_MINUTES = 1.0  # a position: move, moisten, 32 readings
ZERO_MINUTES = 0.5  # the sheet out of the rolls, ten readings, and in again
TURN_MINUTES = 3.0  # the rig over, and everything in its place again


@dataclass(frozen=True, kw_only=True)
class CandidateMeasurement:
    """Something that can be measured besides."""

    name: str
    what: str
    minutes: Callable[[DataVector], float]
    add: Callable[[DataVector], tuple[ConditionData, ...]]
    protocol: dict[str, object]


def _touching(one: DataVector) -> list[ConditionData]:
    """Every position and voltage once, however often it was measured: as a session would again."""
    found: dict[tuple[float, float], ConditionData] = {}
    for seen in one.seen:
        if not seen.free:
            found.setdefault((seen.position_m, seen.voltage_V), seen)
    return list(found.values())


def _again(
    seen: ConditionData,
    mounting: int,
    *,
    at_m: float | None = None,
    up: float = 1.0,
    tilt_rad: float = 0.0,
) -> ConditionData:
    """Return the same in another set-up, with a number that no session has."""
    at_m = seen.position_m if at_m is None else at_m
    key = (seen.configuration, at_m, mounting, 0, tilt_rad)
    clock = replace(seen.clock, position_m=at_m)
    return replace(seen, run=key, position_m=at_m, up=up, tilt_rad=tilt_rad, clock=clock)


def _places(one: DataVector) -> list[float]:
    return sorted({s.position_m for s in _touching(one)})


def _set_anew(one: DataVector, mounting: int) -> tuple[ConditionData, ...]:
    """Return the first, the middle and the last position."""
    places = _places(one)
    chosen = {places[i] for i in (0, len(places) // 2, -1)} if places else set()
    return tuple(_again(s, mounting) for s in _touching(one) if s.position_m in chosen)


def _remount(one: DataVector) -> tuple[ConditionData, ...]:
    return _set_anew(one, 90)


def _reversed(one: DataVector) -> tuple[ConditionData, ...]:
    return tuple(_again(s, 91, up=-1.0) for s in _touching(one))


def _repeat(one: DataVector) -> tuple[ConditionData, ...]:
    return tuple(_again(s, 92) for s in _touching(one))


def _long(one: DataVector) -> tuple[ConditionData, ...]:
    """Return three positions with `LONGER` times as many readings under voltage."""
    return tuple(_longer(s) if s.voltage_V else s for s in _set_anew(one, 99))


def _longer(seen: ConditionData) -> ConditionData:
    """Return the same pulses going on and on; before them nothing changes."""
    clock, count = seen.kept_clock, LONGER * len(seen.kept_N)

    def on(values: FloatArray, step: float) -> FloatArray:
        step = float(np.median(np.diff(values))) if len(values) > 1 else step
        return np.asarray(values[0] + step * np.arange(count))

    pulses = 2.0  # from one pulse of this voltage to the next
    seconds = pulses * PULSE_S
    longer = replace(
        clock.of(np.zeros(len(clock.voltage_V), dtype=bool)),
        voltage_V=np.full(count, clock.voltage_V[0]),
        pulse_s=np.full(count, clock.pulse_s[0]),
        session=np.full(count, float(np.mean(clock.session))),
        opposite=np.resize(clock.opposite, count),
        rise_s=np.full(count, np.broadcast_to(clock.rise_s, len(clock.voltage_V))[0]),
        pulse=on(clock.pulse, pulses),
        run_s=on(clock.run_s, seconds),
        wetted_s=on(clock.wetted_s, seconds),
        driven_s=on(clock.driven_s, seconds),
        worked_s=on(np.asarray(clock.worked_s), seconds),
        position_m=seen.position_m,
    )
    own = seen.own_curves[-len(seen.kept_N) :]
    curves = tuple(own[k % len(own)] for k in range(count)) if own else ()
    counts = np.ones(count, dtype=bool)
    return replace(seen, force_N=np.zeros(count), clock=longer, counts=counts, own_curves=curves)


def _turned(one: DataVector) -> tuple[ConditionData, ...]:
    return tuple(_again(s, 98, tilt_rad=np.pi) for s in _touching(one))


def _half(one: DataVector) -> tuple[ConditionData, ...]:
    """Return half the voltage at every position; 0 V there, too."""
    return tuple(
        replace(
            _again(s, 93),
            voltage_V=0.5 * s.voltage_V,
            clock=replace(s.clock, voltage_V=0.5 * s.clock.voltage_V),
        )
        for s in _touching(one)
    )


def _free(one: DataVector) -> tuple[ConditionData, ...]:
    """Six shapes without the load cell: twice at each voltage."""
    result = []
    for mounting in (94, 95):
        for volts in sorted({s.voltage_V for s in one.seen}):
            like = next((s for s in one.seen if s.voltage_V == volts and s.curve is not None), None)
            if like is None:
                continue
            clock = ReadingTimes(
                voltage_V=volts, zeros=0, ratio=1.0, rise_s=one.sheet.rise_time_s, worked_s=0.0
            ).of_no_reading(0.5)
            result.append(
                replace(
                    like,
                    name=f"{one.sheet.configuration}, free, {volts:+g} V",
                    run=(one.sheet.configuration, np.inf, mounting, 0, 0.0),
                    tilt_rad=0.0,
                    position_m=np.nan,
                    force_N=np.zeros(0),
                    clock=clock,
                    counts=np.zeros(0, dtype=bool),
                    own_curves=(),
                )
            )
    return tuple(result)


def _between(one: DataVector) -> tuple[ConditionData, ...]:
    """Return positions half-way between those measured."""
    places = _places(one)
    middle = {a: 0.5 * (a + b) for a, b in pairwise(places)}
    return tuple(
        _again(s, 97, at_m=middle[s.position_m]) for s in _touching(one) if s.position_m in middle
    )


def _shuffled(one: DataVector) -> tuple[ConditionData, ...]:
    """All positions again, in an order that has nothing to do with their place on the arc."""
    random = np.random.default_rng(7)
    places = _places(one)
    at = dict(zip(places, random.permutation(len(places)) / max(len(places) - 1, 1), strict=True))
    return tuple(
        replace(
            _again(s, 96),
            clock=replace(s.clock, session=np.full(len(s.force_N), at[s.position_m])),
        )
        for s in _touching(one)
    )


def _zeros(one: DataVector) -> tuple[ConditionData, ...]:
    """Return all positions again, each after a reading of the load cell without contact."""
    return _repeat(one) + tuple(
        _load_cell_alone(s, 70 + i)
        for i, s in enumerate(s for s in _repeat(one) if s.voltage_V == 0.0)
    )


def _load_cell_alone(like: ConditionData, mounting: int) -> ConditionData:
    count = len(like.kept_N)
    return replace(
        like,
        name=f"{like.configuration}, without contact, +0 V",
        run=(like.configuration, np.inf, mounting, 0, 0.0),
        position_m=np.nan,
        force_N=np.zeros(count),
        clock=replace(like.kept_clock, position_m=np.nan),
        counts=np.ones(count, dtype=bool),
        curve=None,
        own_curves=(),
        zero=True,
    )


def _minutes(runs: float) -> Callable[[DataVector], float]:
    def always(one: DataVector) -> float:  # noqa: ARG001
        return runs * RUN_MINUTES

    return always


def _runs(one: DataVector) -> float:
    return RUN_MINUTES * len(_places(one))


def _zero_runs(one: DataVector) -> float:
    return _runs(one) + ZERO_MINUTES * len(_places(one))


def _turned_runs(one: DataVector) -> float:
    return TURN_MINUTES + _runs(one)


MENU: tuple[CandidateMeasurement, ...] = (
    CandidateMeasurement(
        name="free_shapes",
        what="six free shapes of each configuration, the load cell moved away",
        minutes=_minutes(1.5),
        add=_free,
        protocol={"extras": {"free_shapes": 6}},
    ),
    CandidateMeasurement(
        name="remount",
        what="three positions set anew",
        minutes=_minutes(3.0),
        add=_remount,
        protocol={"extras": {"remount": 3}},
    ),
    CandidateMeasurement(
        name="long_runs",
        what="three positions with three times as many pulses",
        minutes=_minutes(3.0 * LONG_MINUTES),
        add=_long,
        protocol={"pulse_train": {"readings_per_voltage": 30}},
    ),
    CandidateMeasurement(
        name="no_touch_zero",
        what="all positions again, each after the load cell's zero without contact",
        minutes=_zero_runs,
        add=_zeros,
        protocol={"extras": {"no_touch_zero": True}},
    ),
    CandidateMeasurement(
        name="reversed_approach",
        what="all positions again, approached from the other side",
        minutes=_runs,
        add=_reversed,
        protocol={"extras": {"reversed_approach": True}},
    ),
    CandidateMeasurement(
        name="between",
        what="positions half-way between those measured",
        minutes=_runs,
        add=_between,
        protocol={"extras": {"between": True}},
    ),
    CandidateMeasurement(
        name="half_voltage",
        what="all positions at half the voltage",
        minutes=_runs,
        add=_half,
        protocol={"extras": {"half_voltage": True}},
    ),
    CandidateMeasurement(
        name="random_order",
        what="all positions again in random order",
        minutes=_runs,
        add=_shuffled,
        protocol={"extras": {"random_order": True}},
    ),
    CandidateMeasurement(
        name="turned_over",
        what="all positions again with the rig turned over",
        minutes=_turned_runs,
        add=_turned,
        protocol={"extras": {"tilt_deg": 180.0}},
    ),
    CandidateMeasurement(
        name="more_repeats",
        what="everything once more",
        minutes=_runs,
        add=_repeat,
        protocol={"extras": {"repeat": 1}},
    ),
)


def separation(fitted: MixedModelFit, which: Sequence[Candidate], size: float) -> float:
    """Sigmas from the first candidate, `size` times its own size, to all the others can imitate."""
    forward = fitted.problem.forward
    weighed = Projected.of(forward, fitted.linear, fitted.solution)
    A, _ = weighed.normal(forward, np.stack([c.columns[:, 0] for c in which], axis=1))
    own, others = A[0, 1:], A[1:, 1:]
    rest = A[0, 0] - own @ np.linalg.lstsq(others, own, rcond=1e-12)[0]
    return float(np.sqrt(max(rest, 0.0))) * size


@dataclass(frozen=True)
class Suspect:
    """One of two effects that are indistinguishable so far."""

    effect: Effect
    values: dict[str, float]  # its form
    size: float  # multiples of it that the data speak of

    def forms(self, fitted: MixedModelFit) -> list[Candidate]:
        """Return all its forms in a design, its own one first."""
        pool = candidates(fitted, [self.effect], tolerant=False)
        return sorted(pool, key=lambda c: dict(c.values) != self.values)


def separated(fitted: MixedModelFit, between: Sequence[Suspect]) -> float:
    """Return how many sigmas the first two of some effects are apart in these data."""
    return _apart(fitted, _as_long(fitted, between[:2]))


def next_measurement(fitted: MixedModelFit, between: Sequence[Suspect]) -> Next | None:
    """Return the entry that separates the first two best for its time; None: there is none."""
    if len(between) < 2:
        return None
    pair = _as_long(fitted, between[:2])
    now = _apart(fitted, pair)
    best: tuple[float, CandidateMeasurement, float, float] | None = None
    for entry in MENU:
        try:
            then = _apart(extended(fitted, entry), pair)
        except (ModelError, np.linalg.LinAlgError):
            continue
        minutes = sum(entry.minutes(one) for one in fitted.problem.forward.looks)
        worth = max(then**2 - now**2, 0.0) / minutes
        if best is None or (min(then, COMPARISON_SIGMA), worth) > (
            min(best[2], COMPARISON_SIGMA),
            best[0],
        ):
            best = (worth, entry, then, minutes)
    if best is None:
        return None
    _, entry, then, minutes = best
    names = tuple(one.effect.name for one in pair)
    return Next(
        why=f"{entry.what}, to separate {' from '.join(map(title, names))}",
        extra=entry.name,
        between=names,
        separation=now,
        expected=then,
        minutes=minutes,
        protocol=entry.protocol,
    )


def _as_long(fitted: MixedModelFit, pair: Sequence[Suspect]) -> tuple[Suspect, Suspect]:
    """Return both with the amplitudes at which they explain as much as the stronger one.

    The second one's own amplitude may be near zero, since it was fitted to the remainder of the
    first.
    """
    first, second = pair
    units = [separation(fitted, one.forms(fitted)[:1], 1.0) for one in pair]
    length = max(one.size * unit for one, unit in zip(pair, units, strict=True))
    sizes = [
        length / unit if unit > 0.0 else one.size for one, unit in zip(pair, units, strict=True)
    ]
    return replace(first, size=sizes[0]), replace(second, size=sizes[1])


def _apart(fitted: MixedModelFit, pair: tuple[Suspect, Suspect]) -> float:
    """Sigmas from either of two to the nearest form of the other; the smaller of the two."""
    forms = [one.forms(fitted) for one in pair]
    return min(
        separation(fitted, (own[0], other), one.size)
        for one, own, others in zip(pair, forms, forms[::-1], strict=True)
        for other in others
    )


def extended(fitted: MixedModelFit, entry: CandidateMeasurement) -> MixedModelFit:
    """Return the design with an entry added: only its geometry counts, no data are made up."""
    problem = fitted.problem
    looks = [replace(one, seen=(*one.seen, *entry.add(one))) for one in problem.forward.looks]
    rests = [scene.rest for scene in problem.forward.scenes]
    forward = ForwardModel(looks, rests, like=problem.forward)
    noise = noise_of(forward)
    bases = problem.bases
    if bases.further is not None:  # planned data are those of a sheet at rest
        bases = replace(bases, further=bases.further.of_rows(forward.layout.size))
    larger = FitProblem.of(forward, bases, noise)
    if any(
        len(a.voltages_V) != len(b.voltages_V)
        for a, b in zip(looks, problem.forward.looks, strict=True)
    ):
        bases = _with_half(replace(problem, bases=bases), forward)
        larger = replace(larger, bases=bases)
    theta = fitted.theta
    if bases.size > problem.bases.size:
        theta = np.concatenate([theta, _half_start(problem, bases, theta)])
    linear = linearise(forward, bases, noise, theta)
    log_sigma = larger.guess.copy()
    n = min(len(log_sigma), len(fitted.solution.log_sigma))
    log_sigma[:n] = fitted.solution.log_sigma[:n]
    return MixedModelFit(
        problem=larger,
        theta=theta,
        found=(),
        linear=linear,
        solution=weigh(linear.data, log_sigma),
        deviance=0.0,
        spans=(),
    )


def _with_half(problem: FitProblem, forward: ForwardModel) -> Bases:
    """Parameters of the further voltages, after all others."""
    parts, place = [], problem.bases.size
    for one, own in zip(problem.bases.parts, forward.looks, strict=True):
        eibm = dict(one.eibm)
        for volts in own.voltages_V:
            if volts not in eibm:
                eibm[volts], place = (place, 1.0), place + 1
        parts.append(replace(one, eibm=eibm))
    return replace(problem.bases, parts=tuple(parts), size=place)


def _half_start(problem: FitProblem, bases: Bases, theta: FloatArray) -> FloatArray:
    more = np.zeros(bases.size - problem.bases.size)
    for one in bases.parts:
        for volts, (i, _) in one.eibm.items():
            if i >= problem.bases.size:
                like = one.eibm.get(2.0 * volts)
                more[i - problem.bases.size] = 0.5 * theta[like[0]] if like else 0.0
    return more
