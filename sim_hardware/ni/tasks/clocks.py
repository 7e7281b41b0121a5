"""When the clocks of timed tasks begin: at once, by a trigger, or with another task's clock."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable

from nidaqmx.constants import BusType

from sim_hardware.ni.devices import DeviceRegistry
from sim_hardware.ni.errors import Code, NotSimulatedError, StatusError
from sim_hardware.ni.signals.external_edges import ExternalEdges
from sim_hardware.ni.signals.terminals import CLOCK, ONBOARD, START, Terminal, terminal
from sim_hardware.ni.signals.timebase import RetriggeredTimebase, Timebase
from sim_hardware.ni.tasks.task import Task

_CHASSIS_CLOCKS = ("PXIe_Clk100", "PXI_Clk10")


class TaskClocks:
    """The sample clocks of the running tasks, and what they share."""

    def __init__(
        self,
        devices: DeviceRegistry,
        error_ppm: float,
        tasks: Callable[[], Iterable[Task]],
        on_begin: Callable[[Task], None],
        edges: ExternalEdges,
    ) -> None:
        """`error_ppm`: how much the boards' oscillator is fast; `on_begin`: a clock begins."""
        self._devices = devices
        self._edges = edges
        self._factor = 1.0 + 1e-6 * error_ppm
        self._tasks = tasks
        self._on_begin = on_begin

    def timebase(self, task: Task, rate_hz: float) -> Timebase:
        """Return the timebase of a nominal rate, not begun yet."""
        trigger = self._trigger(task) if task.starts_again else None
        if trigger is None:
            return Timebase(rate_hz * self._factor)
        return RetriggeredTimebase(
            rate_hz * self._factor,
            samples=task.timing.samples,
            next_trigger=lambda after_s: self._edges.next_s(trigger, task.trigger.edge, after_s),
        )

    def next_reference(self, task: Task) -> Callable[[float], float]:
        """Return what tells when the next edge after a time comes at the reference trigger."""
        place = terminal(self._devices, task.reference.source)
        return lambda after_s: self._edges.next_s(place, task.reference.edge, after_s)

    def check(self, task: Task) -> None:
        """Refuse terminals that are none (-200254)."""
        source, trigger = self._source(task), self._trigger(task)
        check_reference_clock(task)
        if task.starts_again and (source is not None or (trigger and trigger.side is not None)):
            raise NotSimulatedError("a task that starts again needs a PFI line and its own clock")
        if task.reference.source:
            if terminal(self._devices, task.reference.source).side is not None:
                raise NotSimulatedError("only a PFI line is a simulated reference trigger")
            if source is not None:
                raise NotSimulatedError("a reference trigger needs the board's own clock")

    def begin(self, task: Task, now_s: float) -> None:
        """Begin the clock of a task that has started, or let it wait for its trigger."""
        trigger = self._trigger(task)
        if trigger is None:
            when_s = now_s
        elif trigger.side is None:
            when_s = self._edges.next_s(trigger, task.trigger.edge, now_s)
        else:
            when_s = self._start_to_come(task, trigger, now_s)
        if not math.isinf(when_s):
            self._go(task, when_s)

    def _start_to_come(self, task: Task, trigger: Terminal, now_s: float) -> float:
        """Return when a task will start that has its own trigger already; inf: not known."""
        starts_s = (
            each.timed.timebase.start_s
            for each in self._running()
            if each is not task and each.timed is not None and _drives(each, trigger)
        )
        return min((s for s in starts_s if trigger.signal == START and s > now_s), default=math.inf)

    def end(self, task: Task, now_s: float) -> None:
        """Stop the clock of a task, and so of all that share it."""
        timed = task.timed
        if timed is not None and self._source(task) is None:
            timed.timebase.stop_s = min(now_s, timed.timebase.stop_s)

    def _go(self, task: Task, when_s: float) -> None:
        timed, source = task.timed, self._source(task)
        if timed is None:
            return
        if source is None:
            timed.timebase.start_s = when_s
        else:
            others = (each for each in self._running() if each is not task)
            driver = next((each for each in others if _drives(each, source)), None)
            if driver is None or driver.timed is None or driver.timed.timebase.start_s > when_s:
                return  # it waits for the driver's clock
            timed.follow(driver.timed.timebase, driver.timed.timebase.edges(when_s))
        self._on_begin(task)
        self._pass_on(task, when_s)

    def _pass_on(self, task: Task, when_s: float) -> None:
        """Begin what has waited for this task's start, or for its clock."""
        for other in list(self._running()):
            timed = other.timed
            if other is task or timed is None or timed.timebase.start_s <= when_s:
                continue
            trigger, source = self._trigger(other), self._source(other)
            if trigger is not None and trigger.signal == START and _drives(task, trigger):
                self._go(other, when_s)
            elif trigger is None and source is not None and _drives(task, source) and task.timed:
                timed.follow(task.timed.timebase, 0)
                self._on_begin(other)
                self._pass_on(other, when_s)

    def _running(self) -> Iterable[Task]:
        return (task for task in self._tasks() if task.running)

    def _source(self, task: Task) -> Terminal | None:
        """Return the terminal that the sample clock comes from; None: the board's own."""
        if task.timing.source in ONBOARD:
            return None
        found = terminal(self._devices, task.timing.source)
        own = found.signal == CLOCK and _drives(task, found)
        return None if own else found

    def _trigger(self, task: Task) -> Terminal | None:
        if not task.trigger.source:
            return None
        return terminal(self._devices, task.trigger.source)


def check_reference_clock(task: Task) -> None:
    """Refuse a clock that a board cannot lock to (-200254): a PXI Express chassis has two."""
    name = task.timing.reference_clock.rpartition("/")[2]
    for device in (channel.device for channel in task.channels):
        known = _CHASSIS_CLOCKS if device.board.bus is BusType.PXIE else ()
        if name not in (*ONBOARD, *known):
            raise StatusError(
                Code.INVALID_TERMINAL, f"Source Terminal: {name}\nDevice: {device.name}"
            )


def _drives(task: Task, source: Terminal) -> bool:
    """Whether a task is the one that drives a terminal."""
    side = "ai" if task.inputs else "ao" if task.outputs else ""
    return side == source.side and source.device in task.engine_names
