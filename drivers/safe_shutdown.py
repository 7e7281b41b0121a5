"""Make the output safe: 0 V written and seen on the read-back, or known to be unknown.

Every way out of a run comes through `make_safe`, so nothing in here raises.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from enum import StrEnum
from functools import partial

import numpy as np

from drivers.interfaces import (
    Clock,
    DeviceError,
    DeviceTimeoutError,
    SignalInput,
    TimedOutput,
    VoltageOutput,
)

READ_BACK_S = 0.02
PATIENCE_S = 1.0  # a device that fails is tried again for so long
DEVICE_S = 1.5  # a device that does not answer keeps the next one waiting for so long at most
LAST_S = 1.0  # of a last pass: kept for the read-back
NOT_READ = (
    "the drive voltage was not read back: that starts the inputs, and with them a run that the "
    "board may still hold"
)
NOT_SAFE = "THE OUTPUT IS NOT KNOWN TO BE SAFE"
_AGAIN_S = 0.05
_FAILED = " failed: "  # between what was tried and why not, in most errors' texts
_READ_BACKS = 10  # the voltage may need a moment to fall: 0.2 s in all


class Safety(StrEnum):
    """What is known of the voltage at the sheet."""

    SAFE = "safe"  # 0 V was written, and read back
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class SafetyReport:
    """How making safe went. `failures`: a sentence each, those overcome included."""

    state: Safety
    read_back_V: float | None  # the sheet voltage last seen; None: it could not be seen
    failures: tuple[str, ...]

    @property
    def is_safe(self) -> bool:
        """Whether 0 V was written and read back."""
        return self.state is Safety.SAFE

    @property
    def text(self) -> str:
        """One sentence for the operator."""
        seen = "not read back"
        if self.read_back_V is not None:
            seen = f"read back as {self.read_back_V:.3f} V"
        why = summary_of(self.failures)
        if self.is_safe:
            return f"the output is safe: 0 V written and {seen}" + (f" (but {why})" if why else "")
        return (
            f"{NOT_SAFE} ({seen}): switch the amplifier off by hand; {why or 'no cause is known'}"
        )


def make_safe(
    output: VoltageOutput,
    signals: SignalInput,
    clock: Clock,
    drive_channel: str,
    safe_below_V: float,
    until_s: float | None = None,
    not_yet: Callable[[], object] = lambda: None,
) -> SafetyReport:
    """Write 0 V, then read `drive_channel` until it is below `safe_below_V`. Never raises.

    Each device has its turn, whatever became of the other, and its own time: it is tried again for
    `PATIENCE_S`, and left alone when it has not answered in `DEVICE_S`. Devices that are not open
    are opened. Both stay open: closing them is the caller's. The acquisition is stopped, whatever
    was running.

    Where 0 V could not be written to an output that may hold a run, nothing is read back: the start
    of the inputs would start the run.

    `until_s`: a clock time at which all of it ends instead. 0 V is tried until `LAST_S` before it.
    For the last pass, after which nobody else tries.

    `not_yet` is called where 0 V could not be written, before the read-back: it may take a while.
    """
    failures: list[str] = []
    seen: list[float] = []

    def read_back() -> None:
        attempt(failures, signals.stop)
        signals.open()
        row = list(signals.channels).index(drive_channel)
        seen.append(
            mean_when_low(lambda: float(np.mean(signals.measure(READ_BACK_S)[row])), safe_below_V)
        )

    def ends(reserve_s: float) -> tuple[float, float]:
        if until_s is not None:
            return until_s - reserve_s, until_s - reserve_s
        return clock.now() + PATIENCE_S, clock.now() + DEVICE_S

    zero = partial(_zero, output, failures)
    written = _insist(failures, clock, "writing 0 V", zero, ends(LAST_S))
    if not written:
        attempt(failures, not_yet)
    if written or not (isinstance(output, TimedOutput) and output.is_timed):
        _insist(failures, clock, "reading the drive voltage back", read_back, ends(0.0))
    else:
        failures.append(NOT_READ)
    return judge(written, seen[-1] if seen else None, safe_below_V, failures)


def judge(
    written: bool, seen_V: float | None, safe_below_V: float, failures: list[str]
) -> SafetyReport:
    """Return the report: safe only when 0 V was written and read back."""
    low = seen_V is not None and abs(seen_V) < safe_below_V
    unique = list(dict.fromkeys(failures))  # a device that is tried again fails alike
    if seen_V is not None and not low:
        unique.append(f"the drive voltage reads {seen_V:.3f} V, not below {safe_below_V:g} V")
    state = Safety.SAFE if written and low else Safety.UNKNOWN
    return SafetyReport(state, seen_V, tuple(unique))


def summary_of(failures: Iterable[str]) -> str:
    """Return failures as one text; those of one cause stand together before it."""
    kept: dict[str, list[str]] = {}
    for failure in failures:
        what, parted, cause = failure.partition(_FAILED)
        kept.setdefault(cause if parted else failure, []).extend([what] * bool(parted))
    return "; ".join(
        f"{', '.join(whats)}{_FAILED}{cause}" if whats else cause for cause, whats in kept.items()
    )


def attempt(failures: list[str], action: Callable[[], object]) -> bool:
    """Do it; add a failure as a sentence; return whether it went well."""
    try:
        action()
    except DeviceError as fault:
        failures.append(str(fault))
        return False
    except (Exception, SystemExit) as fault:  # noqa: BLE001 - nothing may keep the next device from its turn
        failures.append(f"unexpected {type(fault).__name__}: {fault}")
        return False
    return True


def report_of(action: Callable[[], object]) -> SafetyReport:
    """Return the report of a rescue that should never raise; one that does has not made it safe."""
    failures: list[str] = []
    found: list[object] = []
    if attempt(failures, lambda: found.append(action())) and isinstance(found[0], SafetyReport):
        return found[0]
    failures = failures or ["the code that makes the boards safe gave no report"]
    return SafetyReport(Safety.UNKNOWN, None, tuple(failures))


def in_time(clock: Clock, what: str, action: Callable[[], object], limit_s: float) -> None:
    """Do it in a thread of its own, and leave that behind when the time is over.

    Raises what `action` raises, or DeviceTimeoutError.
    """
    raised: list[BaseException] = []

    def work() -> None:
        try:
            action()
        except BaseException as fault:  # noqa: BLE001 - raised again, where it is waited for
            raised.append(fault)

    try:
        thread = clock.start_thread(work, what)
    except RuntimeError:  # the interpreter is being ended and starts no thread any more
        action()
        return
    if not thread.join(limit_s):
        raise DeviceTimeoutError(f"{what} has not come to an end in {limit_s:.3g} s")
    if raised:
        raise raised[0]


def mean_when_low(measure: Callable[[], float], safe_below_V: float) -> float:
    """Measure until it is low, a few times at most; returns the last value."""
    value = measure()
    for _ in range(_READ_BACKS - 1):
        if abs(value) < safe_below_V:
            break
        value = measure()
    return value


def _insist(
    failures: list[str],
    clock: Clock,
    what: str,
    action: Callable[[], object],
    ends_s: tuple[float, float],
) -> bool:
    """Try again until the first of two clock times; the attempts end at the second.

    The first attempt has its time, whatever the first says.
    """
    until_s, end_s = ends_s
    for tries in itertools.count(1):
        left_s = max(0.0, end_s - clock.now())
        if attempt(failures, lambda: in_time(clock, what, action, left_s)):  # noqa: B023 - at once
            return True
        if clock.now() + _AGAIN_S >= (until_s if tries > 1 else end_s):
            break
        clock.sleep_until(clock.now() + _AGAIN_S)
    return False


def _zero(output: VoltageOutput, failures: list[str]) -> None:
    """Write 0 V; where that fails, open the output (again) first."""
    if not attempt(failures, lambda: output.write(0.0)):
        output.open()
        output.write(0.0)
