"""What a session is run with."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from contextlib import contextmanager
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import (
    Camera,
    Clock,
    DeviceError,
    FloatArray,
    FrameTrigger,
    Operator,
    Positioner,
    SignalInput,
    VoltageOutput,
    in_words,
)
from protocols.execution.channels import Channel, ChannelRows
from protocols.execution.event_bus import SubscriberError
from protocols.execution.operator import NoAnswerError

MOVING = "moving the load cell"
# A stage cannot be stopped: when a run is broken off, this long is waited for its move to end.
PATIENCE_S = 5.0


@contextmanager
def of_the_stage() -> Iterator[None]:
    """Make a DeviceError of what a stage raises against its contract.

    A manual stage asks the operator, and what is asked is an event: their errors are not its own.
    """
    try:
        yield
    except (DeviceError, NoAnswerError, SubscriberError):
        raise
    except (Exception, SystemExit) as fault:
        raise DeviceError(f"the stage failed: {in_words(fault)}") from fault


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
    trigger: FrameTrigger | None = None  # what begins the camera's exposures; None: it runs free
    stage: Positioner
    stage_name: str = ""  # in rig.toml
    # `ask` must come back, with False, when a stop is requested while it waits. A manual stage and
    # this field share one RecordedOperator, or the stage's questions are not emitted.
    operator: Operator
    channels: tuple[Channel, ...]  # one for each channel of `signals`
    # Called with every block of raw force volts; raises OverloadError to trip.
    protect: Callable[[FloatArray], object] = nothing

    def rows(self) -> ChannelRows:
        """Return the channels in the order of the signals' rows. Raises DeviceError."""
        return ChannelRows.of(self.signals, self.channels)

    def move_stage(self, position_m: float) -> bool:
        """Move the load cell; False when the operator declined. Raises DeviceError."""
        with of_the_stage():
            done: object = self.stage.move_to(position_m)
        if isinstance(done, bool | np.bool_):
            return bool(done)
        name = f" '{self.stage_name}'" if self.stage_name else ""
        raise DeviceError(f"the stage{name} answered {done!r} to move_to, neither True nor False")

    def stage_position_m(self) -> float | None:
        """Return what the stage reports; None: it has no sensor. Raises DeviceError."""
        with of_the_stage():
            found = self.stage.position()
            return None if found is None else float(found)


class StageMove:
    """One move, in a thread of its own: `Devices.move_stage` blocks, and samples must be read.

    It begins when it is created.
    """

    def __init__(self, devices: Devices, clock: Clock, position_m: float) -> None:
        self.position_m = position_m
        self.began_s = clock.now()
        self.ended_s = self.began_s
        self.reported_m: float | None = None  # by the stage, once there; None: it has no sensor
        self._devices = devices
        self._clock = clock
        self._ended = False
        self._agreed = False
        self._fault: BaseException | None = None
        self._thread = clock.start_thread(self._move, MOVING)

    @property
    def ended(self) -> bool:
        """Whether the load cell stands again, or could not be moved."""
        return self._ended

    def arrived(self) -> bool:
        """Return whether it has been moved; False: the operator declined.

        Raises what the stage raised. Called once it has ended.
        """
        if self._fault is not None:
            raise self._fault
        return self._agreed

    def wait(self) -> None:
        """Wait until it has ended, but no longer than `PATIENCE_S`."""
        if not self._ended:
            self._thread.join(PATIENCE_S)

    def _move(self) -> None:
        try:
            self._agreed = self._devices.move_stage(self.position_m)
            self.ended_s = self._clock.now()
            self.reported_m = self._devices.stage_position_m() if self._agreed else None
        except (Exception, SystemExit) as fault:  # noqa: BLE001 - raised again in the run's own thread
            self._fault = fault
        finally:
            self._ended = True
