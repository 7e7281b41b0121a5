"""Run a plan on a rig and record it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from drivers.interfaces import DeviceError
from labrig.errors import ExitCode, NotReadyError, OutputUnknownError
from labrig.experiment.plan import Plan
from labrig.experiment.preflight import look
from labrig.experiment.resume import Resumption
from labrig.experiment.rig import Rig, opened
from labrig.experiment.safe_shutdown import SafeShutdown, safe_shutdown
from labrig.experiment.watchdog import Watchdog, watched
from labrig.session import SessionWriter
from protocols import SafetyLimits
from protocols.execution.event_bus import EventBus
from protocols.execution.events import Event, Outcome, OutputState, RunStarted
from protocols.execution.rules import Rules
from protocols.execution.scheduler import Scheduler
from protocols.execution.states import Status
from protocols.execution.stop import StopRequest


@dataclass(frozen=True)
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


def run_session(
    rig: Rig,
    plan: Plan,
    path: Path,
    stop: StopRequest,
    hub: EventBus,
    *,
    look_first: bool = True,
    resumption: Resumption | None = None,
    on_scheduler: Callable[[Scheduler], None] | None = None,
) -> Result:
    """Open the rig, look whether it is ready, run the whole schedule, record it at `path`.

    `hub` is the one that the rig was wired with; the session file joins its subscribers. Without
    `look_first` the devices are taken as they are: a recording shows nothing between its runs.
    The complete runs of a `resumption` are copied instead of run.
    Raises NotReadyError before the first voltage, BadInputError when `path` cannot be written.
    """
    result: Result | None = None
    try:
        with opened(rig), _leaving_safely(rig) as way:
            if look_first:
                _require_ready(rig, plan)
            result = _record(rig, plan, path, stop, hub, way, resumption, on_scheduler)
    except OutputUnknownError:
        # Of closing the devices. How the session ended says more, and what is known of the output.
        if result is None:
            raise
    return result


@contextmanager
def _leaving_safely(rig: Rig) -> Iterator[SafeShutdown]:
    """The way out; an error that comes this way names the output when that is not safe."""
    with safe_shutdown(rig) as way:
        try:
            yield way
        except Exception as error:
            found = way.report or way.make_safe()
            if found.is_safe:
                raise
            raise OutputUnknownError(f"{found.text}; what ended the run: {error}") from error


def _record(
    rig: Rig,
    plan: Plan,
    path: Path,
    stop: StopRequest,
    hub: EventBus,
    way: SafeShutdown,
    resumption: Resumption | None,
    on_scheduler: Callable[[Scheduler], None] | None,
) -> Result:
    if resumption is not None:
        resumption.check_rig(rig)
    writer = _writer(rig, plan, path)
    hub.add_critical("the session file", writer.handle)
    try:
        if resumption is not None:
            resumption.tell(writer.handle, rig.clock.now())
        with watched(rig, path) as watch:
            way.watch = watch
            hub.add_critical("the output guard", _run_counter(watch))
            scheduler = _scheduler(rig, plan, hub.emit, stop, way)
            if on_scheduler is not None:
                on_scheduler(scheduler)
            outcome = scheduler.run(plan.schedule, resumption.done if resumption else ())
    finally:
        hub.close()
        writer.close()
    return Result(path, outcome, scheduler.status)


def _run_counter(watch: Watchdog) -> Callable[[Event], None]:
    """The limit of the time under voltage is one of each run."""

    def follow(event: Event) -> None:
        if isinstance(event, RunStarted):
            watch.new_run()

    return follow


def _require_ready(rig: Rig, plan: Plan) -> None:
    """The preflight's checks once more: what was there an hour ago may have been unplugged."""
    try:
        failed = [check for check in look(rig, plan) if not check.ok]
    except DeviceError as fault:
        raise NotReadyError(str(fault)) from fault
    if failed:
        told = "; ".join(f"{c.name}: {c.found}, wanted {c.wanted}" for c in failed)
        raise NotReadyError(f"The rig is not ready: {told}.")


def _writer(rig: Rig, plan: Plan, path: Path) -> SessionWriter:
    camera = rig.camera
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
        simulated=rig.config.is_simulated,
    )


def _scheduler(
    rig: Rig, plan: Plan, emit: Callable[[Event], None], stop: StopRequest, way: SafeShutdown
) -> Scheduler:
    limits = rig.config.limits
    return Scheduler(
        rig.devices(),
        rig.clock,
        emit,
        stop,
        SafetyLimits(limits.sheet_voltage_V, limits.time_under_voltage_s),
        way.make_safe,
        rules=Rules(late_edge_s=plan.protocol.rules.late_edge_s),
        beat=way.watch.beat,
        on_energised=way.watch.energised,
        keep_all_frames=plan.protocol.camera.keep_all_frames,
    )
