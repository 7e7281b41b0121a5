"""Where the output is, for whoever must make it safe from outside, and `labrig safe` itself."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

from drivers.amplifier import Amplifier
from drivers.boards.ni.connection import NiConnection
from drivers.boards.ni.rescue import OutputPlace, take_over
from drivers.interfaces import DeviceError, RealClock
from drivers.safe_shutdown import Safety, SafetyReport
from labrig.config import ReplayConfig, RigConfig, load_rig


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
        interlock_task=config.ni.task_names.interlock if config.interlock else None,
    )


def make_rig_safe(rig: Path) -> SafeReport:
    """Free the rig's tasks, write 0 V, read it back. Raises only for what rig.toml says wrongly."""
    config = load_rig(rig)
    if isinstance(config, ReplayConfig) or config.is_simulated:
        return SafeReport(is_safe=True, text="a simulated output ends with its program: 0 V")
    connection = NiConnection(config.ni.address)
    try:
        connection.open()
        report = take_over(connection, RealClock(), output_place(config))
    except DeviceError as fault:
        report = SafetyReport(Safety.UNKNOWN, None, (str(fault),))
    finally:
        connection.close()
    return SafeReport(report.is_safe, report.text)
