"""Run a plan on a rig and record it."""

from __future__ import annotations

import textwrap
from collections.abc import Callable, Iterator
from contextlib import contextmanager, nullcontext
from dataclasses import dataclass
from pathlib import Path

from drivers.interfaces import RealClock, in_words
from drivers.real_time import EDGES, punctual
from drivers.safe_shutdown import NOT_SAFE, SafetyReport, make_safe
from labrig.check import failures
from labrig.config.about import recorded_about
from labrig.errors import ExitCode, NotReadyError, OutputUnknownError
from labrig.experiment.notices.publish import (
    BlueskyPublisher,
    PublishedSession,
    check_publish,
    document_file,
)
from labrig.experiment.pause import PauseFile
from labrig.experiment.plan import Plan
from labrig.experiment.precautions import precautions
from labrig.experiment.preflight import disk_space, open_rig_checks, refuse_implausible
from labrig.experiment.resume import Resumption
from labrig.experiment.rig.identities import recorded_devices
from labrig.experiment.rig.parts_in_use import parts_in_use
from labrig.experiment.rig.rig import DRIVE, Rig, Step, no_step, opened
from labrig.experiment.safe_shutdown import SafeShutdown, safe_shutdown
from labrig.experiment.watchdog import Watchdog, watched
from labrig.foreign_code import foreign_place
from labrig.session import SessionWriter, WriterError
from labrig.session.bluesky.streams import Document
from labrig.session.format.devices import REPLAY_OF, any_simulated
from protocols import SafetyLimits
from protocols.execution.event_bus import EventBus
from protocols.execution.events import Event, Outcome, OutputState, RunStarted, RunStopped, Warned
from protocols.execution.rules import Rules
from protocols.execution.scheduler import Scheduler
from protocols.execution.states import Status
from protocols.execution.stop import Pause, StopRequest


@dataclass(frozen=True, repr=False)
class Result:
    """How a session ended."""

    path: Path
    outcome: Outcome
    status: Status

    @property
    def code(self) -> ExitCode:
        """The exit code that says so; that of an output which may be live outranks all others."""
        if self.status.output is not OutputState.SAFE:
            return ExitCode.OUTPUT_UNKNOWN
        if self.outcome is Outcome.COMPLETED:
            return ExitCode.DONE
        if self.outcome is Outcome.ABORTED:
            return ExitCode.STOPPED
        return ExitCode.FAILED if self.status.energised_once else ExitCode.NOT_READY

    @property
    def text(self) -> str:
        """How it ended, and what is known of the output now: it says what `code` says."""
        text = f"{self.outcome.value}: {self.status.text.rstrip('.')}"
        if self.status.output is OutputState.SAFE:
            return f"{text}; the output is at 0 V, read back"
        return text if NOT_SAFE in text else f"{text}; {NOT_SAFE}: switch the amplifier off by hand"

    def __repr__(self) -> str:
        """Return the file and the whole text: what is known of the output is never cut."""
        return "\n".join(textwrap.wrap(f"{self.path}: {self.text}", 100))


def run_session(
    rig: Rig,
    plan: Plan,
    path: Path,
    stop: StopRequest,
    event_bus: EventBus,
    *,
    check_first: bool = True,
    resumption: Resumption | None = None,
    on_scheduler: Callable[[Scheduler], None] | None = None,
    on_step: Step = no_step,
    on_simulated: Callable[[bool], None] = lambda _: None,
) -> Result:
    """Open the rig, check that it is ready, run the whole schedule, record it at `path`.

    `event_bus` is the one that the rig was wired with; the session file joins its subscribers.
    Without `check_first` the devices are taken as they are: a recording shows nothing between its
    runs.
    The complete runs of a `resumption` are copied instead of run.
    `on_step` is called with each step of the beginning, in words, `on_simulated` with what the
    file says of the rig: boards that are simulated elsewhere report it once they are open.
    Raises NotReadyError before the first voltage, BadInputError when `path` cannot be written or
    the plan has a number that nobody can mean.
    """
    result: Result | None = None
    check_publish(rig.config.publish)
    if check_first:
        refuse_implausible(plan)
    try:
        with opened(rig, on_step), _ending_safely(rig, stop) as shutdown:
            if check_first:
                on_step("checking boards, load cell and camera")
                _require_ready(rig, plan, path)
            job = _Job(
                rig=rig,
                plan=plan,
                warnings=tuple(_warnings(plan)) if check_first else (),
                stop=stop,
                event_bus=event_bus,
                shutdown=shutdown,
                on_step=on_step,
                on_simulated=on_simulated,
            )
            result = _record(job, path, resumption, on_scheduler)
    except OutputUnknownError:
        # Of closing the devices. How the session ended says more, and what is known of the output.
        if result is None:
            raise
    return result


@contextmanager
def _ending_safely(rig: Rig, stop: StopRequest) -> Iterator[SafeShutdown]:
    """Shut down safely; an error that ends the run, or its recording, says how the output is."""
    with safe_shutdown(rig, stop.obey) as shutdown:
        try:
            yield shutdown
        except BaseException as error:
            found = shutdown.report or shutdown.make_safe()
            if isinstance(error, WriterError) and found.is_safe:
                raise WriterError(f"The output is at 0 V, read back. {error}") from error
            if found.is_safe:
                raise
            ended = f"{found.text}; what ended the run: {in_words(error)}"
            raise OutputUnknownError(ended) from error


