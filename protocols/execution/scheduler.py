"""Run a schedule on a clock, and leave the output at 0 V whatever happens.

States of a session (`RunState`), and what is guaranteed in each::

                   run()
        IDLE --------------> PREPARING <-----------------------------.
                                 |                                   |
                                 | operator and stage are done       | next run
                                 v                                   |
                             LEADING_IN                              |
                                 |                                   |
                                 | first step written                |
                                 v        last step, at 0 V          |
                              RUNNING -----------------------> TAILING
                                 |                               |
               stop, answer "no",|                               | last run done,
               fault, exception  |   (also from PREPARING,       | or stop after
                                 |    LEADING_IN and TAILING)    | this pulse
                                 v                               v
                             STOPPING <--------------------------'
                              |     |
         0 V read back        |     |   0 V not confirmed
        FINISHED <------------'     '-----------------> UNKNOWN

=========== ============================= =======================================================
State       Output                        Guarantee
=========== ============================= =======================================================
IDLE        as the caller left it         `run` may be called, once; nothing was written
PREPARING   0 V                           operator and stage may take any time; no acquisition
LEADING_IN  0 V                           signals and camera are acquired before the first step
RUNNING     as the schedule, or the       `beat` at least every 50 ms while energised
            controller says
TAILING     0 V                           acquisition until the last reading is complete and the
                                          read-back shows 0 V; one that does not: STOPPING
PAUSED      0 V, read back                after TAILING, where a pause is asked for; then PREPARING
STOPPING    0 V is written first          `make_safe` is called once; no other voltage is written
FINISHED    0 V, read back                `SessionStopped` was the last event; `status` says why
UNKNOWN     may be live                   as FINISHED; the reason says what hands must do
=========== ============================= =======================================================

Who causes a transition:

- `run` starts the session and carries it from run to run, on the caller's thread.
- `StopRequest.request` may be called from any thread or signal handler. `NOW` is obeyed within
  50 ms. `AFTER_PULSE` is obeyed at once at 0 V, else when the pulse and its reading are over: the
  run then goes through TAILING. Neither can be withdrawn.
- The operator causes STOPPING by answering "no"; so does a stage whose move is not done.
- A device (`DeviceError`), a required subscriber (`SubscriberError`), the overload check or any
  other exception causes STOPPING. 0 V is written before an event is emitted about it.
- `Pause.request` causes PAUSED when the present run is complete and another one follows, and ends
  it; so does a stop. A read-back other than 0 V causes STOPPING.
- `mark` changes no state; it may be called from any thread until FINISHED or UNKNOWN.
"""

from __future__ import annotations

import datetime as dt
import threading
from collections.abc import Callable, Collection
from dataclasses import replace
from functools import partial
from math import isfinite

from drivers.interfaces import Clock, DeviceError, Prompt
from protocols.errors import ScheduleError
from protocols.execution.devices import Devices
from protocols.execution.endings import Whose, reason_of
from protocols.execution.event_bus import SubscriberError
from protocols.execution.events import (
    ActionTaken,
    Event,
    Outcome,
    OutputState,
    ReadingMarked,
    ReadingTaken,
    RunStarted,
    SessionStarted,
    SessionStopped,
    Warned,
)
from protocols.execution.operator import (
    DeclinedError,
    LostReadings,
    RecordedOperator,
    all_done,
    dismounts,
    offers,
)
from protocols.execution.output import GuardedOutput, MakeSafe
from protocols.execution.rules import Rules
from protocols.execution.runs.control_loop import FeedbackLaw
from protocols.execution.runs.run_context import RunContext, Stopped
from protocols.execution.runs.run_loop import RunLoop
from protocols.execution.states import FinishReason, RunState, Status
from protocols.execution.stop import Pause, StopLevel, StopRequest, wait_for_end
from protocols.planning.limits import SafetyLimits, check_schedule, limit_faults
from protocols.planning.loop_timing import LoopTiming
from protocols.planning.preparation import Action, Move, Situation, preparation
from protocols.planning.schedule import PlannedRun, Schedule


