"""Acquisition times of readings: in the pulse, in the run, in the session.

Times that are not recorded follow from the protocol: readings are spaced by the pulses, and runs
are in the order of the table.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace

import numpy as np

from model.effects.interface import AcquisitionTimes
from model.identification.data.preceding_eibm import PrecedingEibm
from model.identification.data.run_key import RunKey, run_key
from model.measurements import Condition, FloatArray, Reading
from model.measurements.pulse_train import PULSE_S, SAMPLE_S

AMID = 10.0  # number of a pulse long after the first one
OFF_PULSE, MOST_DISCARDED = 0.1, 6  # of times that count pulses, in pulses


@dataclass(frozen=True, kw_only=True)
class SessionTimes:
    """Acquisition times of readings, since their session began.

    Where they are not recorded, runs are assumed to be in the order of the table. The instruments
    are set anew in each session and the sheet is mounted again, so a session has a beginning of its
    own; its times are told in units of the longest one.
    """

    dated: dict[int, float]  # first reading of each session whose times are recorded, s
    begins_s: dict[int, float]  # of each session, one after the other
    longest_s: float  # of the sessions, and all of them; where none is dated, in runs
    whole_s: float
    run_s: float
    runs: dict[int, list[RunKey]]  # of each other session, in the order of the table
    worked_s: dict[RunKey, float]  # under voltage before each run
    driven_s: dict[RunKey, float]  # ... since the sheet was last wetted

    @staticmethod
    def of(conditions: Sequence[Condition]) -> SessionTimes:
        """Of all readings of all configurations."""
        spans_s, runs = _spans_s(conditions), _runs(conditions)
        lengths_s = {number: last - first for number, (first, last) in spans_s.items()}
        rates = [length / len(runs[n]) for n, length in lengths_s.items() if length and runs.get(n)]
        run_s, end_s = max(rates, default=1.0), 0.0
        begins_s = dict[int, float]()
        for number in sorted({c.session for c in conditions}):
            begins_s[number] = max(end_s, spans_s.get(number, (0.0, 0.0))[0])
            length_s = lengths_s.setdefault(number, run_s * len(runs.get(number, ())))
            end_s = begins_s[number] + length_s
        # a free shape of which nobody knows when it was acquired came before the positions
        timed = [c for c in conditions if c.position_m is not None or _is_timed(c)]
        worked_s, driven_s = _worked(timed)
        return SessionTimes(
            dated={number: first for number, (first, _) in spans_s.items()}, begins_s=begins_s,
            longest_s=max(lengths_s.values(), default=0.0),
            whole_s=end_s - min(begins_s.values(), default=0.0), run_s=run_s,
            runs={number: own for number, own in runs.items() if number not in spans_s},
            worked_s=worked_s, driven_s=driven_s,
        )  # fmt: skip

    @property
    def session_s(self) -> float:
        """Length of the longest session; 0: unknown."""
        return self.longest_s if self.dated else 0.0

    def share(self, condition: Condition, reading: Reading) -> float:
        """0 to 1 over the longest session; 0.5 where only this reading's time is not known."""
        own, key = self.runs.get(condition.session, []), run_key(condition)
        if key in own:
            return (own.index(key) + 0.5) * self.run_s / self.longest_s
        if reading.session_s is None or self.longest_s <= 0.0:
            return 0.5
        return (reading.session_s - self.dated[condition.session]) / self.longest_s

    def overall(self, condition: Condition, share: float) -> float:
        """0 to 1 over all sessions, of a time that is a share of the longest one."""
        if self.whole_s <= 0.0:
            return 0.5
        before_s = self.begins_s[condition.session] - min(self.begins_s.values())
        return (before_s + share * self.longest_s) / self.whole_s


