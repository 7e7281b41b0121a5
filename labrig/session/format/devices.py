"""The devices of a session as its file describes them: what each of them said that it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from drivers.interfaces import DeviceIdentity

BOARDS, CAMERA, STAGE = "boards", "camera", "stage"  # parts
FORCE_SENSOR, LOAD_CELL, AMPLIFIER = "force_sensor", "load_cell", "amplifier"
# Among the versions of a session that was recorded from another one: the other's identifier.
REPLAY_OF = "replay of"
NOT_KNOWN = "not known"
_STATES = {True: "simulated", False: "real", None: NOT_KNOWN}
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

    part: str
    kind: str = ""  # as in rig.toml, such as ni
    identity: DeviceIdentity = _UNKNOWN
    calibration: CalibrationRecord | None = None


def any_simulated(devices: Iterable[RecordedDevice]) -> bool:
    """Whether a device reported that it is simulated."""
    return any(device.identity.is_simulated for device in devices)


def boards_in_words(devices: Iterable[RecordedDevice], *, simulated: bool) -> str:
    """Return whether the boards of a session were simulated: each by name where they differ.

    `simulated`: what the file has in `setup/simulated`, which says "yes" or nothing.
    """
    boards = [device.identity for device in devices if device.part == BOARDS]
    known = {board.is_simulated for board in boards}
    if known <= {None}:
        return "simulated" if simulated else NOT_KNOWN
    if len(known) == 1:
        return _STATES[known.pop()]
    return ", ".join(f"{board.name} {_STATES[board.is_simulated]}" for board in boards)
