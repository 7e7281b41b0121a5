"""The stage's settings: which there are, what they may be, who may change them."""

from __future__ import annotations

from dataclasses import dataclass

MICROSTEPS_PER_TURN = 1_536_000  # 360 / 0.000234375
RESOLUTION = 64
SPEED_UNIT = 1.6384
_ANYWHERE = 1_000_000_000


@dataclass(frozen=True)
class _Setting:
    default: float
    lowest: int | None = None  # None: cannot be written
    highest: int = 0
    device_only: bool = False


# Names, ranges and units are the protocol manual's; the identity, speeds and acceleration are only
# plausible for this stage, so a driver must ask for them instead of knowing them.
_TABLE = {
    "deviceid": _Setting(50081, device_only=True),
    "version": _Setting(6.28, device_only=True),
    "system.serial": _Setting(60001, device_only=True),
    "system.axiscount": _Setting(1, device_only=True),
    "system.voltage": _Setting(47.9, device_only=True),
    "system.temperature": _Setting(31.2, device_only=True),
    "system.access": _Setting(1, 1, 2, device_only=True),
    "comm.address": _Setting(1, 1, 99, device_only=True),
    "comm.alert": _Setting(0, 0, 1, device_only=True),
    "comm.checksum": _Setting(0, 0, 1, device_only=True),
    "resolution": _Setting(RESOLUTION),
    "maxspeed": _Setting(153_600, 1, RESOLUTION * 16384),
    "limit.approach.maxspeed": _Setting(153_600, 1, RESOLUTION * 16384),
    "accel": _Setting(205, 0, 32767),
    "limit.min": _Setting(0, -_ANYWHERE, _ANYWHERE),
    "limit.max": _Setting(MICROSTEPS_PER_TURN, -_ANYWHERE, _ANYWHERE),
}


class Settings:
    """The values. Unknown names raise KeyError, values out of range ValueError."""

    def __init__(self) -> None:
        self._values = {name: setting.default for name, setting in _TABLE.items()}

    def __getitem__(self, name: str) -> float:
        return self._values[name]

    def is_device_only(self, name: str) -> bool:
        """Return whether the setting belongs to the device, not to its axis."""
        return _TABLE[name].device_only

    def write(self, name: str, value: int) -> None:
        """Change a setting; KeyError also for those that can only be read."""
        setting = _TABLE[name]
        if setting.lowest is None:
            raise KeyError(name)
        if not setting.lowest <= value <= setting.highest:
            raise ValueError(name)
        self._values[name] = value

    @property
    def speed(self) -> float:
        """Top speed in microsteps/s."""
        return self["maxspeed"] / SPEED_UNIT

    @property
    def homing_speed(self) -> float:
        """Top speed while homing in microsteps/s."""
        return min(self["limit.approach.maxspeed"], self["maxspeed"]) / SPEED_UNIT

    @property
    def acceleration(self) -> float:
        """In microsteps/s^2; the setting 0 stands for as fast as can be."""
        return (self["accel"] or 1e9) * 10_000 / SPEED_UNIT