@dataclass(frozen=True, kw_only=True)
class ReadingTimes:
    """The clock data common to a condition's readings."""

    voltage_V: float
    zeros: int  # readings of the run before its first pulse
    rise_s: float
    worked_s: float  # under voltage before the run
    driven_s: float = 0.0  # ... since the sheet was last wetted
    position_m: float = np.nan  # NaN: free
    before: PrecedingEibm = field(default_factory=PrecedingEibm)
    session_s: float = 0.0  # what `session` is a share of; 0: unknown
    overall: Callable[[float], float] = field(default=lambda share: share)  # see `SessionTimes`

    def of(
        self, readings: list[Reading], session: list[float], key: RunKey | None = None
    ) -> AcquisitionTimes:
        """Of readings in time order; those without times are taken as spaced by the pulses."""
        index = np.array([r.index for r in readings], dtype=float)
        run_s = np.array(
            [r.index * PULSE_S + SAMPLE_S if r.time_s is None else r.time_s for r in readings]
        )
        wetted = np.array(
            [t if r.wetted_s is None else r.wetted_s for r, t in zip(readings, run_s, strict=True)]
        )
        before_V = self.before.voltages_V(key, self.voltage_V, [r.index for r in readings])
        clock = self._clock(index, run_s, np.array(session), wetted, before_V)
        return replace(clock, channels=_channels(readings))

    def of_no_reading(self, session: float) -> AcquisitionTimes:
        """Of a free shape, at this time of the session, in a pulse amid others."""
        pulse = np.full(1, AMID)
        run_s = PULSE_S * pulse + SAMPLE_S
        before_V = self.before.voltages_V(None, self.voltage_V, [0])
        return replace(self, zeros=0)._clock(pulse, run_s, np.full(1, session), run_s, before_V)

    def _clock(
        self, index: FloatArray, run_s: FloatArray, session: FloatArray, wetted: FloatArray,
        before_V: FloatArray,
    ) -> AcquisitionTimes:  # fmt: skip
        shape = index.shape
        pulse = index - self.zeros if self.voltage_V else np.full(shape, -1.0)
        driven = PULSE_S * np.maximum(pulse, 0.0)
        dried = self.driven_s + driven
        opposite, opposite_V = np.ones(shape), np.ones(shape)
        if self.voltage_V:
            before_V = np.where(pulse > 0.0, before_V, 0.0)
            opposite = self.before.eibm(before_V, self.voltage_V)
            opposite_V = before_V / self.voltage_V
        return AcquisitionTimes(
            voltage_V=np.full(shape, self.voltage_V), pulse_s=np.full(shape, SAMPLE_S),
            pulse=pulse, run_s=run_s, session=session, wetted_s=wetted, driven_s=dried,
            opposite=opposite, opposite_V=opposite_V, rise_s=np.full(shape, self.rise_s),
            worked_s=self.worked_s + driven,
            run_began=self._run_began(session, run_s),
            position_m=np.full(shape, self.position_m),
            overall=np.array([self.overall(float(t)) for t in session]),
        )  # fmt: skip

    def _run_began(self, session: FloatArray, run_s: FloatArray) -> FloatArray:
        """Return the time of the session when the run began; one time for all is that of a run."""
        if self.session_s <= 0.0 or not np.ptp(session):
            return session
        return session - run_s / self.session_s


def _channels(readings: Sequence[Reading]) -> dict[str, FloatArray]:
    """Return the values of further channels at each reading; NaN where there is none."""
    names = dict.fromkeys(name for r in readings for name in r.other_values)
    return {name: np.array([r.other_values.get(name, np.nan) for r in readings]) for name in names}


def _spans_s(conditions: Sequence[Condition]) -> dict[int, tuple[float, float]]:
    """Return the first and the last time of each session; none where nobody wrote any down."""
    times = dict[int, list[float]]()
    for c in conditions:
        known = [r.session_s for r in c.readings if r.session_s is not None]
        if known:
            times.setdefault(c.session, []).extend(known)
    return {number: (min(own), max(own)) for number, own in times.items()}


def _runs(conditions: Sequence[Condition]) -> dict[int, list[RunKey]]:
    """Return the runs of each session that touch the load cell, in the order of the table."""
    found = dict[int, dict[RunKey, None]]()
    for c in conditions:
        if c.position_m is not None:
            found.setdefault(c.session, {})[run_key(c)] = None
    return {number: list(own) for number, own in found.items()}


def _is_timed(condition: Condition) -> bool:
    return any(r.session_s is not None for r in condition.readings)


def _worked(
    conditions: Sequence[Condition],
) -> tuple[dict[RunKey, float], dict[RunKey, float]]:
    """Time under voltage before each run, and since the last wetting, in s.

    Runs go by their times, else by the table. Where nobody wrote down when the sheet was wetted it
    was just before each run.
    """
    begun, wetted, pulses = dict[RunKey, float](), dict[RunKey, float](), dict[RunKey, int]()
    first = first_pulses(conditions)
    for c in conditions:
        key = run_key(c)
        for r in c.readings:
            if r.session_s is not None:
                begun[key] = min(begun.get(key, np.inf), r.session_s)
                since = 0.0 if r.wetted_s is None else r.wetted_s
                wetted[key] = min(wetted.get(key, np.inf), r.session_s - since)
        begun.setdefault(key, np.inf)
        last = max((r.index for r in c.readings if c.voltage_V), default=-1)
        pulses[key] = max(pulses.get(key, 0), 1 + last - first.get(key, 0))
    order = sorted(begun, key=begun.__getitem__)
    worked, driven = dict[RunKey, float](), dict[RunKey, float]()
    for i, key in enumerate(order):
        worked[key] = PULSE_S * sum(pulses[one] for one in order[:i])
        same = [one for one in order[:i] if begun[one] > wetted.get(key, np.inf)]
        driven[key] = PULSE_S * sum(pulses[one] for one in same)
    return worked, driven


def first_pulses(conditions: Sequence[Condition]) -> dict[RunKey, int]:
    """Return for each run the index of the reading at its first pulse, recorded or not.

    Readings that are not recorded, such as those of discarded pulses, may have no index: their
    number then follows from the times.
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
