"""The part of the T-series register map that labrig uses, and what differs from model to model.

Addresses and types are those of LabJack's published map (ljm_constants.json). A register holds 16
bits, so that a FLOAT32 or UINT32 takes two; the high one comes first.
"""

from __future__ import annotations

import math
import re
import struct
from dataclasses import dataclass
from enum import Enum


class Kind(Enum):
    """How a value is held: struct's letter, and how many registers."""

    U16 = ("H", 1)
    U32 = ("I", 2)
    F32 = ("f", 2)

    @property
    def registers(self) -> int:
        """How many registers a value takes."""
        return int(self.value[1])

    def pack(self, value: float) -> bytes:
        """Return a value as it is sent."""
        plain = float(value) if self is Kind.F32 else int(value)
        return struct.pack(f">{self.value[0]}", plain)

    def unpack(self, data: bytes) -> float:
        """Return a value as it was received."""
        return float(struct.unpack(f">{self.value[0]}", data)[0])


@dataclass(frozen=True)
class Register:
    """One value of the map."""

    address: int
    kind: Kind


PRODUCT_ID = Register(60000, Kind.F32)
FIRMWARE_VERSION = Register(60004, Kind.F32)
SERIAL_NUMBER = Register(60028, Kind.U32)
LAST_ERROR = Register(55000, Kind.U16)

# RAM that no part of the device uses; it is 0 after power-up. labrig notes in it who drives.
OWNER = Register(46178, Kind.U32)  # USER_RAM39_U32

SCAN_RATE_HZ = Register(4002, Kind.F32)
NUM_ADDRESSES = Register(4004, Kind.U32)
SETTLING_US = Register(4008, Kind.F32)
STREAM_RESOLUTION = Register(4010, Kind.U32)
BUFFER_BYTES = Register(4012, Kind.U32)
AUTO_TARGET = Register(4016, Kind.U32)
DATA_TYPE = Register(4018, Kind.U32)  # must be 0; not in the map's file, but on its page
NUM_SCANS = Register(4020, Kind.U32)
STREAM_ENABLE = Register(4990, Kind.U32)
SCAN_LIST = 4100  # UINT32 each
STREAM_DATA = 4500  # samples, backlog, status, more; then the samples, one register each
COMMAND_RESPONSE = 16  # of AUTO_TARGET: the data wait until they are read

FLASH_POINTER = Register(61810, Kind.U32)
FLASH_READ = 61812

WATCHDOG_ENABLE = Register(61600, Kind.U32)
WATCHDOG_ADVANCED = Register(61602, Kind.U32)
WATCHDOG_TIMEOUT_S = Register(61604, Kind.U32)
WATCHDOG_STARTUP_S = Register(61606, Kind.U32)
WATCHDOG_STRICT = Register(61610, Kind.U32)
WATCHDOG_KEY = Register(61612, Kind.U32)
WATCHDOG_CLEAR = Register(61614, Kind.U32)
WATCHDOG_RESET = Register(61620, Kind.U32)
WATCHDOG_DIO = Register(61630, Kind.U32)
WATCHDOG_DIO_STATE = Register(61632, Kind.U32)
WATCHDOG_DIO_DIRECTION = Register(61634, Kind.U32)
WATCHDOG_DIO_INHIBIT = Register(61636, Kind.U32)
WATCHDOG_DAC = (Register(61640, Kind.U32), Register(61650, Kind.U32))
WATCHDOG_DAC_V = (Register(61642, Kind.F32), Register(61652, Kind.F32))

_OUTPUT = re.compile(r"(TDAC|DAC)(\d{1,2})")
_INPUT = re.compile(r"AIN(\d{1,2})")
_LINE = re.compile(r"(DIO|FIO|EIO|CIO|MIO)(\d{1,2})")
_LINES = {"DIO": (0, 23), "FIO": (0, 8), "EIO": (8, 8), "CIO": (16, 4), "MIO": (20, 3)}


