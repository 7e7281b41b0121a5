"""When the clocks of timed tasks begin: at once, by a trigger, or with another task's clock."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from sim_hardware.ni.devices import DeviceRegistry
from sim_hardware.ni.signals.terminals import CLOCK, ONBOARD, START, Terminal, terminal
from sim_hardware.ni.signals.timebase import Timebase
from sim_hardware.ni.tasks.task import Task


class TaskClocks:
    """The sample clocks of the running tasks, and what they share."""

    def __init__(
        self,
        devices: DeviceRegistry,
        error_ppm: float,
        tasks: Callable[[], Iterable[Task]],
        on_begin: Callable[[Task], None],
    ) -> None:
        """`error_ppm`: how much the boards' oscillator is fast; `on_begin`: a clock begins."""
        self._devices = devices
        self._factor = 1.0 + 1e-6 * error_ppm
        self._tasks = tasks
        self._on_begin = on_begin

    def timebase(self, rate_hz: float) -> Timebase:
        """Return the timebase of a nominal rate, not begun yet."""
        return Timebase(rate_hz * self._factor)

    def check(self, task: Task) -> None:
        """Refuse terminals that are none (-200254)."""
        self._source(task)
        self._trigger(task)

    def begin(self, task: Task, now_s: float) -> None:
        """Begin the clock of a task that has started, or let it wait for its trigger."""
        if self._trigger(task) is None:
            self._go(task, now_s)

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


def _drives(task: Task, source: Terminal) -> bool:
    """Whether a task is the one that drives a terminal."""
    side = "ai" if task.inputs else "ao" if task.outputs else ""
    return side == source.side and source.device in task.device_names
