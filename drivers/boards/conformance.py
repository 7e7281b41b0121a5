"""Whether boards keep their contracts: connection, output, input, interlock, rescue, family."""

from __future__ import annotations

import json
import math
from collections.abc import Callable
from functools import partial
from typing import Any

import numpy as np

from drivers.amplifier import BoardOutput, BoardWrite, TimedBoardOutput
from drivers.boards.contract import (
    CURRENT,
    DRIVE,
    FORCE,
    BoardConnection,
    BoardFamily,
    OutputRescue,
)
from drivers.conformance import Checks
from drivers.interfaces import Clock, Interlock, LimitError, SignalInput, TimedVoltage
from drivers.safe_shutdown import SafetyReport

OPEN_S = 10.0
DEVICE_S = 5.0  # a call may take so long; PROMPT_S where the working loop waits for it


def family_faults(family: BoardFamily, settings: Any, clock: Clock) -> list[str]:
    """Return what is wrong with a family and these settings of it; no device is touched."""
    checks = Checks(clock)
    inputs = checks.call("inputs", lambda: family.inputs(settings)) or ()
    names = [each.name for each in inputs]
    checks.require(
        sorted(names) == sorted((FORCE, CURRENT, DRIVE)),
        f"the inputs are {', '.join(names) or 'none'}, not force, current and drive",
    )
    place = checks.call("output_place", lambda: family.output_place(settings, 0.25, 0.05, None))
    if place is not None:
        plain = checks.call("JSON of output_place", lambda: json.loads(json.dumps(place)))
        checks.require(plain == place, "output_place is not plain data: it changes in JSON")
    if checks.require(family.rescue is not None, "it cannot be made safe by another process"):
        rescue = family.rescue
        checks.call("rescue", lambda: rescue and rescue(place or {}, clock))
    checks.call("connect", lambda: family.connect(settings, clock, None))
    return checks.faults


def connection_faults(connection: BoardConnection, clock: Clock) -> list[str]:
    """Return what a connection, not open yet, does against `BoardConnection` and `Identified`.

    Its boards are there, as rig.toml names them.
    """
    checks = Checks(clock)
    checks.call("open", connection.open, OPEN_S)
    checks.call("a second open", connection.open, OPEN_S)
    if not checks.faults:
        for finding in checks.call("findings", connection.findings, DEVICE_S) or ():
            checks.require(finding.ok, f"{finding.name}: {finding.found}")
        checks.identify(connection)
    checks.call("close", connection.close, DEVICE_S)
    checks.call("a second close", connection.close, DEVICE_S)
    return checks.faults


def output_faults(output: BoardOutput, limit_V: float, clock: Clock) -> list[str]:
    """Return what an output, not open yet, does against `BoardOutput`. It is driven to its limit.

    Connect nothing to it that cannot bear this voltage.
    """
    checks = Checks(clock)
    checks.refuse("write before open", lambda: output.write(0.0))
    checks.call("open", output.open, DEVICE_S)
    if not checks.faults:
        try:
            for volts in (0.5 * limit_V, limit_V, -limit_V, 0.0):
                _write(checks, output, volts)
            for volts in (1.01 * limit_V, -1.01 * limit_V, math.nan, math.inf):
                checks.refuse(f"write({volts:g})", partial(output.write, volts), LimitError)
        finally:  # Ctrl-C amid must leave no voltage
            _write(checks, output, 0.0)
    checks.call("close", output.close, DEVICE_S)
    checks.call("a second close", output.close)
    checks.refuse("write after close", lambda: output.write(0.0))
    checks.call("open after close", output.open, DEVICE_S)
    checks.call("close", output.close, DEVICE_S)
    return checks.faults


def _write(checks: Checks, output: BoardOutput, volts: float) -> None:
    began_s = checks.clock.now()
    done = checks.call(f"write({volts:g})", lambda: output.write(volts))
    if isinstance(done, BoardWrite):
        in_order = began_s <= done.before_s <= done.after_s <= checks.clock.now()
        checks.require(in_order, "a write's times are not between its call and its return")
    else:
        checks.require(done is None, f"write returned {done!r}, not a BoardWrite")


def timed_output_faults(
    output: TimedBoardOutput, signals: SignalInput, limit_V: float, clock: Clock
) -> list[str]:
    """Return what an output does against `TimedBoardOutput`; it and the inputs are open.

    It is driven to its limit for 0.1 s. Connect nothing to it that cannot bear this voltage.
    """
    checks = Checks(clock)
    if not checks.require(output.is_timed, "is_timed is False"):
        return checks.faults
    rate_hz, tenth = signals.rate_hz, math.ceil(0.1 * signals.rate_hz)
    run = (TimedVoltage(tenth, limit_V), TimedVoltage(2 * tenth, 0.0))
    beyond = (TimedVoltage(tenth, 1.01 * limit_V), run[1])
    checks.refuse("load beyond the limit", lambda: output.load(beyond, rate_hz), LimitError)
    checks.refuse("load that does not end at 0 V", lambda: output.load(run[:1], rate_hz))
    checks.refuse("is_done without a run", output.is_done)
    checks.call("load", lambda: output.load(run, rate_hz), DEVICE_S)
    if checks.faults:
        return checks.faults
    for start, done in ((None, False), (signals.start, True)):
        if start is not None:
            checks.call("start of the inputs", start, DEVICE_S)
        checks.wait(0.5)
        found = checks.call("is_done", output.is_done)
        checks.require(found is done, f"is_done is {found} where {done} was due")
    checks.call("write that ends the run", lambda: output.write(0.0), DEVICE_S)
    checks.refuse("is_done after it", output.is_done)
    checks.call("stop of the inputs", signals.stop, DEVICE_S)
    return checks.faults


