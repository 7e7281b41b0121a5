"""What a session is run with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from drivers.interfaces import (
    Camera,
    FloatArray,
    Operator,
    Positioner,
    SignalInput,
    VoltageOutput,
)
from protocols.execution.channels import Channel, ChannelRows


def nothing(volts: FloatArray) -> None:
    """Check nothing."""


@dataclass(frozen=True, kw_only=True)
class Devices:
    """The rig, opened, and what its volts mean. Whoever opened the devices closes them.

    Of the input's channels `force` and `drive` (the sheet's voltage as read back) are needed; there
    may be any others.
    """

    output: VoltageOutput
    signals: SignalInput
    camera: Camera | None
    stage: Positioner
    # `ask` must come back, with False, when a stop is requested while it waits. A manual stage and
    # this field share one RecordedOperator, or the stage's questions are not emitted.
    operator: Operator
    channels: tuple[Channel, ...]  # one for each channel of `signals`
    # Called with every block of raw force volts; raises OverloadError to trip.
    protect: Callable[[FloatArray], object] = nothing

    def rows(self) -> ChannelRows:
        """Return the channels in the order of the signals' rows. Raises DeviceError."""
        return ChannelRows.of(self.signals, self.channels)
