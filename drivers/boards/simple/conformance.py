"""Whether a simple board does all that labrig asks of it: each contract's check, on the board."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np

from drivers.boards.conformance import (
    OPEN_S,
    connection_faults,
    family_faults,
    output_faults,
    rescue_faults,
    signal_faults,
)
from drivers.boards.contract import DRIVE, BoardConnection, BoardFamily, faults
from drivers.boards.read_back_conformance import read_back_faults
from drivers.boards.simple.board import SimpleSettings
from drivers.conformance import Checks
from drivers.interfaces import Clock, DeviceError

_SAFE_BELOW_V = 0.05
_FREE_S, _RETRY_S = 2.0, 0.05  # a box needs a moment to see that a connection has ended


def simple_board_faults(
    family: BoardFamily, settings: SimpleSettings, limit_V: float, clock: Clock
) -> list[str]:
    """Return what a board that is there does against the contracts. It is driven to its limit.

    Connect nothing to it that cannot bear this voltage; the read-back must be connected.
    """

    def connection() -> BoardConnection:
        return family.connect(settings, clock, None)

    def on_open(check: Callable[[BoardConnection], list[str]]) -> list[str]:
        boards = connection()
        _open_when_free(boards, clock)
        try:
            return check(boards)
        finally:
            boards.close()

    found = faults(family) or family_faults(family, settings, clock)
    found = found or connection_faults(connection(), clock)
    if found:
        return found
    signals = family.inputs(settings)
    try:
        return [
            *_shared(connection(), connection(), clock),
            *on_open(lambda b: output_faults(b.voltage_output(limit_V), limit_V, clock)),
            *on_open(lambda b: signal_faults(b.signal_input(signals), clock)),
            *on_open(lambda b: _read_back(b, family, settings, limit_V, clock)),
            *_rescue(on_open, family, settings, limit_V, clock),
        ]
    except DeviceError as fault:
        return [str(fault)]


def _open_when_free(boards: BoardConnection, clock: Clock) -> None:
    """Open the board once nobody has it."""
    until_s = clock.now() + _FREE_S
    while True:
        try:
            return boards.open()
        except DeviceError:
            if clock.now() > until_s:
                raise
        clock.sleep_until(clock.now() + _RETRY_S)


def _shared(first: BoardConnection, second: BoardConnection, clock: Clock) -> list[str]:
    """Return how two programs share a board; they must not."""
    checks = Checks(clock)
    _open_when_free(first, clock)
    checks.refuse("open while another program has the board", second.open, within_s=OPEN_S)
    second.close()
    first.close()
    checks.call("open once the other has let go", lambda: _open_when_free(second, clock), OPEN_S)
    second.close()
    return checks.faults


def _read_back(
    boards: BoardConnection,
    family: BoardFamily,
    settings: SimpleSettings,
    limit_V: float,
    clock: Clock,
) -> list[str]:
    output = boards.voltage_output(limit_V)
    signals = boards.signal_input(family.inputs(settings))
    output.open()
    signals.open()
    return read_back_faults(output, signals, limit_V, clock)


def _rescue(
    on_open: Callable[[Callable[[BoardConnection], list[str]]], list[str]],
    family: BoardFamily,
    settings: SimpleSettings,
    limit_V: float,
    clock: Clock,
) -> list[str]:
    """Return what a rescue does after a program that left a voltage at the output."""

    def leave_a_voltage(boards: BoardConnection) -> list[str]:
        output = boards.voltage_output(limit_V)
        output.open()
        output.write(limit_V)
        output.abandon()
        return []

    def drive_V() -> float:
        seen: list[float] = []

        def measure(boards: BoardConnection) -> list[str]:
            signals = boards.signal_input(family.inputs(settings))
            signals.open()
            row = list(signals.channels).index(DRIVE)
            seen.append(float(np.mean(signals.measure(0.05)[row])))
            return []

        on_open(measure)
        return seen[0] if seen else math.nan

    place = family.output_place(settings, limit_V, _SAFE_BELOW_V, None)
    if family.rescue is None:
        return ["it cannot be made safe by another process"]
    on_open(leave_a_voltage)
    try:
        return rescue_faults(family.rescue(place, clock), clock, drive_V)
    finally:  # whatever the rescue did, and Ctrl-C amid
        on_open(_at_zero)


def _at_zero(boards: BoardConnection) -> list[str]:
    """Write 0 V."""
    boards.voltage_output(0.0).open()
    return []