def is_tick_dac(name: str) -> bool:
    """Whether an output is one of an LJTick-DAC, which gives ±10 V."""
    return name.startswith("TDAC")


def tick_dac_lines(name: str) -> tuple[int, ...]:
    """Return the numbers of the two lines that an LJTick-DAC is plugged into; none: it is none."""
    if not is_tick_dac(name):
        return ()
    first = int(name.removeprefix("TDAC")) // 2 * 2
    return first, first + 1


def output_register(name: str) -> Register:
    """Return the register of TDAC0 to TDAC21, DAC0 or DAC1; ValueError for another name."""
    match = _OUTPUT.fullmatch(name)
    most = {"TDAC": 21, "DAC": 1}
    if match is None or int(match[2]) > most[match[1]]:
        raise ValueError("must be an output: TDAC0 to TDAC21 of an LJTick-DAC, DAC0 or DAC1")
    return Register((30000 if match[1] == "TDAC" else 1000) + 2 * int(match[2]), Kind.F32)


def input_number(name: str) -> int:
    """Return the number of AIN0 to AIN13; ValueError for another name."""
    match = _INPUT.fullmatch(name)
    if match is None or int(match[1]) > 13:
        raise ValueError("must be an analog input, AIN0 to AIN13")
    return int(match[1])


def line_number(name: str) -> int:
    """Return the number of a digital line, DIO0 to DIO22; ValueError for another name."""
    match = _LINE.fullmatch(name)
    if match is not None:
        first, count = _LINES[match[1]]
        if int(match[2]) < count:
            return first + int(match[2])
    raise ValueError("must be a digital line, such as EIO0 or DIO8")


def line_register(number: int) -> Register:
    """Return the register of a digital line; a write makes it an output."""
    return Register(2000 + number, Kind.U16)


def input_register(number: int) -> Register:
    """Return the register that measures an analog input, in V."""
    return Register(2 * number, Kind.F32)


def range_register(number: int) -> Register:
    """Return the register of an input's range, in V."""
    return Register(40000 + 2 * number, Kind.F32)


def negative_register(number: int) -> Register:
    """Return the register of the input that an input is measured against."""
    return Register(41000 + number, Kind.U16)


@dataclass(frozen=True, kw_only=True)
class Model:
    """What differs from model to model."""

    name: str
    product_id: int
    inputs: int
    ranges_V: tuple[float, ...]
    differential: str  # how an input is measured against another one
    dac_V: float  # largest voltage of DAC0 and DAC1
    flash: int  # where the calibration begins

    def range_for(self, range_V: float) -> float:
        """Return the smallest range that carries a voltage; the largest where none does."""
        return min((r for r in self.ranges_V if r >= range_V), default=max(self.ranges_V))


# T7: an even input and the next one are a pair. T8: each input has its own negative terminal.
# T4: its inputs are measured against ground, AIN0 to AIN3 with ±10 V.
PAIRS, OWN, NONE = "pairs", "own", "none"
MODELS = {
    each.name: each
    for each in (
        Model(
            name="T4",
            product_id=4,
            inputs=4,
            ranges_V=(10.0,),
            differential=NONE,
            dac_V=5.0,
            flash=0x3C4000,
        ),
        Model(
            name="T7",
            product_id=7,
            inputs=14,
            ranges_V=(0.01, 0.1, 1.0, 10.0),
            differential=PAIRS,
            dac_V=5.0,
            flash=0x3C4000,
        ),
        Model(
            name="T8",
            product_id=8,
            inputs=8,
            ranges_V=(0.018, 0.036, 0.075, 0.15, 0.3, 0.6, 1.2, 2.4, 4.8, 9.6, 11.0),
            differential=OWN,
            dac_V=10.0,
            flash=0x687000,
        ),
    )
}


def model_of(product_id: float) -> Model | None:
    """Return the model with this number; None: not of the T-series that is known here."""
    if not math.isfinite(product_id):
        return None
    return next((m for m in MODELS.values() if m.product_id == round(product_id)), None)
