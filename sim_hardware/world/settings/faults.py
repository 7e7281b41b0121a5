"""The `[[faults]]` of a world.toml: what goes wrong, and when."""

from __future__ import annotations

from typing import Literal, Self

from pydantic import model_validator

from sim_hardware.world.settings.base import ClosedSettings, NotNegative, Positive

FaultKind = Literal[
    "daq_refused",
    "daq_hung",
    "daq_read_hung",
    "daq_slow",
    "daq_write_refused",
    "daq_reserved",
    "daq_buffer_overflow",
    "output_stuck",
    "output_underflow",
    "force_nan",
    "drive_nan",
    "current_saturated",
    "cell_unplugged",
    "cell_overloaded",
    "camera_late",
    "camera_dropped",
    "camera_frozen",
    "camera_black",
    "camera_wrong_size",
    "camera_gone",
    "serial_garbage",
    "serial_half_line",
    "serial_silent",
    "serial_unplugged",
    "clock_jump",
]


class FaultSettings(ClosedSettings):
    """Something that goes wrong for a while."""

    what: FaultKind
    from_s: NotNegative
    until_s: Positive | None = None
    """None: for good."""
    since: Literal["beginning", "first_voltage"] = "beginning"
    """Of the world's time, or from the first voltage other than 0 written to the board."""
    amount_s: Positive = 0.2
    """Of a delay, or a jump."""

    @model_validator(mode="after")
    def _in_order(self) -> Self:
        if self.until_s is not None and self.until_s <= self.from_s:
            raise ValueError(f"until_s = {self.until_s} must be later than from_s = {self.from_s}")
        return self