def utc_now() -> str:
    """Return the time of day as ISO 8601, UTC."""
    return dt.datetime.now(dt.UTC).isoformat(timespec="milliseconds")


def _no_beat() -> None:
    """Nobody watches over this process."""


def _no_guard(energised: bool) -> None:
    """Nobody watches over this process."""


def _nobodys(error: BaseException) -> str | None:
    """Nobody knows of other distributions."""


class Scheduler:
    """Execute one schedule; the module's docstring has the states and their guarantees.

    The devices are open, and stay so; the caller closes them. `run` raises ScheduleError, before
    anything is touched, when the schedule is not within the limits.

    `beat` is called at least every 50 ms while the sheet is energised, `on_energised` before the
    first voltage and after 0 V was confirmed: they feed a guard process. `make_safe` is called
    once, at the end, however that comes. `emit` may raise: the session then ends safely. It must
    not block for long: a guard takes that for a hang.
    """

    def __init__(
        self,
        devices: Devices,
        clock: Clock,
        emit: Callable[[Event], None],
        stop: StopRequest,
        limits: SafetyLimits,
        make_safe: MakeSafe,
        *,
        rules: Rules | None = None,
        timing: LoopTiming | None = None,
        beat: Callable[[], None] = _no_beat,
        on_energised: Callable[[bool], None] = _no_guard,
        keep_all_frames: bool = False,
        pause: Pause | None = None,
        feedback: FeedbackLaw | None = None,
        whose: Whose = _nobodys,
        wall: Callable[[], str] = utc_now,
    ) -> None:
        self._devices = devices
        self._clock = clock
        self._subscribers = emit
        self._stop = stop
        self._limits = limits
        self._rules = rules or Rules()
        timing = timing or LoopTiming()
        self._make_safe = make_safe
        self._whose = whose
        self._wall = wall
        self._pause = pause
        self._feedback = feedback
        self._emit_lock = threading.RLock()
        operator = devices.operator
        if not isinstance(operator, RecordedOperator):
            operator = RecordedOperator(operator, clock, self._emit)
        self._operator: RecordedOperator = operator
        self._output = GuardedOutput(devices.output, clock, self._emit, on_energised)
        self._context = RunContext(
            devices=devices,
            output=self._output,
            clock=clock,
            emit=self._emit,
            stop=stop,
            beat=beat,
            enter=self._enter,
            rules=self._rules,
            timing=timing,
            keep_all_frames=keep_all_frames,
            limit_V=limits.sheet_voltage_V,
            longest_timed_s=limits.time_under_voltage_s,
        )
        self._status = Status()
        self._situation = Situation()
        self._wetted_s: float | None = None
        self._started: set[int] = set()
        self._acquired: set[tuple[int, int]] = set()
        self._lost = LostReadings()
        self._mounted: list[PlannedRun] = []  # done since the sheet was mounted

    @property
    def status(self) -> Status:
        """Snapshot of the session: its state, or why it ended. May be read from any thread."""
        return self._status

    def run(self, schedule: Schedule, done: Collection[int] = ()) -> Outcome:
        """Execute the runs in their order, except those that are `done` (a session resumed)."""
        if self._status.state is not RunState.IDLE:
            raise ScheduleError("a scheduler runs one session; make another one")
        limit_V = min(self._limits.sheet_voltage_V, self._devices.output.limit_V)
        check_schedule(schedule, replace(self._limits, sheet_voltage_V=limit_V))
        if self._feedback is None and any(one.reference for one in schedule.runs):
            raise ScheduleError("a run has a reference for the force, and there is no controller")
        if self._feedback is not None:
            self._feedback = self._feedback.within(limit_V)
        try:
            self._run_all(schedule, done)
        except BaseException as error:
            outcome = self._finish(partial(reason_of, error, self._whose), error)
            internal = self._status.finish is FinishReason.INTERNAL_ERROR
            if internal and not isinstance(error, Exception):
                raise  # the interpreter is being ended
            return outcome
        return self._finish(lambda: (FinishReason.COMPLETED, self._all_done(schedule)), None)

    def _all_done(self, schedule: Schedule) -> str:
        """Return how it ended. What was measured again counts in the second run."""
        again = {run.repeats for run in schedule.repeats if run.index in self._started}
        return all_done(
            (run for run in schedule.all_runs if run.index in self._started - again), self._lost
        )

    def mark(self, run: int, reading: int | None, why: str, who: str) -> None:
        """Declare a reading (None: a whole run) invalid. May be called from any thread.

        Raises ScheduleError for what has not been acquired yet or when the session is over.
        """
        with self._emit_lock:
            if self._status.state in (RunState.FINISHED, RunState.UNKNOWN):
                raise ScheduleError("the session is over; mark the reading in its file")
            if run not in self._started:
                raise ScheduleError(f"run {run + 1} has not begun, so nothing of it can be marked")
            if reading is not None and (run, reading) not in self._acquired:
                raise ScheduleError(
                    f"reading {reading + 1} of run {run + 1} has not been acquired yet"
                )
            self._emit(ReadingMarked(self._clock.now(), run=run, reading=reading, why=why, who=who))

    def _run_all(self, schedule: Schedule, done: Collection[int]) -> None:
        self._enter(RunState.PREPARING)
        self._emit(SessionStarted(self._clock.now(), self._wall()))
        self._devices.rows()
        self._output.write(0.0)
        self._output.report("the session begins at 0 V")
        before: PlannedRun | None = None
        for run in schedule.runs:
            if run.index in done:
                continue
            if before is not None:
                self._pause_if_asked(before, run)
            if dismounts(preparation(self._situation, run)[0]):
                self._offer_repeats(schedule)
            self._execute(run, schedule)
            self._mounted.append(run)
            before = run
        self._offer_repeats(schedule)

    def _execute(self, run: PlannedRun, schedule: Schedule) -> None:
        self._enter(RunState.PREPARING, run.index)
        stage_position_m = self._prepare(run)
        RunLoop(
            self._context,
            run,
            schedule.frame_rate_hz,
            stage_position_m,
            self._wetted_s,
            self._feedback,
        ).execute()

    def _offer_repeats(self, schedule: Schedule) -> None:
        """Ask whether runs with lost readings are to be measured again, the sheet as it is."""
        mounted, self._mounted = self._mounted, []
        for prompt, repeat in offers(schedule, mounted, self._lost):
            if any(limit_faults(repeat, self._limits)):  # its approach may be beyond the stage
                continue
            self._enter(RunState.PREPARING)
            go_on = self._ask(prompt)
            self._obey_stop()
            if not go_on:
                self._execute(repeat, schedule)

    def _pause_if_asked(self, before: PlannedRun, after: PlannedRun) -> None:
        """Keep 0 V, read back, while a pause is wanted. Time passes on a virtual clock, too."""
        pause = self._pause
        if pause is None or not (who := pause.request.asked_by()):
            return
        self._enter(RunState.PAUSED)
        began_s, found = self._clock.now(), self._output.settle(pause.confirm_zero)
        if self._output.state is not OutputState.SAFE:
            raise DeviceError(f"the session was to pause, but {found}")
        self._enter(RunState.PAUSED)
        self._output.report(found)
        self._note(who, f"paused the session after run {before.index + 1}")
        waited_s = wait_for_end(pause.request, self._stop)
        self._clock.sleep_until(began_s + waited_s)
        self._obey_stop()
        self._note("labrig", f"continues with run {after.index + 1}")

    def _note(self, who: str, what: str) -> None:
        self._emit(ActionTaken(self._clock.now(), who, what))

    def _prepare(self, run: PlannedRun) -> float | None:
        """Ask and move; return the position that the stage reports."""
        self._obey_stop()
        actions, after = preparation(self._situation, run)
        for action in actions:
            done, request = self._have_done(action)
            self._obey_stop()
            if not done:
                raise DeclinedError(f"the operator was asked {request} and stopped the session")
        self._situation = after
        return self._reported_position(run)

    def _have_done(self, action: Action) -> tuple[bool, str]:
        """Return whether something has been done, and what the operator was asked for, in words."""
        if not isinstance(action, Move):
            return self._ask(action), f"({action.text})"
        request = f"to move the load cell to {action.position_m * 1e3:g} mm"
        return self._devices.move_stage(action.position_m), request

    def _ask(self, prompt: Prompt) -> bool:
        done = self._operator.ask(prompt)
        if done and prompt.kind == "moisten":
            self._wetted_s = self._clock.now() if self._operator.is_present else None
        return done

    def _reported_position(self, run: PlannedRun) -> float | None:
        if run.position_m is None:
            return None
        reported_m = self._devices.stage_position_m()
        if reported_m is None:
            return None
        known = isfinite(reported_m)
        if not abs(reported_m - run.position_m) <= self._rules.position_tolerance_m:
            said = f"{reported_m * 1e3:.2f} mm"
            if not known:
                said = f"{reported_m} as its position, which is no number,"
            wanted = f"where run {run.index + 1} wants {run.position_m * 1e3:g} mm"
            self._emit(Warned(self._clock.now(), f"the stage reports {said} {wanted}"))
        return reported_m if known else None

    def _obey_stop(self) -> None:
        if self._stop.level is not StopLevel.NONE:
            raise Stopped.by(self._stop)

    def _enter(self, state: RunState, run: int | None = None) -> None:
        self._status = replace(
            self._status,
            state=state,
            run=self._status.run if run is None else run,
            output=self._output.state,
            energised_once=self._output.energised_once,
        )

    def _emit(self, event: Event) -> None:
        """One event at a time, whichever thread it comes from."""
        with self._emit_lock:
            if isinstance(event, RunStarted):
                self._started.add(event.run.index)
            elif isinstance(event, ReadingTaken):
                self._acquired.add((event.run, event.planned.index))
                self._lost.note(event)
            try:
                self._subscribers(event)
            except SubscriberError:
                raise
            except Exception as error:
                raise SubscriberError(f"{type(error).__name__}: {error}") from error

    def _finish(
        self, why: Callable[[], tuple[FinishReason, str]], error: BaseException | None
    ) -> Outcome:
        """Make safe, emit the end, and settle the status; never raises.

        `why` it ended is asked at 0 V: to find whose part failed takes a while.
        """
        self._enter(RunState.STOPPING)
        found = self._output.settle(self._make_safe)
        finish, text = why()
        self._context.guarded(
            "reporting the state of the output", lambda: self._output.report(found)
        )
        state = self._output.state
        # What hands must do comes first, however much there is to say.
        reason = text if state is OutputState.SAFE else f"{found}; what ended the session: {text}"
        with self._emit_lock:
            try:
                self._emit(
                    SessionStopped(
                        self._clock.now(),
                        outcome=finish.outcome,
                        reason=reason,
                        output=state,
                        wall=self._wall(),
                    )
                )
            except Exception as failed:  # noqa: BLE001 - only the caller is left to know
                if finish is FinishReason.COMPLETED:
                    finish, error = FinishReason.RECORDING_FAULT, failed
                    reason = f"all runs are done, but their end could not be recorded: {failed}"
            safe = state is OutputState.SAFE
            self._status = Status(
                state=RunState.FINISHED if safe else RunState.UNKNOWN,
                run=self._status.run,
                output=state,
                finish=finish,
                text=reason,
                energised_once=self._output.energised_once,
                error=error,
            )
        return finish.outcome
