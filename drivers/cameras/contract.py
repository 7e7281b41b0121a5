"""A kind of camera: its settings in rig.toml, and how to make a `Camera` of it.

A module of this folder, or a distribution with an entry point of the group `labrig.cameras`, adds
a kind by the constant `CAMERA`. `drivers.interfaces.Camera` says what a camera does when;
`camera_faults` in `conformance` finds one that does not.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

from drivers.cameras.pixel_formats import check_pixel_format
from drivers.interfaces import (
    FREE,
    HARDWARE,
    SOFTWARE,
    AcquisitionSettings,
    Camera,
    Clock,
    DeviceIdentity,
    TriggerPulse,
)
from drivers.kinds import kind_faults
from drivers.plugins import PluginFolder

FALLBACK = "opencv"  # the kind that opens a source which no other kind answers to
ADDRESSES = frozenset(
    {"file:", "ftp:", "http:", "https:", "rtmp:", "rtp:", "rtsp:", "tcp:", "udp:"}
)
ALL_SETTINGS = frozenset(
    {"exposure_s", "gain", "pixel_format", "region", "frame_rate_hz", "trigger"}
)


def _check_region(value: tuple[int, int, int, int]) -> None:
    if value[2] == 0 or value[3] == 0:
        raise ValueError("must be [left, top, width, height] with a width and a height above 0")


def _check_trigger(value: str) -> None:
    if value not in (FREE, SOFTWARE, HARDWARE):
        raise ValueError(f"must be one of {FREE}, {SOFTWARE}, {HARDWARE}")


@dataclass(frozen=True, kw_only=True)
class CameraSettings:
    """The keys of [camera] that every kind has; a kind with more keys derives from it."""

    source: int | str = field(metadata={"description": "what to open, such as 0 or iidc:GUID"})
    exposure_s: float | None = field(
        default=None,
        metadata={
            "gt": 0,
            "le": 1.0,
            "unit": "s",
            "description": "of a frame; the sheet in time is compared with the middle of it. Only "
            "stated where the camera cannot set it",
        },
    )
    gain: float | None = field(
        default=None, metadata={"description": "in the camera's own unit, dB on most"}
    )
    pixel_format: str | None = field(
        default=None,
        metadata={
            "check": check_pixel_format,
            "description": "Mono8 to Mono16, plain or packed, or BayerRG8 and its like; all "
            "become grey",
        },
    )
    region: tuple[int, int, int, int] | None = field(
        default=None,
        metadata={
            "check": _check_region,
            "items": {"ge": 0, "le": 16384},
            "unit": "px",
            "description": "left, top, width, height of the part of the sensor that is sent",
        },
    )
    frame_rate_hz: float | None = field(
        default=None,
        metadata={
            "gt": 0,
            "le": 2000,
            "unit": "1/s",
            "description": "of a free camera; the protocol's where it is not given",
        },
    )
    trigger: str = field(
        default=FREE,
        metadata={
            "check": _check_trigger,
            "description": "free: the camera runs by itself; software: a command begins each "
            "exposure; hardware: trigger_line of the boards does",
        },
    )
    trigger_input: str = field(
        default="Line0",
        metadata={"description": "input of the camera that a hardware trigger is wired to"},
    )

    def acquisition(self) -> AcquisitionSettings:
        """Return what the camera is to be set to."""
        return AcquisitionSettings(
            exposure_s=self.exposure_s,
            gain=self.gain,
            pixel_format=self.pixel_format,
            region=self.region,
            frame_rate_hz=self.frame_rate_hz,
            trigger=self.trigger,
        )


class SoftwareTrigger:
    """The camera's own command as a `FrameTrigger`; whoever has the camera opens and closes it."""

    def __init__(self, camera: Camera) -> None:
        self._camera = camera

    def open(self) -> None:
        """See `FrameTrigger.open`."""

    def fire(self) -> TriggerPulse:
        """See `FrameTrigger.fire`."""
        return self._camera.fire()

    def close(self) -> None:
        """See `FrameTrigger.close`."""


@dataclass(frozen=True, kw_only=True)
class CameraKind:
    """A kind of camera."""

    kind: str
    help: str  # one line
    settings: type[CameraSettings] = CameraSettings
    # Make a camera, not open yet, from its settings, a clock, and the frames per second that the
    # protocol asks for. Touches no device.
    make: Callable[[Any, Clock, float], Camera]
    prefix: str = ""  # of the sources that it answers to, such as "iidc:"; empty: by `kind` only
    # which of ALL_SETTINGS it can set; others are refused before anything is opened. A camera that
    # lacks one of these all the same refuses it in `open`.
    sets: frozenset[str] = frozenset()
    # Return the cameras that are there, with the source of each as `name`. Raises DeviceError;
    # blocks for 5 s at most. None: they cannot be listed.
    find: Callable[[], Sequence[DeviceIdentity]] | None = None
    # Lines of TOML for [camera], with comments, that `labrig init --camera` starts with; the second
    # one for a rig that needs no hardware. Empty: there is nothing to start from.
    starter: str = ""
    simulated_starter: str = ""


def faults(part: object) -> list[str]:
    """Return what is wrong with a kind of camera, a sentence each."""
    calls = {"make": ("settings", "clock", "rate_hz"), "find": ()}
    found = list(kind_faults(part, CameraKind, calls, needed=("source",)))
    if not isinstance(part, CameraKind):
        return found
    if not isinstance(part.sets, frozenset):  # other people's may be anything
        found.append(f'its sets are {part.sets!r}, not names such as frozenset({{"gain"}})')  # type: ignore[unreachable]
    elif not part.sets <= ALL_SETTINGS:
        found.append(f"it sets {', '.join(sorted(part.sets - ALL_SETTINGS))}, which is no setting")
    return found + _prefix_faults(part)


def _prefix_faults(part: CameraKind) -> list[str]:
    prefix: object = part.prefix  # other people's may be anything
    if prefix == "":
        return []
    if not (isinstance(prefix, str) and re.fullmatch(r"[A-Za-z][\w+.-]+:", prefix)):
        return [f'its prefix is {prefix!r} where a word and a colon are needed, such as "iidc:"']
    if prefix in ADDRESSES:
        return [f"its prefix {prefix} is that of addresses, which OpenCV opens"]
    owners = [
        name
        for name, other in CAMERAS.own().items()
        if other.part.prefix == prefix and name != part.kind
    ]
    return [f"its prefix {prefix} is that of the camera {name}" for name in owners]


CAMERAS: PluginFolder[CameraKind] = PluginFolder(
    what="camera",
    package="drivers.cameras",
    constant="CAMERA",
    group="labrig.cameras",
    faults=faults,
    claim=lambda part: f"its prefix {part.prefix}" if part.prefix else "",
)


def kind_of_source(source: object) -> str:
    """Return the name of the kind that opens a [camera] source."""
    if isinstance(source, str):
        for name, part in CAMERAS.parts().items():
            if part.part.prefix and source.startswith(part.part.prefix):
                return name
    return FALLBACK
