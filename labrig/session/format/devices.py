"""The devices of a session as its file describes them: what each of them said that it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from drivers.interfaces import DeviceIdentity

BOARDS = "boards"
_UNKNOWN = DeviceIdentity()


@dataclass(frozen=True, kw_only=True)
class CalibrationRecord:
    """The calibration by which a part without a voice of its own is known."""

    name: str  # of its file
    date: str = ""  # ISO 8601; empty: the file gives none
    sha256: str = ""  # of the file's text


@dataclass(frozen=True, kw_only=True)
class RecordedDevice:
    """A device of the rig."""

    part: str  # boards, camera, stage, force_sensor, amplifier, load_cell
    kind: str = ""  # as in rig.toml, such as ni
    identity: DeviceIdentity = _UNKNOWN
    calibration: CalibrationRecord | None = None


def any_simulated(devices: Iterable[RecordedDevice]) -> bool:
    """Whether a device reported that it is simulated."""
    return any(device.identity.is_simulated for device in devices)
