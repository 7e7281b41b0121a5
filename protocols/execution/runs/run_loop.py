"""Execute one run: edges at their times, everything else in between."""

from __future__ import annotations

from dataclasses import replace

from drivers.interfaces import (
    Camera,
    CameraCounts,
    DeviceError,
    DeviceTimeoutError,
    FrameTrigger,
    VoltageWrite,
    in_words,
)
from protocols.execution.devices import StageMove
from protocols.execution.events import (
    LoadCellArrived,
    LoadCellLeft,
    RunStarted,
    RunStopped,
    SignalsArrived,
    VoltageSet,
)
from protocols.execution.readings import ReadingMaker
from protocols.execution.runs.control_loop import ControlLoop, FeedbackLaw
from protocols.execution.runs.exposures import Exposures
from protocols.execution.runs.read_back import ReadBack
from protocols.execution.runs.run_context import RunContext, Stopped
from protocols.execution.runs.timed_run import BoardTimedRun, load_timed
from protocols.execution.states import RunState
from protocols.execution.stop import StopLevel
from protocols.planning.schedule import PlannedMove, PlannedRun

# Making safe continues, and may take its time; until then only hands can act.
NOT_ZERO = "0 V COULD NOT BE WRITTEN: switch the amplifier off by hand ({why})"
OVERDUE_S = 0.5  # service so long overdue happens although an edge is near


