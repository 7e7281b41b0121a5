"""Resume an unfinished session: its complete runs are published again as events.

A run of which no reading counts is not complete: whatever spoilt it, it is measured again.

The session stays as it is. The new one is a whole session: the complete runs are copied into it,
through the same writer and journal, before the first voltage; then the others are run. A kill
at any moment costs no more than in an ordinary session.
"""

from __future__ import annotations

import datetime as dt
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.interfaces import Frame, SignalBlock, VoltageWrite
from labrig.config import RigConfig, parse_rig, with_paths_from
from labrig.config.about import FILE as ABOUT
from labrig.config.derived import SIMULATED
from labrig.control.reference import CONTROLLER
from labrig.errors import BadInputError
from labrig.experiment.plan import Plan
from labrig.experiment.recorded_plan import plan_of_session
from labrig.experiment.rig.rig import Rig
from labrig.session import RecordedSession, RunRecord
from labrig.session.reading.moves import moves_of
from protocols.execution import events as ev
from protocols.planning.schedule import ReadingKind

_BLOCK = 10_000  # samples in one event
_FRAMES = 32  # frames in one event, of those that go with no reading
_CLOCK_NOT_SET = 2020  # a computer whose clock says an earlier year has lost its time of day


def resumed_plan(session: RecordedSession) -> Plan:
    """Return what was to be done, from configuration and schedule that the session holds.

    Files that its rig.toml names, a world or the watch's token, are looked for beside the session.
    """
    if CONTROLLER in session.texts:
        raise BadInputError(
            f"{session.path}: a controlled session is not resumed; run it anew with its controller "
            "and reference."
        )
    if "rig.toml" not in session.texts:
        raise BadInputError(
            f"{session.path}: holds no rig.toml; only a session that labrig has recorded can be "
            "resumed."
        )
    rig = parse_rig(session.texts["rig.toml"], f"{session.path}: rig.toml")
    if not isinstance(rig, RigConfig):
        raise BadInputError(f"{session.path}: was recorded from a replay; there is no rig.")
    plan = plan_of_session(session, with_paths_from(rig, session.path.parent))
    return replace(plan, schedule=session.schedule)  # another labrig may have made it otherwise


def output_beside(session: Path) -> Path:
    """Return the default path of a resumed session."""
    return session.with_name(f"{session.stem}-resumed{session.suffix}")


@dataclass(frozen=True)
class Resumption:
    """A session that is resumed. `session` must stay open until its runs are copied."""

    session: RecordedSession

    @property
    def done(self) -> frozenset[int]:
        """Return the runs that are complete, and of which a reading counts, or of their repeat."""
        complete = [run.planned for run in self.session.runs if run.completed]
        counting = [run.planned for run in self.session.runs if run.completed and _counts(run)]
        some = {one.index for one in counting} | {one.repeats for one in counting}
        return frozenset(one.index for one in complete if one.index in some)

    def check(self, plan: Plan) -> None:
        """BadInputError unless the plan is the session's, and something is left to do."""
        path = self.session.path
        if {run.index for run in self.session.schedule.runs} <= self.done:
            raise BadInputError(f"{path}: all its runs are complete; there is nothing to resume.")
        names = dict.fromkeys((*self.session.texts, *plan.texts))
        other = [
            name
            for name in names
            if name != ABOUT  # another person may continue it
            and self.session.texts.get(name) != plan.texts.get(name)
        ]
        if other:
            raise BadInputError(
                f"{path}: {', '.join(other)} is not what this session was begun with; leave the "
                "files out, and those that the session holds are used, or begin a new session."
            )
        # A session from before there were repeats has none, and is resumed all the same.
        then = replace(self.session.schedule, repeats=plan.schedule.repeats)
        if plan.schedule != then:
            raise BadInputError(
                f"{path}: this labrig makes another schedule of the same protocol; leave the files "
                "out to use the session's own, or finish it with the version that began it "
                f"({self.session.versions.get('labrig', 'not known')})."
            )

    def check_rig(self, rig: Rig) -> None:
        """Raise BadInputError unless the open rig's signals and images are those of the session."""
        session = self.session
        shape, dtype = None, session.frame_dtype
        if rig.camera is not None:
            shape, dtype = rig.camera.frame_shape, rig.camera.dtype.name
        found: dict[str, tuple[Any, Any]] = {
            "the input channels": (tuple(rig.signals.channels), session.channels),
            "the input ranges": (tuple(rig.signals.ranges_V), session.ranges_V),
            "the sample rate": (rig.signals.rate_hz, session.rate_hz),
            "the camera's image": ((shape, dtype), (session.frame_shape, session.frame_dtype)),
        }
        for what, (now, then) in found.items():
            if now != then:
                raise BadInputError(
                    f"{session.path}: {what} is {now} now and was {then} when this session was "
                    "begun; begin a new one."
                )

    def publish(self, handle: Callable[[ev.Event], None], now_s: float) -> None:
        """Publish the events of the complete runs again, on the clock that shows `now_s`."""
        shift_s = self._shift_s(now_s)
        began_s = self.session.events[0].time_s if self.session.events else 0.0
        done = tuple(sorted(self.done))
        copied = {**self.session.continues, self.session.identifier: done}  # runs copied twice, too
        for whose, runs in copied.items():
            handle(ev.Resumed(began_s + shift_s, whose, runs))
        for run in self.session.runs:
            if run.planned.index in done:
                moves = moves_of(self.session, run, shift_s)
                for event in _events_of(run, shift_s, moves):
                    handle(event)

    def _shift_s(self, now_s: float) -> float:
        """From the session's clock to the present one: by the time of day, which both know.

        A virtual clock has nothing to do with that, nor has a clock that was not set: such a
        session ends now. None ends later, also where the clock was set back since.
        """
        session = self.session
        if session.duration_s is None:
            return now_s
        ends_now_s = now_s - (session.began_s + session.duration_s)
        if _on_virtual_clock(session) or not session.started:
            return ends_now_s
        started = dt.datetime.fromisoformat(session.started)
        if started.year < _CLOCK_NOT_SET:
            return ends_now_s
        ago_s = (dt.datetime.now(dt.UTC) - started).total_seconds()
        return min(now_s - ago_s - session.started_s, ends_now_s)


