"""What keeps or makes the output safe beside the run itself: the guard, and `labrig safe`."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from drivers.amplifier import Amplifier
from drivers.guard import Guard, GuardSettings
from drivers.interfaces import DeviceError, RealClock
from drivers.ni_connection import NiConnection
from drivers.safe import Safety
from drivers.take_over import OutputPlace, take_over
from labrig.config import ReplayConfig, RigConfig, load_rig
from labrig.errors import NotReadyError
from labrig.experiment.rig import Rig
from labrig.experiment.run import Unwatched, Watch

_GRACE_S = 1.0  # the schedule was checked against the limit; the guard acts when it is passed


@contextmanager
def guard_of(rig: Rig) -> Iterator[Watch]:
    """The guard process while a real rig is run; nobody while a simulated one is.

    A simulated output lives in this process and ends with it. Raises NotReadyError when the guard
    cannot start: nothing is energised without it.
    """
    if rig.config.is_simulated:
        yield Unwatched()
        return
    settings = GuardSettings(
        output_place(rig.config), rig.config.limits.time_under_voltage_s + _GRACE_S
    )
    try:
        guard = Guard.start(settings)
    except DeviceError as fault:
        raise NotReadyError(str(fault)) from fault
    try:
        yield guard
    finally:
        guard.disarm()  # acts first when 0 V was not confirmed


@dataclass(frozen=True)
class SafeReport:
    """What became of it."""

    is_safe: bool
    text: str


def output_place(config: RigConfig) -> OutputPlace:
    """Where the output is, as another process must know it."""
    amplifier = Amplifier(config.amplifier.gain, config.limits.sheet_voltage_V)
    return OutputPlace(
        address=config.ni.address,
        output_channel=config.ni.drive,
        drive_channel=config.ni.drive_readback,
        limit_board_V=amplifier.limit_board_V,
        drive_range_V=config.ni.ranges_V.drive,
        drive_terminals="differential",
        safe_below_V=config.limits.safe_below_V,
        output_task=config.ni.task_names.output,
        input_task=config.ni.task_names.input,
    )


def make_rig_safe(rig: Path) -> SafeReport:
    """Free the rig's tasks, write 0 V, read it back."""
    config = load_rig(rig)
    if isinstance(config, ReplayConfig) or config.is_simulated:
        return SafeReport(is_safe=True, text="a simulated output ends with its program: 0 V")
    connection = NiConnection(config.ni.address)
    connection.open()
    try:
        report = take_over(connection, RealClock(), output_place(config))
    finally:
        connection.close()
    return SafeReport(report.state is Safety.SAFE, report.text)
