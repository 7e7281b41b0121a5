"""Make the output safe from another process than the one that drove it.

The guard and `labrig safe` do this. NI knows tasks by their names, and another process can attach
to them: it sets the output to 0 V and frees it, stops the input and frees it. Then it opens the
output itself and writes 0 V again: the old process, should it wake, holds a task that is gone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import asdict, dataclass
from importlib import import_module
from typing import Any

import numpy as np

from drivers.boards.ni.analog_input import INPUT_TASK, InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import OUTPUT_TASK, NiVoltageOutput, write_now
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.errors import DeviceReservedError
from drivers.boards.ni.timed_run import is_clocked
from drivers.interfaces import Clock, DeviceError
from drivers.safe_shutdown import (
    NOT_READ,
    READ_BACK_S,
    SafetyReport,
    attempt,
    judge,
    mean_when_low,
)

_RETRY_S = 0.01
_HELD_S = 0.1  # by a task that cannot be attached to
_STUCK_S = 1.0  # by one that can be attached to, but not be freed
_RATE_HZ = 1000.0


@dataclass(frozen=True, kw_only=True)
class OutputPlace:
    """Where the output and its read-back are, and what counts as 0 V."""

    address: str  # of the boards, as in rig.toml
    output_channel: str  # PCI6703/ao0
    drive_channel: str  # PCI6034E/ai2, the amplifier's output
    limit_board_V: float = 1.0
    drive_range_V: float = 10.0
    drive_terminals: str = "rse"
    safe_below_V: float = 0.05
    output_task: str = OUTPUT_TASK
    input_task: str = INPUT_TASK
    interlock_task: str | None = None  # None: the rig has no interlock

    def as_dict(self) -> dict[str, Any]:
        """Return it as plain data."""
        return asdict(self)


class NiRescue:
    """An `OutputRescue` with a connection of its own."""

    def __init__(self, place: OutputPlace, clock: Clock) -> None:
        self._place = place
        self._clock = clock
        self._connection = NiConnection(place.address)

    def open(self) -> None:
        """See `OutputRescue.open`."""
        self._connection.open()
        for module in ("nidaqmx.constants", "nidaqmx.stream_readers"):
            import_module(module)  # there is no time for it when it is needed

    def make_safe(self, patience_s: float, on_held: Callable[[], None]) -> SafetyReport:
        """See `OutputRescue.make_safe`."""
        return shut_down(self._connection, self._clock, self._place, patience_s, on_held)

    def close(self) -> None:
        """See `OutputRescue.close`."""
        self._connection.close()


def _wait() -> None:
    """Whoever holds a device lets go of it without our help."""


def shut_down(
    connection: NiConnection,
    clock: Clock,
    place: OutputPlace,
    patience_s: float = 5.0,
    on_held: Callable[[], None] = _wait,
) -> SafetyReport:
    """Free the named tasks, write 0 V, read it back, let go. Never raises.

    An output that a board puts out by its clock is stopped first, and keeps its voltage until it
    is opened here, some milliseconds later.

    `patience_s`: how long to wait for a device that somebody still holds. What can be attached to
    is freed again: a server that hung may have answered too late the first time. A task that
    belongs to its process, as with a local driver, cannot be attached to: it holds its device until
    that process ends, and `on_held` is called. Not at once: a program that lives may be opening and
    closing its tasks to write 0 V itself.
    """
    failures: list[str] = []
    until_s = clock.now() + patience_s

    def free(name: str | None, action: str, end: Callable[[Any], object]) -> bool | None:
        """End the task of that name; False: none can be attached to; None: that has failed."""
        found: list[bool] = []
        attempt(failures, lambda: found.append(_free(connection, name, action, end)))
        return found[0] if found else None

    def free_output() -> bool | None:
        return free(place.output_task, "writing 0 V through", _end_output)

    def free_input() -> bool | None:
        return free(place.input_task, "stopping", lambda task: task.stop())

    def insist(open_it: Callable[[], None], free_it: Callable[[], bool | None]) -> None:
        held_s: float | None = None  # since when it is held by what cannot be freed
        while True:
            try:
                return open_it()
            except DeviceReservedError:
                if clock.now() > until_s:
                    raise
            held_s = clock.now() if held_s is None else held_s
            freed = free_it()
            if freed:
                held_s = None
            elif clock.now() > held_s + (_STUCK_S if freed is None else _HELD_S):
                on_held()
            clock.sleep_until(clock.now() + _RETRY_S)

    free_output()
    free_input()
    # Its edges have ended with the program that made them; the next one needs the line.
    free(place.interlock_task, "freeing", lambda _: None)
    output = NiVoltageOutput(
        connection, clock, place.output_channel, place.limit_board_V, place.output_task
    )
    drive = InputChannel("drive", place.drive_channel, place.drive_range_V, place.drive_terminals)
    signals = NiSignalInput(connection, clock, [drive], _RATE_HZ, place.input_task)
    written = attempt(failures, lambda: insist(output.open, free_output))
    seen_V = None
    if not written and _may_hold_run(connection, place):
        failures.append(NOT_READ)
    elif attempt(failures, lambda: insist(signals.open, free_input)):
        seen_V = _read_back(signals, place.safe_below_V, failures)
    attempt(failures, output.close)
    return judge(written, seen_V, place.safe_below_V, failures)


def _may_hold_run(connection: NiConnection, place: OutputPlace) -> bool:
    """Return whether the start of the inputs may start a run of the output; yes where in doubt."""
    output, drive = (c.partition("/")[0] for c in (place.output_channel, place.drive_channel))
    if output.lower() != drive.lower():
        return False
    try:
        return connection.has_output_clock(output)
    except DeviceError:
        return True


def _end_output(task: Any) -> None:
    """Write 0 V through a task. One that puts out by a clock is only stopped: see `shut_down`."""
    if is_clocked(task):
        task.stop()
    else:
        write_now(task, 0.0)


def _free(
    connection: NiConnection, name: str | None, action: str, end: Callable[[Any], object]
) -> bool:
    """End and free another program's task; False: none to attach to. Raises DeviceError."""
    task = None if name is None else connection.attach_task(name)
    if task is None:
        return False
    try:
        with connection.errors(f"{action} the task '{name}'"):
            end(task)
    finally:
        with connection.errors(f"freeing the task '{name}'"):
            task.close()
    return True


def _read_back(signals: NiSignalInput, safe_below_V: float, failures: list[str]) -> float | None:
    seen: list[float] = []

    def read() -> None:
        value = mean_when_low(lambda: float(np.mean(signals.measure(READ_BACK_S))), safe_below_V)
        seen.append(value)

    attempt(failures, read)
    attempt(failures, signals.close)
    return seen[0] if seen else None