def _on_virtual_clock(session: RecordedSession) -> bool:
    """Whether its boards were simulated in the process that recorded it."""
    tables = session.resolved.get("rig", {}).values()
    return any(isinstance(each, dict) and each.get("address") == SIMULATED for each in tables)


def _counts(run: RunRecord) -> bool:
    """Return whether any of a run's readings counts; one that takes none does."""
    kept = [row for row in run.readings if str(row["kind"]) != ReadingKind.DISCARDED.value]
    return not kept or any(bool(row["valid"]) for row in kept)


def _events_of(run: RunRecord, shift_s: float, moves: Iterable[ev.Event]) -> Iterator[ev.Event]:
    """Yield the events of a complete run, in an order in which they might have come."""
    planned, counts = run.planned, run.counts
    zero_s = run.time_zero_s + shift_s
    clock = run.sample_clock
    clock = type(clock)(clock.start_s + shift_s, clock.start_uncertainty_s, clock.rate_hz)
    shape = run.image(0).shape if run.frame_count else None
    yield ev.RunStarted(
        time_s=zero_s,
        run=planned,
        sample_clock=clock,
        channels=run.channels,
        frame_shape=None if shape is None else (shape[0], shape[1]),
        stage_position_m=run.stage_position_m,
        since_wetting_s=run.since_wetting_s,
    )
    yield from _writes(run, shift_s)
    yield from moves
    volts = np.stack([run.signal_V(name) for name in run.channels])
    for first in range(0, volts.shape[1], _BLOCK):
        block = SignalBlock(first, volts[:, first : first + _BLOCK].copy(), zero_s)
        yield ev.SignalsArrived(zero_s, planned.index, block)
    yield from _readings(run, zero_s)
    for mark in run.standing_marks.values():
        yield ev.ReadingMarked(
            zero_s + planned.duration_s,
            run=planned.index,
            reading=mark.reading,
            why=mark.why,
            who=mark.who,
        )
    yield ev.RunStopped(
        time_s=zero_s + planned.duration_s,
        run=planned.index,
        completed=True,
        lost_samples=counts.lost_samples,
        frames_grabbed=counts.frames_grabbed,
        frames_dropped=counts.frames_dropped,
        frames_incomplete=counts.frames_incomplete,
        frames_missed=counts.frames_missed,
    )


def _writes(run: RunRecord, shift_s: float) -> Iterator[ev.VoltageSet]:
    for row in run.writes:
        before_s, after_s = float(row["before_s"]) + shift_s, float(row["after_s"]) + shift_s
        write = VoltageWrite(float(row["sheet_V"]), float(row["board_V"]), before_s, after_s)
        due_s = float(row["due_s"]) + shift_s
        yield ev.VoltageSet(
            after_s, run=run.planned.index, step=int(row["step"]), due_s=due_s, write=write
        )


def _readings(run: RunRecord, zero_s: float) -> Iterator[ev.ReadingTaken | ev.FramesArrived]:
    """Yield readings in their order, before each the frames kept before its own."""
    index, told = run.planned.index, 0
    for row in run.readings_as_taken:
        its = int(row["frame"])
        others = range(told, its)
        if others:
            yield ev.FramesArrived(zero_s, index, tuple(_frame(run, k, zero_s) for k in others))
        told = max(told, its + 1)
        offset_s = float(row["frame_offset_s"])
        yield ev.ReadingTaken(
            time_s=zero_s,
            run=index,
            planned=run.planned.readings[int(row["index"])],
            sample_index=float(row["sample_index"]),
            sample_time_s=float(row["time_s"]) + zero_s,
            values=run.values(row),
            frame=None if its < 0 else _frame(run, its, zero_s),
            frame_offset_s=None if np.isnan(offset_s) else offset_s,
            valid=bool(row["valid"]),
            why=str(row["why"]),
        )
    for first in range(told, run.frame_count, _FRAMES):
        some = range(first, min(first + _FRAMES, run.frame_count))
        yield ev.FramesArrived(zero_s, index, tuple(_frame(run, k, zero_s) for k in some))


def _frame(run: RunRecord, row: int, zero_s: float) -> Frame:
    device_s = float(run.frame_column("device_time")[row])
    device_number = run.frame_column("device_number")[row]
    trigger_s = float(run.frame_column("trigger_time")[row])
    return Frame(
        number=int(run.frame_column("number")[row]),
        time_s=float(run.frame_column("time")[row]) + zero_s,
        device_time_s=None if np.isnan(device_s) else device_s,
        image=run.image(row),
        device_number=int(device_number) if device_number >= 0 else None,
        trigger_s=None if np.isnan(trigger_s) else trigger_s + zero_s,
    )
