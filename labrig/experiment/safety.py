"""`labrig safe`, and where the output is, for processes outside the run."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from drivers.amplifier import Amplifier
from drivers.boards import OutputRescue
from drivers.interfaces import RealClock
from drivers.safe_shutdown import Safety, SafetyReport, attempt, report_of
from labrig.config import OutputConfig, ReplayConfig, load_output

_PATIENCE_S = 5.0  # with a device that another program still holds


@dataclass(frozen=True)
class SafeReport:
    """What became of it."""

    is_safe: bool
    text: str


def output_place(config: OutputConfig) -> dict[str, Any]:
    """Return where the output is, as plain data for another process."""
    limits = config.limits
    amplifier = Amplifier(config.amplifier.gain, limits.sheet_voltage_V)
    return config.family.output_place(
        config.boards.settings(),
        amplifier.limit_board_V,
        limits.safe_below_V,
        config.interlock_line,
    )


def make_rig_safe(rig: Path) -> SafeReport:
    """Free the rig's tasks, write 0 V, read it back. Raises only for rig.toml's own faults."""
    config = load_output(rig)
    if isinstance(config, ReplayConfig) or config.is_simulated:
        return SafeReport(is_safe=True, text="a simulated output ends with its program: 0 V")
    report = _made_safe(config)
    return SafeReport(report.is_safe, report.text)


def _made_safe(config: OutputConfig) -> SafetyReport:
    make = config.family.rescue
    if make is None:
        why = f"boards of [{config.boards_kind}] cannot be made safe by another process"
        return SafetyReport(Safety.UNKNOWN, None, (why,))
    failures: list[str] = []
    opened: list[OutputRescue] = []

    def open_one() -> None:
        rescue = make(output_place(config), RealClock())
        opened.append(rescue)
        rescue.open()

    try:
        if not attempt(failures, open_one):
            return SafetyReport(Safety.UNKNOWN, None, tuple(failures))
        return report_of(lambda: opened[0].make_safe(_PATIENCE_S, lambda: None))
    finally:
        for rescue in opened:
            attempt([], rescue.close)
