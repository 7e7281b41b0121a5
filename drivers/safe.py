"""Make the output safe: 0 V written and seen on the read-back, or known to be unknown.

Every way out of the program comes through here, so nothing in here raises.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import StrEnum

import numpy as np

from drivers.interfaces import DeviceError, SignalInput, VoltageOutput

READ_BACK_S = 0.02
_READ_BACKS = 10  # the voltage may need a moment to fall: 0.2 s in all


class Safety(StrEnum):
    """What is known of the voltage at the sheet."""

    SAFE = "safe"  # 0 V was written, and read back
    UNKNOWN = "unknown"


@dataclass(frozen=True)
class SafetyReport:
    """How making safe went. `failures`: every one, in words, those overcome included."""

    state: Safety
    read_back_V: float | None  # the sheet voltage last seen; None: it could not be seen
    failures: tuple[str, ...]

    @property
    def text(self) -> str:
        """One sentence for the operator."""
        seen = "not read back"
        if self.read_back_V is not None:
            seen = f"read back as {self.read_back_V:.3f} V"
        why = "; ".join(self.failures)
        if self.state is Safety.SAFE:
            return f"the output is safe: 0 V written and {seen}" + (f" (but {why})" if why else "")
        return (
            f"THE OUTPUT IS NOT KNOWN TO BE SAFE ({seen}): switch the amplifier off by hand; "
            f"{why or 'no cause is known'}"
        )


def make_safe(
    output: VoltageOutput | None,
    signals: SignalInput | None,
    drive_channel: str,
    safe_below_V: float,
) -> SafetyReport:
    """Write 0 V, then look at `drive_channel` until it is below `safe_below_V`. Never raises.

    Devices that are not open are opened. Both stay open: closing them is the caller's. The
    acquisition is stopped, whatever was running.
    """
    failures: list[str] = []
    written = output is not None and _zero(output, failures)
    if output is None:
        failures.append("there is no output to write 0 V to")
    seen_V = None if signals is None else _read_back(signals, drive_channel, safe_below_V, failures)
    if signals is None:
        failures.append("there is no input to read the drive voltage back")
    return judge(written, seen_V, safe_below_V, failures)


def judge(
    written: bool, seen_V: float | None, safe_below_V: float, failures: list[str]
) -> SafetyReport:
    """The report: safe only when 0 V was written and seen."""
    low = seen_V is not None and abs(seen_V) < safe_below_V
    if seen_V is not None and not low:
        failures.append(f"the drive voltage reads {seen_V:.3f} V, not below {safe_below_V:g} V")
    state = Safety.SAFE if written and low else Safety.UNKNOWN
    return SafetyReport(state, seen_V, tuple(failures))


def attempt(failures: list[str], action: Callable[[], object]) -> bool:
    """Do it; note a failure in words and tell whether it went well."""
    try:
        action()
    except DeviceError as fault:
        failures.append(str(fault))
        return False
    except Exception as fault:  # noqa: BLE001 - nothing may keep the next device from its turn
        failures.append(f"unexpected {type(fault).__name__}: {fault}")
        return False
    return True


def mean_when_low(measure: Callable[[], float], safe_below_V: float) -> float:
    """Measure until it is low, a few times at most; returns the last value."""
    value = measure()
    for _ in range(_READ_BACKS - 1):
        if abs(value) < safe_below_V:
            break
        value = measure()
    return value


def _zero(output: VoltageOutput, failures: list[str]) -> bool:
    """Write 0 V; where that fails, open the output (again) first."""
    if attempt(failures, lambda: output.write(0.0)):
        return True
    return attempt(failures, output.open) and attempt(failures, lambda: output.write(0.0))


def _read_back(
    signals: SignalInput, drive_channel: str, safe_below_V: float, failures: list[str]
) -> float | None:
    seen: list[float] = []

    def look() -> None:
        row = list(signals.channels).index(drive_channel)
        signals.open()
        seen.append(
            mean_when_low(lambda: float(np.mean(signals.measure(READ_BACK_S)[row])), safe_below_V)
        )

    attempt(failures, signals.stop)
    attempt(failures, look)
    return seen[0] if seen else None
