"""What a session is run with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import (
    Camera,
    DeviceError,
    FloatArray,
    Operator,
    Positioner,
    SignalInput,
    VoltageOutput,
)


def unchanged(volts: FloatArray) -> FloatArray:
    """The volts at the board are the quantity itself."""
    return volts


def nothing(volts: FloatArray) -> None:
    """No check at all."""


@dataclass(frozen=True)
class Devices:
    """The rig, opened, and what its volts mean. Whoever opened the devices closes them.

    Of the input's channels `force` and `drive` (the sheet's voltage as read back) are needed;
    without `current` the current is recorded as NaN.
    """

    output: VoltageOutput
    signals: SignalInput
    camera: Camera | None
    stage: Positioner
    # `ask` must come back, with False, when a stop is requested while it waits. A manual stage and
    # this field share one RecordedOperator, or the stage's questions are not told as events.
    operator: Operator
    newtons: Callable[[FloatArray], FloatArray]
    amperes: Callable[[FloatArray], FloatArray] = unchanged
    # Called with every block of raw force volts; raises OverloadError to trip.
    protect: Callable[[FloatArray], object] = nothing


@dataclass(frozen=True)
class ReadingSinks:
    """In which rows of a block the channels are; -1 where there is none."""

    force: int
    drive: int
    current: int

    @classmethod
    def of(cls, signals: SignalInput) -> ReadingSinks:
        """Raises DeviceError when a channel that is needed is missing."""
        names = list(signals.channels)
        for name in ("force", "drive"):
            if name not in names:
                found = ", ".join(names) or "none"
                raise DeviceError(
                    f"the signal input has no channel {name!r}, only {found}; wire it in [ni] of "
                    "rig.toml"
                )
        return cls(
            force=names.index("force"),
            drive=names.index("drive"),
            current=names.index("current") if "current" in names else -1,
        )

    def of_current(self, volts: FloatArray) -> FloatArray:
        """The row of the current, or NaN."""
        return volts[self.current] if self.current >= 0 else np.full(volts.shape[-1], np.nan)
