"""A kind of camera: its settings in rig.toml, and how to make a `Camera` of it.

A module of this folder, or a distribution with an entry point of the group `labrig.cameras`, adds
a kind by the constant `CAMERA`. `drivers.interfaces.Camera` says what a camera does when;
`camera_faults` in `conformance` finds one that does not.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import Any

from drivers.interfaces import Camera, Clock
from drivers.kinds import kind_faults
from drivers.plugins import PluginFolder

FALLBACK = "opencv"  # the kind that opens a source which no other kind answers to


@dataclass(frozen=True)
class CameraSettings:
    """The keys of [camera] that every kind has; a kind with more keys derives from it."""

    source: int | str = field(metadata={"description": "what to open, such as 0 or iidc:GUID"})


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


def faults(part: object) -> list[str]:
    """Return what is wrong with a kind of camera, a sentence each."""
    return list(kind_faults(part, CameraKind, ("make",), needed=("source",)))


CAMERAS: PluginFolder[CameraKind] = PluginFolder(
    what="camera",
    package="drivers.cameras",
    constant="CAMERA",
    group="labrig.cameras",
    faults=faults,
)


def kind_of_source(source: object) -> str:
    """Return the name of the kind that opens a [camera] source."""
    if isinstance(source, str):
        for name, part in CAMERAS.parts().items():
            if part.part.prefix and source.startswith(part.part.prefix):
                return name
    return FALLBACK
