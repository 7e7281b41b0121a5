"""Make the output safe from another process than the one that drove it.

The guard and `labrig safe` do this. Boards know their tasks by name: they are attached to, the
output set to 0 V and freed, the input stopped and freed. Then the output is taken anew and 0 V
written again: the old process, should it wake, holds a task that no longer exists.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.boards.ni.analog_input import INPUT_TASK, InputChannel, NiSignalInput
from drivers.boards.ni.analog_output import OUTPUT_TASK, NiVoltageOutput, write_now
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.errors import DeviceReservedError
from drivers.interfaces import Clock
from drivers.safe_shutdown import READ_BACK_S, SafetyReport, attempt, judge, mean_when_low

_RETRY_S = 0.01
_RATE_HZ = 1000.0


@dataclass(frozen=True)
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


def _wait() -> None:
    """Whoever holds a device lets go of it without our help."""


def take_over(
    connection: NiConnection,
    clock: Clock,
    place: OutputPlace,
    patience_s: float = 5.0,
    on_held: Callable[[], None] = _wait,
) -> SafetyReport:
    """Free both named tasks, write 0 V, read it back, let go. Never raises.

    `patience_s`: how long to wait for a device that somebody still holds; `on_held` is called each
    time it is found so. A task that belongs to its process, as with a local driver, cannot be
    attached to: it holds its device until that process ends.
    """
    failures: list[str] = []
    until_s = clock.now() + patience_s

    def patiently(open_it: Callable[[], None]) -> None:
        while True:
            try:
                return open_it()
            except DeviceReservedError:
                if clock.now() > until_s:
                    raise
            on_held()
            clock.sleep_until(clock.now() + _RETRY_S)

    attempt(failures, lambda: _free_output(connection, place.output_task))
    attempt(failures, lambda: _free_input(connection, place.input_task))
    attempt(failures, lambda: _free_interlock(connection, place.interlock_task))
    output = NiVoltageOutput(
        connection, clock, place.output_channel, place.limit_board_V, place.output_task
    )
    written = attempt(failures, lambda: patiently(output.open))
    seen_V = _read_back(connection, clock, place, patiently, failures)
    attempt(failures, output.close)
    return judge(written, seen_V, place.safe_below_V, failures)


def _free_output(connection: NiConnection, name: str) -> None:
    task = connection.attach_task(name)
    if task is None:
        return
    try:
        with connection.errors(f"writing 0 V through the task '{name}'"):
            write_now(task, 0.0)
    finally:
        with connection.errors(f"freeing the task '{name}'"):
            task.close()


def _free_input(connection: NiConnection, name: str) -> None:
    task = connection.attach_task(name)
    if task is None:
        return
    try:
        with connection.errors(f"stopping the task '{name}'"):
            task.stop()
    finally:
        with connection.errors(f"freeing the task '{name}'"):
            task.close()


def _free_interlock(connection: NiConnection, name: str | None) -> None:
    """Its edges have ended with the program that made them; the next one needs the line."""
    task = None if name is None else connection.attach_task(name)
    if task is not None:
        with connection.errors(f"freeing the task '{name}'"):
            task.close()


def _read_back(
    connection: NiConnection,
    clock: Clock,
    place: OutputPlace,
    patiently: Callable[[Callable[[], None]], None],
    failures: list[str],
) -> float | None:
    drive = InputChannel("drive", place.drive_channel, place.drive_range_V, place.drive_terminals)
    signals = NiSignalInput(connection, clock, [drive], _RATE_HZ, place.input_task)
    seen: list[float] = []

    def look() -> None:
        patiently(signals.open)
        seen.append(
            mean_when_low(lambda: float(np.mean(signals.measure(READ_BACK_S))), place.safe_below_V)
        )

    attempt(failures, look)
    attempt(failures, signals.close)
    return seen[0] if seen else None
