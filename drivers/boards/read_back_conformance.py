"""Whether the inputs show what the output does, and when."""

from __future__ import annotations

import math

import numpy as np

from drivers.amplifier import BoardOutput
from drivers.boards.conformance import DEVICE_S
from drivers.boards.contract import DRIVE
from drivers.conformance import Checks
from drivers.interfaces import Clock, FloatArray, SignalInput

LATEST_S = 0.05  # an edge that is seen later than this after its write makes a reading invalid
_BEFORE_S = 0.2
_AFTER_S = 0.3


def read_back_faults(
    output: BoardOutput, signals: SignalInput, volts: float, clock: Clock
) -> list[str]:
    """Return what the channel `drive` shows wrongly of one write of the output; both are open.

    `volts`, board volts, are written for 0.3 s. Connect nothing that cannot bear this voltage.
    """
    checks = Checks(clock)
    if not checks.require(DRIVE in signals.channels, f"there is no channel {DRIVE}"):
        return checks.faults
    started = checks.call("start", signals.start, DEVICE_S)
    checks.wait(_BEFORE_S)
    try:
        done = checks.call("write", lambda: output.write(volts))
        checks.wait(_AFTER_S)
        block = checks.call("read_available", signals.read_available)
    finally:  # Ctrl-C in the wait must leave no voltage
        checks.call("write of 0 V", lambda: output.write(0.0))
        checks.call("stop", signals.stop, DEVICE_S)
    if started is None or done is None or block is None:
        return checks.faults
    drive_V = block.volts[list(signals.channels).index(DRIVE)]
    seen = _edge(drive_V, round(0.5 * _BEFORE_S * started.rate_hz))
    if checks.require(seen is not None, f"{DRIVE} does not change when {volts:g} V are written"):
        late_s = started.time_of(seen or 0) - done.after_s
        early_s = done.before_s - started.time_of(seen or 0)
        checks.require(
            max(late_s, early_s) <= LATEST_S,
            f"{DRIVE} shows a write {1e3 * max(late_s, early_s):.0f} ms "
            f"{'after' if late_s > 0 else 'before'} it, by the samples' clock; "
            f"{1e3 * LATEST_S:.0f} ms are allowed",
        )
    return checks.faults


def _edge(drive_V: FloatArray, level: int) -> int | None:
    """Return the first sample beyond half of the change; None where the channel does not change."""
    if len(drive_V) < 2 * level:
        return None
    old, new = drive_V[:level], drive_V[-level:]
    change = float(np.median(new) - np.median(old))
    if not (math.isfinite(change) and abs(change) > 5.0 * max(np.std(old), np.std(new))):
        return None
    return int(np.argmax((drive_V - np.median(old)) / change > 0.5))
