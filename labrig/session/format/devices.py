"""The devices of a session as its file describes them: what each of them said that it is."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

from drivers.interfaces import FREE, AcquisitionSettings, DeviceIdentity

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
    acquisition: AcquisitionSettings | None = None  # of a camera, as read back from it


def acquisition_in_words(found: AcquisitionSettings | None) -> str:
    """Return what a camera had set, as far as it says; empty: it says nothing."""
    if found is None:
        return ""
    said = []
    if found.region is not None:
        left, top, width, height = found.region
        said.append(f"{width} x {height} at {left}, {top}")
    said.append(found.pixel_format or "")
    if found.exposure_s is not None:
        said.append(f"exposure {1e3 * found.exposure_s:g} ms")
    if found.gain is not None:
        said.append(f"gain {found.gain:g}")
    if found.frame_rate_hz is not None:
        said.append(f"{found.frame_rate_hz:g} frames/s")
    if found.trigger not in (None, FREE):
        said.append(f"{found.trigger} trigger")
    return ", ".join(each for each in said if each)


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
