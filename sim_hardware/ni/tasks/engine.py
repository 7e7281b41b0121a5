"""The simulated driver: its boards, its tasks, and how they move from state to state.

Calls come from many threads; each holds `lock` while it works and lets go of it while it waits.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable, Mapping

from drivers.interfaces import Clock
from sim_hardware.clock import VirtualClock
from sim_hardware.ni.devices import DeviceRegistry
from sim_hardware.ni.errors import Code, StatusError
from sim_hardware.ni.faults import Faults
from sim_hardware.ni.rpc import Call
from sim_hardware.ni.signals.acquisition import Acquisition, Sampler
from sim_hardware.ni.signals.adc import Converter
from sim_hardware.ni.signals.digital_lines import Lines
from sim_hardware.ni.signals.external_edges import ExternalEdges
from sim_hardware.ni.signals.generation import Generation
from sim_hardware.ni.signals.line_sampler import LineSampler
from sim_hardware.ni.signals.referenced_acquisition import ReferencedAcquisition
from sim_hardware.ni.signals.shown_signals import LimitSine
from sim_hardware.ni.signals.timing import InputPlan, OutputPlan
from sim_hardware.ni.tasks.channels import AnalogInputChannel
from sim_hardware.ni.tasks.clocks import TaskClocks
from sim_hardware.ni.tasks.event_threads import start_event_threads
from sim_hardware.ni.tasks.playback import Playback
from sim_hardware.ni.tasks.reservations import Reservations
from sim_hardware.ni.tasks.sessions import Sessions
from sim_hardware.ni.tasks.task import Task, TaskState
from sim_hardware.simulated_rig import AnalogSide

# A wait is cut into pieces of this length: a stopped task or a client that has gone ends it.
_WAIT_PIECE_S = 0.05


class Engine:
    """Everything that the server's calls work on."""

    def __init__(
        self,
        rig: AnalogSide,
        clock: Clock,
        devices: Mapping[str, str],
        *,
        driver_version: tuple[int, int, int],
        faults: Faults,
        seed: int | None,
        strict_ownership: bool,
        clock_error_ppm: float = 0.0,
        is_wired: Callable[[str, str], bool] | None = None,
        edges_hz: Mapping[str, float] | None = None,
    ) -> None:
        """`clock_error_ppm`: how much faster the boards' oscillators are than `clock`.

        `edges_hz`: square waves that come to PFI terminals.
        With `is_wired` (device, channel), inputs that are not wired show test signals.
        """
        self._is_wired = is_wired
        # What the clock's 0 is in UTC; a virtual clock has no date.
        self.epoch_s = None if isinstance(clock, VirtualClock) else time.time() - clock.now()
        self.lock = threading.Lock()
        self._rig = rig
        self.clock = clock
        self.is_virtual = isinstance(clock, VirtualClock)
        self.devices = DeviceRegistry(devices)
        self.driver_version = driver_version
        self.faults = faults
        self.lines = Lines()
        self.sessions = Sessions(strict=strict_ownership)
        self._seed = seed
        self._reservations: Reservations[Task] = Reservations()
        self.playback = Playback(clock, self.lock, self._put_out, faults)
        self.clocks = TaskClocks(
            self.devices,
            clock_error_ppm,
            self.sessions.all,
            self.playback.begin,
            ExternalEdges(self.devices, edges_hz or {}),
        )

    def now(self) -> float:
        """Return the clock's time."""
        return self.clock.now()

    def wait_until(self, when: float, call: Call) -> bool:
        """Wait, lock released, until `when` at most; False once the caller has gone.

        May return early: ask again what you were waiting for.
        """
        self.lock.release()
        try:
            self.clock.sleep_until(min(when, self.clock.now() + _WAIT_PIECE_S))
        finally:
            self.lock.acquire()
        self.playback.advance()
        return call.is_active()

    # -------------------------------------------------------------------------------- the states

    def verify(self, task: Task) -> None:
        """Check all settings."""
        task.verify()
        self.clocks.check(task)
        task.state = max(task.state, TaskState.VERIFIED)

    def reserve(self, task: Task, state: TaskState = TaskState.RESERVED) -> None:
        """Verify, and reserve the boards' resources (-50103 when another task holds them)."""
        self.verify(task)
        self._reservations.reserve(task.resources(), task)
        task.state = max(task.state, state)

    def start(self, task: Task) -> None:
        """Begin to acquire or to accept values."""
        task.refuse_while_running(Code.TASK_RUNNING)
        self.reserve(task, TaskState.COMMITTED)
        self._make_ready(task)
        task.state = TaskState.RUNNING
        self.clocks.begin(task, self.now())
        if task.timed is not None and task.events.streams():
            start_event_threads(self.clock, task, task.timed)

    def _make_ready(self, task: Task) -> None:
        """Make what acquires or puts out; its clock does not run yet."""
        plan = task.verify()
        if isinstance(plan, InputPlan):
            task.acquisition = self._acquisition(task, plan)
        elif isinstance(plan, OutputPlan):
            if task.output.written == 0:
                raise StatusError(Code.OUTPUT_BUFFER_EMPTY, task=task.name)
            base = self.clocks.timebase(task, plan.rate_hz)
            task.generation = Generation(plan, task.output, base)
        elif task.inputs:
            task.on_demand = self._sampler(task)

    def _acquisition(self, task: Task, plan: InputPlan) -> Acquisition:
        base = self.clocks.timebase(task, plan.rate_hz)
        sampler = self._sampler(task) if task.inputs else self.line_sampler(task)
        parts = (plan, sampler, len(task.channels), base, task.reads)
        if not task.reference.source:
            return Acquisition(*parts)
        return ReferencedAcquisition(
            *parts,
            pretrigger=task.reference.pretrigger_samples,
            next_edge=self.clocks.next_reference(task),
        )

    def stop(self, task: Task) -> None:
        """End the acquisition; the task keeps its resources if it had been committed before.

        An output keeps the voltage that it has at this moment.
        """
        if not task.running:
            return
        self.playback.advance()
        self.clocks.end(task, self.now())
        if task.acquisition is not None:
            task.acquisition.end(self.now())
        task.acquisition = task.on_demand = task.generation = None
        for stream in task.events.streams():
            stream.drop_pending()
        task.started_by_read = False
        task.state = TaskState.COMMITTED
        if not task.held:
            self.unreserve(task)

    def unreserve(self, task: Task) -> None:
        """Let go of the boards."""
        self._reservations.release(task)
        task.state = min(task.state, TaskState.VERIFIED)

    def abort(self, task: Task) -> None:
        """Stop, and let go of the boards."""
        task.held = False
        self.stop(task)
        self.unreserve(task)

    def clear(self, task: Task) -> None:
        """Abort and forget the task. Outputs keep their voltage."""
        self.abort(task)
        task.events.close()
        self.sessions.forget(task)

    def reset_device(self, name: str) -> None:
        """Abort the tasks that use a board; its model says whether outputs keep their voltage."""
        device = self.devices.find(name)
        for task in self.sessions.all():
            if device.name in task.device_names:
                self.abort(task)
        outputs = device.board.analog_out
        if outputs is not None and not outputs.keeps_voltage_on_reset:
            for number in range(outputs.channels):
                self.write_volts(device.name, f"ao{number}", 0.0)

    def client_gone(self, client: str) -> None:
        """Clear the tasks of a closed connection, with strict ownership; outputs stay."""
        with self.lock:
            for task in self.sessions.of_client(client):
                self.clear(task)

    # --------------------------------------------------------------------------------- terminals

    def _sampler(self, task: Task) -> Sampler:
        """Return the sampler of a task's inputs."""
        task.starts += 1
        shown = [self._test_signal(channel) for channel in task.inputs]
        converters = [
            # What is shown stays between the channel's limits, and so has no noise.
            Converter(
                channel.side,
                channel.verified_range(),
                self._seed_of(task, row) if shown[row] is None else None,
            )
            for row, channel in enumerate(task.inputs)
        ]
        return Sampler(self._rig, task.inputs, converters, shown)

    def _test_signal(self, channel: AnalogInputChannel) -> LimitSine | None:
        """Return what an input shows to which nothing is wired, if it shows anything."""
        if self._is_wired is None or self._is_wired(channel.device.name, channel.physical):
            return None
        return LimitSine(channel.low_V, channel.high_V)

    def line_sampler(self, task: Task, first: int = 0) -> LineSampler:
        """Return the sampler of a task's digital channels, from its sample `first` on."""
        lines = [[f"{c.device.name}/{line}" for line in c.lines] for c in task.digital]
        return LineSampler(self.lines, lines, counts=self._is_wired is not None, first=first)

    def _seed_of(self, task: Task, row: int) -> tuple[int, ...] | None:
        """Of the noise of one channel in one acquisition."""
        return None if self._seed is None else (self._seed, task.number, task.starts, row)

    def write_volts(self, device: str, channel: str, volts: float) -> None:
        """Put a new voltage on an output, now."""
        if f"{device}/{channel}" not in self.faults.stuck_outputs:
            self._rig.write(device, channel, volts, self.now())

    def _put_out(self, task: Task, channel: int, volts: float, when_s: float) -> None:
        """Put a sample of a generation on its output, at its time."""
        output = task.outputs[channel]
        if f"{output.device.name}/{output.physical}" not in self.faults.stuck_outputs:
            converted = output.converted(volts)
            self._rig.write(output.device.name, output.physical, converted, when_s)

    def write_line(self, line: str, high: bool) -> None:
        """Set a digital line's level, now."""
        if line not in self.faults.stuck_outputs:
            self.lines.write(line, high, self.now())