def signal_faults(signals: SignalInput, clock: Clock) -> list[str]:
    """Return what an input, not open yet, does against `SignalInput`."""
    checks = Checks(clock)
    checks.refuse("start before open", signals.start)
    checks.call("open", signals.open, DEVICE_S)
    if not checks.faults:
        _facts(checks, signals)
        _measure(checks, signals)
        for _ in range(2):  # each acquisition begins anew
            _acquire(checks, signals)
    checks.call("close", signals.close, DEVICE_S)
    checks.call("a second close", signals.close)
    checks.refuse("start after close", signals.start)
    return checks.faults


def _facts(checks: Checks, signals: SignalInput) -> None:
    names, ranges_V = list(signals.channels), list(signals.ranges_V)
    checks.require(names and len(set(names)) == len(names), f"channels are {names}")
    good = len(ranges_V) == len(names) and all(math.isfinite(v) and v > 0 for v in ranges_V)
    checks.require(good, f"ranges_V are {ranges_V} of {len(names)} channels")
    checks.require(signals.rate_hz > 0, f"rate_hz is {signals.rate_hz}")


def _measure(checks: Checks, signals: SignalInput) -> None:
    volts = checks.call("measure", lambda: signals.measure(0.1), 0.1 + DEVICE_S)
    if volts is None:
        return
    wanted = (len(signals.channels), math.ceil(0.1 * signals.rate_hz))
    good = volts.shape == wanted and bool(np.isfinite(volts).all())
    checks.require(good, f"measure returned {volts.shape} samples, not {wanted} numbers")


def _acquire(checks: Checks, signals: SignalInput) -> None:
    sample_clock = checks.call("start", signals.start, DEVICE_S)
    if sample_clock is None:
        return
    checks.refuse("a second start", signals.start, within_s=DEVICE_S)
    now_s = checks.clock.now()
    checks.require(sample_clock.start_s <= now_s, "the first sample lies in the future")
    index = 0
    for _ in range(3):
        checks.wait(0.2)
        block = checks.call("read_available", signals.read_available)
        if block is not None:
            rows = len(signals.channels)
            checks.require(block.volts.shape[0] == rows, f"a block has {block.volts.shape[0]} rows")
            checks.require(
                block.first_index == index, f"sample {block.first_index} came where {index} was due"
            )
            index = block.first_index + block.volts.shape[1]
    checks.require(index > 0, "no sample came in 0.6 s")
    checks.call("stop", signals.stop, DEVICE_S)
    checks.call("a second stop", signals.stop)
    checks.refuse("read_available after stop", signals.read_available)


def interlock_faults(interlock: Interlock, clock: Clock) -> list[str]:
    """Return what an interlock's line, not open yet, does against `Interlock`."""
    checks = Checks(clock)
    checks.refuse("beat before open", interlock.beat)
    checks.call("open", interlock.open, DEVICE_S)
    if not checks.faults:
        for _ in range(5):
            checks.call("beat", interlock.beat)
            checks.wait(0.02)
    checks.call("close", interlock.close, DEVICE_S)
    checks.call("a second close", interlock.close)
    checks.refuse("beat after close", interlock.beat)
    return checks.faults


def rescue_faults(
    rescue: OutputRescue, clock: Clock, read_V: Callable[[], float], patience_s: float = 1.0
) -> list[str]:
    """Return what a rescue, not open yet, does against `OutputRescue`.

    Somebody else has energised the output, which `read_V` measures apart from the boards.
    """
    checks = Checks(clock)
    checks.require(abs(read_V()) > 0.05, "the output must be energised for this check")
    checks.call("open", rescue.open, DEVICE_S)
    checks.call("a second open", rescue.open, DEVICE_S)
    report = checks.call(
        "make_safe", lambda: rescue.make_safe(patience_s, lambda: None), patience_s + DEVICE_S
    )
    if isinstance(report, SafetyReport):
        checks.require(report.is_safe, f"make_safe reports: {report.text}")
        checks.require(
            abs(read_V()) < 0.05 or not report.is_safe, f"it reports safe at {read_V():.3f} V"
        )
    elif checks.answered:
        checks.note(f"make_safe returned {report!r}, not a SafetyReport")
    checks.call("close", rescue.close, DEVICE_S)
    checks.call("a second close", rescue.close)
    return checks.faults
