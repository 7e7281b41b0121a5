"""What a device refuses, as Modbus and LabJack number it."""

from __future__ import annotations


class RefusedError(Exception):
    """A request is refused: Modbus exception code, and LabJack's own error."""

    def __init__(self, code: int, detail: int) -> None:
        super().__init__(f"{code}, {detail}")
        self.code = code
        self.detail = detail


ILLEGAL_FUNCTION, ILLEGAL_ADDRESS, ILLEGAL_VALUE, DEVICE_FAILED = 1, 2, 3, 4
NO_REGISTER, WRONG_SIZE, READ_ONLY = 0, 2313, 0  # 0: Modbus' own code says it
BAD_RANGE, BAD_PAIR = 2370, 2373
STREAM_ACTIVE, NOT_STREAMABLE, RATE_TOO_GREAT, BAD_BUFFER, NO_STREAM = 2605, 2607, 2608, 2615, 2620
NO_OUTPUT, NO_TICK_DAC, WATCHDOG_RUNS = 2762, 2764, 2671
