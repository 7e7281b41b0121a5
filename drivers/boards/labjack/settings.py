"""The table [labjack] of rig.toml."""

from __future__ import annotations

from dataclasses import dataclass, field

from drivers.boards.labjack.registers import (
    MODELS,
    input_number,
    is_tick_dac,
    line_number,
    output_register,
)
from drivers.boards.labjack.wire import host_and_port


def check_model(value: str) -> None:
    """Raise ValueError unless a device can be of this model."""
    if value not in MODELS:
        raise ValueError(f"must be one of {', '.join(MODELS)}")


def _input(default: str, description: str) -> str:
    facts = {"check": input_number, "description": description}
    name: str = field(default=default, metadata=facts)
    return name


def _range(default: float, description: str) -> float:
    facts = {"gt": 0, "le": 11.0, "unit": "V", "description": description}
    largest: float = field(default=default, metadata=facts)
    return largest


@dataclass(frozen=True, kw_only=True)
class LabJackRanges:
    """Largest voltage expected at each input; the device rounds it up to a range it has."""

    force: float = _range(0.05, "V, either sign, of the load cell")
    current: float = _range(0.5, "V, either sign, across the shunt")
    drive: float = _range(5.0, "V, either sign, at the sheet")


@dataclass(frozen=True, kw_only=True)
class LabJackSettings:
    """A LabJack T4, T7 or T8 on the network."""

    address: str = field(
        default="simulated",
        metadata={
            "check": host_and_port,
            "description": "address of the device on the network, or simulated",
        },
    )
    model: str = field(
        default="T7",
        metadata={"check": check_model, "description": "T4, T7 or T8; another one is refused"},
    )
    serial: int | None = field(
        default=None,
        metadata={"ge": 1, "description": "serial number; a device with another one is refused"},
    )
    drive: str = field(
        default="TDAC0",
        metadata={
            "check": output_register,
            "description": "output that drives the amplifier: TDAC# of an LJTick-DAC, or DAC0 or "
            "DAC1 behind a stage",
        },
    )
    zero_V: float = field(
        default=0.0,
        metadata={
            "ge": -10.0,
            "le": 10.0,
            "unit": "V",
            "description": "voltage of the output that means 0 V at the sheet",
        },
    )
    stage_gain: float = field(
        default=1.0,
        metadata={
            "ge": -100.0,
            "le": 100.0,
            "description": "of a stage between output and amplifier, which puts out "
            "stage_gain * (output - zero_V)",
        },
    )
    force: str = _input("AIN0", "input of the load cell; on a T7 differential with the next one")
    current: str = _input("AIN2", "input of the current shunt")
    drive_readback: str = _input("AIN4", "input of the sheet voltage")
    sample_rate_hz: float = field(
        default=1000.0,
        metadata={"ge": 100.0, "le": 10_000.0, "unit": "1/s", "description": "of each channel"},
    )
    ranges_V: LabJackRanges = field(
        default=LabJackRanges(), metadata={"description": "of the inputs"}
    )

    def __post_init__(self) -> None:
        """Refuse what cannot drive a sheet with both signs."""
        if self.stage_gain == 0:
            raise ValueError("stage_gain = 0 would put out nothing")
        if not is_tick_dac(self.drive) and self.zero_V <= 0:
            raise ValueError(
                f"{self.drive} gives no negative voltage: set zero_V and stage_gain of the stage "
                "behind it (such as 2.5 and 4.0), or use an LJTick-DAC"
            )


def check_line(value: str) -> int:
    """Return a line's number, whatever its name: EIO0 is DIO8. ValueError where it can be none."""
    return line_number(value)