class RunLoop:
    """One run, from the start of the acquisition to its end.

    Edges have priority: between them the loop reads signals, frames and the stop request every
    `LoopTiming.service_s`, but not when the next edge is nearer than that takes. Whatever is
    raised, by a device or by a subscriber, 0 V is written before anything else happens.
    """

    def __init__(
        self,
        context: RunContext,
        run: PlannedRun,
        frame_rate_hz: float,
        stage_position_m: float | None,
        wetted_at_s: float | None,
        feedback: FeedbackLaw | None = None,
    ) -> None:
        self._context = context
        self._run = run
        self._frame_rate_hz = frame_rate_hz
        self._stage_position_m = stage_position_m
        self._wetted_at_s = wetted_at_s
        self._rows = context.devices.rows()
        self._feedback = feedback
        self._control: ControlLoop | None = None
        self._timed: BoardTimedRun | None = None
        self._maker: ReadingMaker | None = None
        self._zero_s = 0.0  # clock time of the run's time 0
        self._next_service_s = 0.0
        self._last_sample_s = 0.0
        self._read_back: ReadBack | None = None
        self._cost_s = 0.0  # of servicing, recently
        self._keep_all_frames = context.keep_all_frames or run.keep_all_frames
        self._exposures: Exposures | None = None  # of a camera that is triggered

    def execute(self) -> None:
        """Run it. Raises Stopped, DeviceError, or whatever else went wrong; at 0 V in any case."""
        completed = False
        try:
            maker = self._begin()
            completed = self._steps(maker)
            self._tail(maker)
        except BaseException as fault:
            self._return_to_zero("the run was broken off", fault)
            self._end(completed=False)
            raise
        self._end(completed=completed)
        if not completed:
            raise Stopped.by(self._context.stop)

    def _begin(self) -> ReadingMaker:
        """Start camera and signals; the first step is due a lead-in later."""
        context, devices = self._context, self._context.devices
        context.enter(RunState.LEADING_IN)
        frame_shape = None
        if devices.camera is not None:
            devices.camera.start()
            frame_shape = devices.camera.frame_shape
            if devices.trigger is not None:
                self._exposures = self._triggered(devices.camera, devices.trigger)
            if self._keep_all_frames or devices.trigger is not None:
                devices.camera.want_all()
        self._timed = load_timed(context, self._run)
        sample_clock = devices.signals.start()
        now_s = context.clock.now()
        self._read_back = ReadBack(context.rules, context.limit_V, sample_clock.rate_hz, now_s)
        self._zero_s = now_s + context.timing.lead_in_s
        if self._timed is not None:
            self._zero_s = self._timed.begin(sample_clock)
            context.beat()
        self._next_service_s = self._last_sample_s = now_s
        wetted_s = None if self._wetted_at_s is None else self._zero_s - self._wetted_at_s
        self._maker = ReadingMaker(
            self._run,
            devices,
            sample_clock,
            self._frame_rate_hz,
            context.rules,
            context.timing,
            keep_all_frames=self._keep_all_frames,
            exposures=self._exposures,
        )
        if self._run.reference and self._feedback is not None:
            self._control = ControlLoop(
                context, self._run, self._feedback, sample_clock, self._zero_s
            )
        context.emit(
            RunStarted(
                time_s=self._zero_s,
                run=self._run,
                sample_clock=sample_clock,
                channels=tuple(devices.signals.channels),
                frame_shape=frame_shape,
                stage_position_m=self._stage_position_m,
                since_wetting_s=wetted_s,
            )
        )
        return self._maker

    def _triggered(self, camera: Camera, trigger: FrameTrigger) -> Exposures:
        """Return the exposures of this run; where all frames are kept, in the protocol's rhythm."""
        exposure_s = camera.settings.exposure_s or 0.0
        every_s = 1 / self._frame_rate_hz if self._keep_all_frames else None
        return Exposures(trigger, self._context.clock, exposure_s, every_s)

    def _steps(self, maker: ReadingMaker) -> bool:
        """Execute the steps; False when a request ended them before the last one."""
        for index, step in enumerate(self._run.steps):
            due_s = self._zero_s + step.time_s
            wait = self._under_control if index and self._control else self._until
            if not wait(due_s, maker) or self._stop_before(index):
                return self._cut_short(maker)
            if index == 0:
                self._context.enter(RunState.RUNNING)
            self._follow_up(index, due_s, self._edge(index, step.voltage_V))
        if self._timed is not None:
            self._await_end(self._timed, maker)
        end_s = self._zero_s + self._run.duration_s
        if self._run.move is not None:
            arrived_s = self._arrived_s(self._run.move, maker)
            if arrived_s is None:
                return self._cut_short(maker)
            end_s += arrived_s - (self._zero_s + self._run.move.time_s)
        return self._until(end_s, maker) or self._cut_short(maker)

    def _edge(self, index: int, voltage_V: float) -> VoltageWrite:
        """Write a step's voltage, or note that the board has put it out."""
        if self._timed is not None:
            return self._timed.write(index)
        return self._context.output.write(voltage_V)

    def _await_end(self, timed: BoardTimedRun, maker: ReadingMaker) -> None:
        """Wait until the board has put out its run, and write 0 V."""
        context = self._context
        while not timed.confirm_end():
            self._until(context.clock.now() + context.timing.service_s, maker, patient=True)

    def _arrived_s(self, move: PlannedMove, maker: ReadingMaker) -> float | None:
        """Have the load cell moved and service the devices meanwhile; None: the run is to end.

        Raises Stopped when the operator declines, and what the stage raises.
        """
        context = self._context
        if not self._until(self._zero_s + move.time_s, maker):
            return None
        moving = StageMove(context.devices, context.clock, move.position_m)
        context.emit(LoadCellLeft(moving.began_s, run=self._run.index, position_m=move.position_m))
        try:
            while not moving.ended:
                if not self._until(context.clock.now() + context.timing.service_s, maker):
                    return None
        finally:
            moving.wait()
        if not moving.arrived():
            raise Stopped("the operator was asked to move the load cell and stopped the session")
        context.emit(
            LoadCellArrived(
                moving.ended_s,
                run=self._run.index,
                position_m=move.position_m,
                reported_m=moving.reported_m,
            )
        )
        return moving.ended_s

    def _under_control(self, when_s: float, maker: ReadingMaker) -> bool:
        """Let the controller set the voltage until a moment; False when a stop is asked for."""
        assert self._control is not None  # noqa: S101 - for the type checker
        return self._control.until(
            when_s,
            maker.samples,
            take_samples=lambda: self._take_samples(maker, self._context.clock.now()),
            service=lambda: self._service(maker),
        )

    def _cut_short(self, maker: ReadingMaker) -> bool:
        """Follow a request to stop after the pulse, which is over now."""
        run_s = self._context.clock.now() - self._zero_s
        self._return_to_zero("the session is to stop after this pulse")
        if not self._context.output.at_zero:
            raise DeviceError("0 V was refused when the session was to stop after the pulse")
        maker.forget_after(run_s)
        return False

    def _stop_before(self, index: int) -> bool:
        """Whether a step is not to be executed; the last one leads to 0 V and always is."""
        last = index == len(self._run.steps) - 1
        return self._context.stop.level is not StopLevel.NONE and not last

    def _follow_up(self, step: int, due_s: float, write: VoltageWrite) -> None:
        """Expect the readings of an edge that was written, and emit it."""
        event = VoltageSet(write.after_s, run=self._run.index, step=step, due_s=due_s, write=write)
        if self._maker is not None:
            self._maker.edge(event)
        self._context.emit(event)
        # Reported when the state changes, not with each pulse: the voltage is soon another one.
        self._context.output.report(
            "0 V written" if write.sheet_V == 0.0 else "a voltage was written"
        )
        self._context.beat()

    def _tail(self, maker: ReadingMaker) -> None:
        """Continue until the last readings are complete and the read-back shows 0 V.

        Who moves the load cell next must not find a voltage at the sheet.
        """
        context = self._context
        context.enter(RunState.TAILING)
        self._until(context.clock.now() + context.timing.tail_s, maker, patient=True)
        # Ends: signals that stay away and a voltage that stays raise, frames become overdue.
        while maker.waiting or not self._shows_zero():
            self._until(context.clock.now() + context.timing.service_s, maker, patient=True)
            self._service(maker)

    def _shows_zero(self) -> bool:
        return self._read_back is not None and self._read_back.shows_zero

    def _until(self, when_s: float, maker: ReadingMaker, *, patient: bool = False) -> bool:
        """Wait and service the devices until a moment; False as soon as the run is to end.

        `patient`: a request to stop after the pulse is being followed already.
        """
        context = self._context
        while True:
            context.beat()
            if context.stop.level is StopLevel.NOW:
                raise Stopped.by(context.stop)
            now_s = context.clock.now()
            if now_s >= when_s:
                return True
            if not patient and context.stop.level is not StopLevel.NONE and context.output.at_zero:
                return False
            next_s = min(when_s, self._trigger_s(now_s, when_s))
            if now_s >= next_s:
                self._fire()
            elif self._may_service(now_s, next_s):
                self._service(maker)
            else:
                ahead = self._next_service_s if self._next_service_s > now_s else next_s
                context.clock.sleep_until(min(next_s, ahead))

    def _trigger_s(self, now_s: float, when_s: float) -> float:
        """Return when the camera is triggered next; no more just before an edge, which is first."""
        if self._exposures is None or when_s - now_s < self._context.timing.edge_first_s:
            return float("inf")
        return self._exposures.next_s

    def _fire(self) -> None:
        if self._exposures is not None:
            self._exposures.fire()

    def _may_service(self, now_s: float, when_s: float) -> bool:
        timing = self._context.timing
        margin_s = min(max(2 * self._cost_s, timing.least_margin_s), timing.most_margin_s)
        overdue = now_s - self._next_service_s > OVERDUE_S
        return now_s >= self._next_service_s and (when_s - now_s > margin_s or overdue)

    def _service(self, maker: ReadingMaker) -> None:
        """Take what has arrived, emit it, and make the readings that are complete."""
        context, devices = self._context, self._context.devices
        began_s = context.clock.now()
        self._next_service_s = began_s + context.timing.service_s
        if self._control is not None and self._exposures and self._exposures.next_s <= began_s:
            self._fire()  # a controller's periods come first: up to a service late
        self._take_samples(maker, began_s)
        if self._timed is not None and context.output.is_loaded:
            context.output.is_done()  # raises where the board has ended the run before its time
        if devices.camera is not None:
            maker.add_frames(devices.camera.frames())
        for event in maker.complete(began_s):
            context.emit(event)
        self._cost_s = max(context.clock.now() - began_s, 0.9 * self._cost_s)

    def _take_samples(self, maker: ReadingMaker, now_s: float) -> None:
        context = self._context
        block = context.devices.signals.read_available()
        if block.volts.shape[1]:
            self._last_sample_s = now_s
            maker.add_block(block)
            context.emit(SignalsArrived(block.read_s, self._run.index, block))
            if self._read_back is not None:
                at_zero_s = context.output.at_zero_s(block.read_s)
                self._read_back.take(block.volts[self._rows.drive], block.read_s, at_zero_s)
            context.devices.protect(block.volts[self._rows.force])
        elif now_s - self._last_sample_s > context.timing.starved_s:
            raise DeviceTimeoutError(
                f"the signal input has delivered no samples for {context.timing.starved_s:g} s; "
                "check its connection; 0 V is written to the output"
            )

    def _return_to_zero(self, why: str, fault: BaseException | None = None) -> None:
        """Write 0 V first, then emit the events about it; never raise.

        `fault` has ended the run. Where 0 V is refused its reason is reported at once: the guard
        may end the program before the session's reason is written.

        It counts as the last step, which is the planned return to 0 V, done early.
        """
        context = self._context
        was_at_zero = context.output.at_zero
        write = context.output.zero()
        if write is not None and self._maker is not None and not was_at_zero:
            last = len(self._run.steps) - 1
            context.emit_if_possible(
                VoltageSet(
                    write.after_s, run=self._run.index, step=last, due_s=write.before_s, write=write
                )
            )
        cause = "" if fault is None else f": {in_words(fault)}"
        text = why if write is not None else NOT_ZERO.format(why=f"{why}{cause}")
        context.guarded("reporting the output", lambda: context.output.report(text))

    def _end(self, *, completed: bool) -> None:
        """Stop the acquisition, each device for itself, and emit its end.

        Raises only after a completed run: what a subscriber raises, or a device that cannot be
        stopped, and so not be started again for the next run.
        """
        context, devices, maker = self._context, self._context.devices, self._maker
        emit = context.emit if completed else context.emit_if_possible
        for periods in self._control.not_emitted() if self._control else ():
            emit(periods)
        failed = None
        # Where 0 V is still to be written, boards that do not answer may not cost more time.
        if completed or context.output.at_zero:
            if maker is not None and not completed:
                context.guarded(
                    "last samples", lambda: self._take_samples(maker, context.clock.now())
                )
            failed = context.guarded("stopping the signal input", devices.signals.stop)
        if devices.camera is not None:
            camera_failed = context.guarded("stopping the camera", devices.camera.stop)
            failed = failed or camera_failed
        if maker is None:
            return  # RunStarted was never emitted
        counts = self._last_frames(maker)
        for event in maker.leftover_frames(context.clock.now()):
            emit(event)
        emit(
            RunStopped(
                time_s=context.clock.now(),
                run=self._run.index,
                completed=completed,
                lost_samples=maker.samples.lost,
                frames_grabbed=counts.grabbed,
                frames_dropped=counts.dropped,
                frames_incomplete=counts.incomplete,
                frames_missed=counts.missed,
            )
        )
        if completed and failed is not None:
            raise failed

    def _last_frames(self, maker: ReadingMaker) -> CameraCounts:
        """Take what the stopped camera still holds; return what came and was lost in this run."""
        camera, guarded = self._context.devices.camera, self._context.guarded
        if camera is None:
            return CameraCounts(0, 0)
        guarded("last frames", lambda: maker.add_frames(camera.frames()))
        found: list[CameraCounts] = []
        guarded("counting the frames", lambda: found.append(camera.counts))
        counts = found[0] if found else CameraCounts(0, 0)
        if self._exposures is None:
            return counts
        # A camera that ignores a trigger leaves no gap in its own numbers.
        missed = max(counts.missed, self._exposures.unanswered - counts.incomplete)
        return replace(counts, missed=missed)
