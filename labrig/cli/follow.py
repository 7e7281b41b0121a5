"""Runs a session and shows how it goes."""

from __future__ import annotations

import sys
import tempfile
from collections.abc import Collection, Iterator
from contextlib import contextmanager
from dataclasses import replace
from pathlib import Path

import typer

from labrig.api.run import recorded, session_hooks, tell_of_doubts
from labrig.cli.screen import Advance, progress, say, warn
from labrig.config import read_text
from labrig.config.about import FILE as ABOUT
from labrig.experiment.notices.hooks import NotifyingOperator
from labrig.experiment.operator import ConsoleOperator, NoOperator
from labrig.experiment.plan import ControlFiles, Plan, load_plan
from labrig.experiment.replay import replay_plan, replay_rig
from labrig.experiment.resume import Resumption, output_beside, resumed_plan
from labrig.experiment.run import Result, run_session
from labrig.experiment.signals import stop_signals
from labrig.session import open_session
from protocols import PlannedRun, Schedule
from protocols.execution.channels import FORCE_N
from protocols.execution.event_bus import EventBus
from protocols.execution.events import (
    Event,
    Outcome,
    OutputChanged,
    OutputState,
    ReadingTaken,
    RunStarted,
    RunStopped,
    SessionStopped,
    Warned,
)
from protocols.execution.stop import SignalledStop, StopLevel, StopRequest
from protocols.reasons import in_short

_MOST_LINES = 3  # of readings that do not count, in one run; then its end says how many
_MOVE_S = 20.0  # at the rig, between two runs: a move and a moistening
_AFTER_PULSE = "stopping after this pulse; Ctrl-C once more: at once"

FOLLOWS = "follows.txt"  # among a session's texts: the identifier of the one it adds to

Files = tuple[Path, Path, Path]  # rig.toml, protocol.toml, sheet.toml


def run_and_follow(
    rig: Path,
    protocol: Path,
    sheet: Path,
    output: Path,
    *,
    yes: bool,
    about: Path | None = None,
    follows: str = "",
    earlier: int = 0,
    control: ControlFiles | None = None,
) -> Result:
    """`labrig run`: read the files, run the schedule, show the progress.

    `follows`: identifier of the session that this one adds to; it is kept with the session's files.
    `earlier`: how many sessions there are already that it is taken together with.
    """
    plan = replace(load_plan(rig, protocol, sheet, about, control), earlier=earlier)
    if follows:
        plan = replace(plan, texts={**plan.texts, FOLLOWS: follows})
    return _run(plan, output, None, yes=yes)


def resume_and_follow(
    path: Path,
    files: Files | None,
    output: Path | None,
    *,
    yes: bool,
    about: Path | None = None,
) -> Result:
    """`labrig run --resume`: the runs of a session that are not complete.

    People and sample stay those of the session, unless `about` states others.
    """
    with open_session(path) as session:
        resumption = Resumption(session)
        plan = resumed_plan(session) if files is None else load_plan(*files)
        if about is not None:
            plan = plan.with_about(read_text(about), str(about))
        elif ABOUT in session.texts:
            plan = plan.with_about(session.texts[ABOUT])
        resumption.check(plan)
        return _run(plan, output or output_beside(path), resumption, yes=yes)


def _run(plan: Plan, output: Path, resumption: Resumption | None, *, yes: bool) -> Result:
    tell_of_doubts(plan, warn)
    operator = NoOperator(warn) if yes else ConsoleOperator(warn)
    stop = StopRequest()
    event_bus = EventBus(threaded=not plan.rig.is_simulated)
    done = resumption.done if resumption else frozenset()
    with (
        _stopping(stop, operator),  # first: nothing may be lost while hooks are waited for
        session_hooks(plan, output, warn) as hooks,
        _display(plan.schedule, stop, done, pace=not plan.rig.is_simulated) as show,
    ):
        event_bus.add_best_effort("the progress display", show)
        asked = operator if yes else NotifyingOperator(operator, hooks)
        return recorded(
            plan, output, asked, event_bus, stop, hooks=hooks, resumption=resumption, step=show.step
        )


def replay_and_follow(session_path: Path, output: Path | None) -> Result:
    """`labrig replay`: play a session; it is recorded in a file only if `output` is given."""
    with open_session(session_path) as session, tempfile.TemporaryDirectory() as folder:
        path = output or Path(folder) / "replay.h5"
        plan: Plan = replay_plan(session)
        stop = StopRequest()
        rig, director = replay_rig(session, plan, stop)
        event_bus = EventBus(threaded=False)
        # Before the session file: it must know the run before the first sample is asked for.
        event_bus.add_required("the recording", director.follow)
        with _stopping(stop, None), _display(plan.schedule, stop, frozenset(), pace=False) as show:
            event_bus.add_best_effort("the progress display", show)
            result = run_session(rig, plan, path, stop, event_bus, check_first=False)
        return result if output else replace(result, path=session_path)  # the other file is gone


def finish(result: Result) -> None:
    """Print how a session ended; exit with its code unless that is 0."""
    text = f"{result.path}: {result.text}."
    if result.code:
        warn(f"labrig: {text}")
        raise typer.Exit(int(result.code))
    say(text)


