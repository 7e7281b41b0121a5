"""What the guard must know, and the messages that it and the program exchange."""

from __future__ import annotations

import json
from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from drivers.interfaces import DeviceError

HEARTBEAT_S = 0.05
HEARTBEAT_LIMIT_S = 0.4
# At 0 V nobody is in danger, and a device that is slow may still answer.
AT_ZERO_LIMIT_S = 15.0

# From the program, one byte each, after a first line with the settings as JSON; and the life signs
# of `suspect`, while it does not beat.
BEAT, NEW_RUN, ENERGISED, AT_ZERO, DISARM, ACT = b".", b"N", b"E", b"Z", b"D", b"A"
RUN_OVER = b"O"  # its program beats no more until the next run
# To the program, a line each.
READY, ALIVE, ACTING, REPORT, FAILED = "ready", "alive", "acting", "report", "failed"


@dataclass(frozen=True, kw_only=True)
class GuardSettings:
    """Where the output is, and how long the program may be silent or energise the sheet."""

    boards: str  # the kind of the family (`drivers.boards.BOARD_FAMILIES`)
    place: Mapping[str, Any]  # from the family's `output_place`
    time_under_voltage_s: float = 30.0  # in one run, all its pulses together
    heartbeat_limit_s: float = HEARTBEAT_LIMIT_S
    # The same at 0 V, within a run; None: a program that hangs at 0 V is left alone.
    at_zero_limit_s: float | None = None
    report_path: str | None = None  # where the guard leaves its report when it has acted
    address: str = ""  # of the boards, for the words of the report
    program_pid: int = 0  # filled in by `Guard.start`

    def to_json(self) -> str:
        """One line."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> GuardSettings:
        """Read what `to_json` wrote; DeviceError when it does not fit."""
        try:
            return cls(**json.loads(text))
        except (ValueError, TypeError) as fault:
            raise DeviceError(f"the guard's settings cannot be read: {fault}") from fault