@dataclass(frozen=True, kw_only=True)
class _Job:
    """What is run, on what, and how it is stopped and shut down."""

    rig: Rig
    plan: Plan
    warnings: tuple[str, ...]  # recorded with the session
    stop: StopRequest
    event_bus: EventBus
    shutdown: SafeShutdown
    on_step: Step
    on_simulated: Callable[[bool], None]


def _record(
    job: _Job,
    path: Path,
    resumption: Resumption | None,
    on_scheduler: Callable[[Scheduler], None] | None,
) -> Result:
    rig, event_bus = job.rig, job.event_bus
    if resumption is not None:
        resumption.check_rig(rig)
    job.on_step("making the session file")
    writer = _writer(job, path)
    pause = PauseFile(path)
    pause.forget()
    event_bus.add_required("the session file", writer.handle)
    try:
        if rig.config.publish is not None:
            publish = document_file(rig.config.publish.bluesky)
            event_bus.add_best_effort("the publisher", _publisher(writer, publish))
        if resumption is not None:
            resumption.publish(writer.handle, rig.clock.now())
        if not rig.config.is_simulated:
            job.on_step("starting the output guard")
        for text in job.warnings:
            event_bus.emit(Warned(rig.clock.now(), text))
        with watched(rig, path) as watchdog:
            job.shutdown.watchdog = watchdog
            job.shutdown.tell = lambda text: event_bus.emit(Warned(rig.clock.now(), text))
            event_bus.add_required("the output guard", _run_counter(watchdog))
            scheduler = _scheduler(job, pause)
            if on_scheduler is not None:
                on_scheduler(scheduler)
            with punctual(EDGES) if isinstance(rig.clock, RealClock) else nullcontext():
                outcome = scheduler.run(job.plan.schedule, resumption.done if resumption else ())
    finally:
        event_bus.close()
        writer.close()
        pause.forget()
    return Result(path, outcome, scheduler.status)


def _run_counter(watchdog: Watchdog) -> Callable[[Event], None]:
    """Return a subscriber that says when a run begins, and when it is over."""

    def follow(event: Event) -> None:
        if isinstance(event, RunStarted):
            watchdog.new_run()
        elif isinstance(event, RunStopped):
            watchdog.run_over()

    return follow


def _warnings(plan: Plan) -> Iterator[str]:
    """Yield what the operator should know of the computer before the first voltage."""
    for check in precautions(plan):
        if check.warning:
            yield check.in_words


def _require_ready(rig: Rig, plan: Plan, path: Path) -> None:
    """Repeat the preflight: a device that was there an hour ago may have been unplugged.

    And look at the disk on which the session will be, which only this run knows.
    """
    checks = [disk_space([plan], path.parent), *open_rig_checks(rig, plan)]
    if not all(check.ok for check in checks):
        raise NotReadyError(f"The rig is not ready: {failures(checks)}.")


def _writer(job: _Job, path: Path) -> SessionWriter:
    rig, plan = job.rig, job.plan
    camera, replayed = rig.camera, rig.replayed
    if replayed is None:
        devices = recorded_devices(rig, plan)
        simulated = rig.config.is_simulated or any_simulated(devices)
        parts = parts_in_use(rig.config, plan.schedule)
    else:  # what was measured comes from the devices of that session
        devices, simulated = replayed.devices, replayed.simulated
        parts = {REPLAY_OF: replayed.identifier}
    job.on_simulated(simulated)
    return SessionWriter(
        path,
        schedule=plan.schedule,
        texts=plan.texts,
        resolved=plan.resolved(),
        channels=rig.devices().rows().channels,
        rate_hz=rig.signals.rate_hz,
        frame_shape=None if camera is None else camera.frame_shape,
        frame_dtype="uint8" if camera is None else camera.dtype,
        keep_all_frames=plan.protocol.camera.keep_all_frames,
        simulated=simulated,
        devices=devices,
        parts=parts,
    )


def _publisher(writer: SessionWriter, publish: Callable[[Document], None]) -> BlueskyPublisher:
    """Return what publishes the session while it runs."""
    setup = writer.setup
    session = PublishedSession(
        identifier=setup.identifier,
        path=writer.path,
        protocol=setup.schedule.protocol,
        about=recorded_about(setup.texts),
        versions=dict(setup.versions),
        simulated=setup.simulated,
        channels=setup.signals,
        rate_hz=setup.rate_hz,
    )
    return BlueskyPublisher(session, publish)


def _confirm_zero(rig: Rig) -> SafetyReport:
    """Write 0 V and read it back between two runs; every device stays open."""
    return make_safe(rig.output, rig.read_back, rig.clock, DRIVE, rig.config.limits.safe_below_V)


def _scheduler(job: _Job, pause: PauseFile) -> Scheduler:
    rig, plan, shutdown = job.rig, job.plan, job.shutdown
    limits = rig.config.limits
    return Scheduler(
        rig.devices(),
        rig.clock,
        job.event_bus.emit,
        job.stop,
        SafetyLimits(limits.sheet_voltage_V, limits.time_under_voltage_s),
        shutdown.make_safe,
        rules=Rules(late_edge_s=plan.protocol.rules.late_edge_s, safe_below_V=limits.safe_below_V),
        beat=shutdown.watchdog.beat,
        on_energised=shutdown.watchdog.energised,
        pause=Pause(pause, lambda: _confirm_zero(rig)),
        feedback=None if plan.controller is None else plan.controller.feedback(),
        whose=foreign_place,
        keep_all_frames=plan.protocol.camera.keep_all_frames,
    )