@contextmanager
def _stopping(stop: StopRequest, operator: ConsoleOperator | NoOperator | None) -> Iterator[None]:
    ask = SignalledStop(stop)

    def on_stop(name: str, count: int) -> None:
        ask(name, count)
        if operator is not None and operator.waiting:
            raise KeyboardInterrupt

    with stop_signals(on_stop):
        yield


@contextmanager
def _display(
    schedule: Schedule, stop: StopRequest, done: Collection[int], *, pace: bool
) -> Iterator[RunDisplay]:
    with progress("session") as advance:
        yield RunDisplay(schedule, advance, stop, move_s=_MOVE_S if pace else 0.0, done=done)


class RunDisplay:
    """Follows a session: a bar with what is being done, and a line for whatever matters."""

    def __init__(
        self,
        schedule: Schedule,
        advance: Advance,
        stop: StopRequest,
        move_s: float = 0.0,
        done: Collection[int] = (),
    ) -> None:
        self._advance = advance
        self._stop = stop
        self._stop_reported = False
        self._runs = schedule.runs
        self._whole_s = sum(run.duration_s + move_s for run in schedule.runs)
        self._move_s = move_s
        self._done_s = sum(run.duration_s + move_s for run in schedule.runs if run.index in done)
        self._output = OutputState.UNKNOWN
        self._run: PlannedRun | None = None  # the present or last one
        self._running = False
        self._run_s = 0.0
        self._invalid: list[str] = []  # why, of this run's readings
        self._lost: list[str] = []  # of every run so far, a phrase each

    def step(self, text: str) -> None:
        """Show what is done next before the session begins."""
        if sys.stderr.isatty():
            self._advance(0.0, text)
        else:
            warn(f"session: {text}")

    def __call__(self, event: Event) -> None:
        """See `protocols.execution.event_bus`: called for each event."""
        if self._running and not self._stop_reported and self._stop.level is StopLevel.AFTER_PULSE:
            self._stop_reported = True
            warn(_AFTER_PULSE)
        if isinstance(event, RunStarted):
            self._run, self._running, self._invalid = event.run, True, []
            self._run_s = 0.0
            self._report()
        elif isinstance(event, ReadingTaken) and self._run is not None:
            if not event.valid:
                self._lose(event)
            self._run_s = self._run.time_of(event.planned)
            self._report(f"F = {1e3 * event.values[FORCE_N]:+.2f} mN")
        elif isinstance(event, RunStopped) and self._run is not None:
            self._stop_run(event, self._run)
        elif isinstance(event, OutputChanged):
            self._output = event.state
            self._report()
            if self._running and event.state is OutputState.UNKNOWN:
                warn(f"{event.why}; labrig keeps trying")
        elif isinstance(event, Warned):
            warn(f"warning: {event.text}")
        elif isinstance(event, SessionStopped):
            self._end(event)

    def _stop_run(self, event: RunStopped, run: PlannedRun) -> None:
        self._running = False
        if event.completed and run.repeats is None:
            self._done_s += run.duration_s + self._move_s
            self._run_s = 0.0
        if self._invalid:
            self._lost.append(
                f"run {event.run + 1}: {len(self._invalid)} of {len(run.readings)} "
                f"readings do not count: {in_short(self._invalid)}"
            )
            warn(self._lost[-1])
        if event.losses:
            warn(f"run {event.run + 1}: {event.losses}")

    def _lose(self, event: ReadingTaken) -> None:
        """Report a reading that does not count, unless the run has lost many before it."""
        self._invalid.append(event.why)
        if len(self._invalid) <= _MOST_LINES:
            warn(
                f"run {event.run + 1}, reading {event.planned.index + 1} "
                f"({event.planned.voltage_V:+g} V) does not count: {event.why}"
            )

    def _end(self, event: SessionStopped) -> None:
        """Report how it ended, with what is known of the output now and not during the run."""
        completed = event.outcome is Outcome.COMPLETED
        runs = "1 run" if len(self._runs) == 1 else f"{len(self._runs)} runs"
        where = f"{runs} done" if completed else event.outcome.value
        if not completed and self._run is not None:
            where += f" in {_which(self._run, len(self._runs))}"
        if self._lost:
            warn("warning: readings were lost:")
        for line in self._lost:
            warn(f"  {line}")
        safe = event.output is OutputState.SAFE
        output = "output safe, read back" if safe else f"OUTPUT {event.output.value.upper()}"
        self._advance(1.0 if completed else self._fraction, f"{where} · {output}", last=True)

    @property
    def _fraction(self) -> float:
        return min((self._done_s + self._run_s) / max(self._whole_s, 1e-9), 1.0)

    def _report(self, force: str = "") -> None:
        run = self._run
        if run is None:
            return
        where = "free" if run.position_m is None else f"{1e3 * run.position_m:g} mm"
        if run.extra:
            where += f", {run.in_words}"
        parts = [
            _which(run, len(self._runs)),
            f"{run.configuration}, {where}",
            f"output {self._output.value}",
        ]
        if force:
            parts.append(force)
        self._advance(self._fraction, " · ".join(parts))


def _which(run: PlannedRun, runs: int) -> str:
    if run.repeats is not None:
        return f"run {run.repeats + 1} of {runs} again"
    return f"run {run.index + 1} of {runs}"
