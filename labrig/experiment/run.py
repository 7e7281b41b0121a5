"""Run a plan on a rig and record it."""

from __future__ import annotations

from collections.abc import Callable
from contextlib import AbstractContextManager, nullcontext
from dataclasses import dataclass
from pathlib import Path
from typing import Protocol

from drivers.interfaces import DeviceError
from labrig.errors import ExitCode, NotReadyError, OutputUnknownError
from labrig.experiment.plan import Plan
from labrig.experiment.preflight import look
from labrig.experiment.rig import Rig, opened
from labrig.session import SessionWriter
from protocols import SafetyLimits
from protocols.events import Event, Outcome, OutputState
from protocols.hub import EventHub
from protocols.rules import Rules
from protocols.scheduler import Scheduler
from protocols.states import Status
from protocols.stop import StopRequest


class Watch(Protocol):
    """Watches over the process while the output is energised (the guard)."""

    def beat(self) -> None:
        """The working loop is alive."""

    def energised(self, on: bool) -> None:
        """A voltage other than 0 is about to be written, or 0 V was confirmed."""


class Unwatched:
    """Nobody watches."""

    def beat(self) -> None:
        """See `Watch.beat`."""

    def energised(self, on: bool) -> None:
        """See `Watch.energised`."""


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
    hub: EventHub,
    *,
    look_first: bool = True,
    watch: Callable[[Rig], AbstractContextManager[Watch]] | None = None,
    on_scheduler: Callable[[Scheduler], None] | None = None,
) -> Result:
    """Open the rig, look whether it is ready, run the whole schedule, record it at `path`.

    `hub` is the one that the rig was wired with; the session file joins its subscribers. Without
    `look_first` the devices are taken as they are: a recording shows nothing between its runs.
    Raises NotReadyError before the first voltage, BadInputError when `path` cannot be written.
    """
    result: Result | None = None
    try:
        with opened(rig):
            if look_first:
                _require_ready(rig, plan)
            result = _record(rig, plan, path, stop, hub, watch or _unwatched, on_scheduler)
    except OutputUnknownError:
        # Of closing the devices. How the session ended says more, and what is known of the output.
        if result is None:
            raise
    return result


def _record(
    rig: Rig,
    plan: Plan,
    path: Path,
    stop: StopRequest,
    hub: EventHub,
    watch: Callable[[Rig], AbstractContextManager[Watch]],
    on_scheduler: Callable[[Scheduler], None] | None,
) -> Result:
    writer = _writer(rig, plan, path)
    hub.add_critical("the session file", writer.handle)
    try:
        with watch(rig) as watching:
            scheduler = _scheduler(rig, plan, hub.emit, stop, watching)
            if on_scheduler is not None:
                on_scheduler(scheduler)
            outcome = scheduler.run(plan.schedule)
    finally:
        hub.close()
        writer.close()
    return Result(path, outcome, scheduler.status)


def _unwatched(_rig: Rig) -> AbstractContextManager[Watch]:
    return nullcontext(Unwatched())


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
        channels=rig.signals.channels,
        ranges_V=rig.signals.ranges_V,
        rate_hz=rig.signals.rate_hz,
        frame_shape=None if camera is None else camera.frame_shape,
        frame_dtype="uint8" if camera is None else camera.dtype,
        keep_all_frames=plan.protocol.camera.keep_all_frames,
        simulated=rig.config.is_simulated,
    )


def _scheduler(
    rig: Rig, plan: Plan, emit: Callable[[Event], None], stop: StopRequest, watching: Watch
) -> Scheduler:
    limits = rig.config.limits
    return Scheduler(
        rig.devices(),
        rig.clock,
        emit,
        stop,
        SafetyLimits(limits.sheet_voltage_V, limits.time_under_voltage_s),
        rules=Rules(late_edge_s=plan.protocol.rules.late_edge_s),
        beat=watching.beat,
        on_energised=watching.energised,
        safe_below_V=limits.safe_below_V,
        keep_all_frames=plan.protocol.camera.keep_all_frames,
    )
