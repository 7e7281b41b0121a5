"""What is known of a session before it begins; the file is made from it up front."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import sys
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from functools import lru_cache
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.serialise import SerialiseError, from_plain, to_json, to_plain
from labrig.session.format import layout
from labrig.session.format.channels import check_channels, value_columns, version_1_channel
from labrig.session.format.devices import RecordedDevice
from labrig.version import version
from protocols import Channel
from protocols.planning.limits import check_structure
from protocols.planning.schedule import Schedule

# Of the schedule of a session that was imported: it has no runs, and no camera was asked for it.
IMPORTED_FRAME_RATE_HZ = 25.0
DEVICES_SINCE = 3  # version of the layout
_MOST_HZ = 1e7
_MOST_PIXELS = 16_384  # rows or columns
_PACKAGES = ("numpy", "scipy", "h5py", "nidaqmx", "opencv-python-headless", "numba")


def present_versions() -> dict[str, str]:
    """Return versions of labrig, its packages and plug-ins, Python and the platform."""
    return dict(_versions_at(tuple(sys.path)))


@lru_cache(maxsize=8)
def _versions_at(path: tuple[str, ...]) -> dict[str, str]:
    """Return them as seen from these places; the files of each distribution are read once."""
    del path
    found = {"python": platform.python_version(), "platform": platform.platform()}
    found |= _plugin_versions()
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "absent"
    return found | {"labrig": version()}


def _plugin_versions() -> dict[str, str]:
    """Return the version of each distribution that adds parts to labrig's plug-in folders."""
    found = importlib.metadata.entry_points()
    own = [
        entry
        for group in found.groups
        if group.startswith("labrig.")
        for entry in found.select(group=group)
    ]
    return {entry.dist.name: entry.dist.version for entry in own if entry.dist is not None}


def check_recorded(schedule: Schedule) -> None:
    """Raise ScheduleError for a schedule that is none; unlike one to be run it may have no runs."""
    if schedule != Schedule(schedule.protocol, (), IMPORTED_FRAME_RATE_HZ):
        check_structure(schedule)


@dataclass(frozen=True, kw_only=True)
class SessionSetup:
    """Everything the file is created from."""

    schedule: Schedule
    texts: Mapping[str, str]  # configuration files as used: name -> content
    resolved: Mapping[str, Any]  # the same as understood, plain JSON
    signals: tuple[Channel, ...]  # in the order of the rows of samples
    rate_hz: float
    frame_shape: tuple[int, int] | None  # None: no camera
    frame_dtype: str = "uint8"
    keep_all_frames: bool = False
    simulated: bool = False
    devices: tuple[RecordedDevice, ...] = ()
    identifier: str = field(default_factory=lambda: str(uuid.uuid4()))
    versions: Mapping[str, str] = field(default_factory=present_versions)
    version: int = layout.FORMAT  # of the layout: that of an older session that is recovered

    def __post_init__(self) -> None:
        _check_names("channel", self.channels, reserved=("time",))
        _check_names("configuration file", tuple(self.texts))
        check_channels(self.signals, self.version)
        _check_numbers(self.rate_hz, self.frame_shape)
        if np.dtype(self.frame_dtype) not in (np.dtype(np.uint8), np.dtype(np.uint16)):
            raise BadInputError(
                f"Frames of type {self.frame_dtype} cannot be recorded; the camera must deliver "
                "grey pictures of 8 or 16 bit."
            )

    @property
    def channels(self) -> tuple[str, ...]:
        """Names of the channels."""
        return tuple(channel.name for channel in self.signals)

    @property
    def value_columns(self) -> tuple[str, ...]:
        """Columns of a reading that hold the channels' values."""
        return value_columns(self.signals, self.version)

    @property
    def reading_row(self) -> np.dtype[Any]:
        """Type of a row of the readings."""
        return layout.reading_row(self.value_columns)

    def to_json(self) -> str:
        """Return it as one JSON object."""
        return to_json(self)

    @classmethod
    def from_json(cls, text: str) -> SessionSetup:
        """Return the setup of a text; raises ValueError for another one."""
        plain = json.loads(text)
        if not isinstance(plain, dict):
            raise SerialiseError("setup: a table is wanted")
        if "version" not in plain:
            plain = _of_version_1(plain)
        if plain["version"] not in layout.READABLE:
            raise SerialiseError(f"setup: version {plain['version']!r} of the layout is not known")
        setup = from_plain(cls, plain, "setup")
        check_recorded(setup.schedule)
        return setup


def _of_version_1(plain: dict[str, Any]) -> dict[str, Any]:
    """Return the plain setup of version 1 with the keys of today."""
    rest = {key: value for key, value in plain.items() if key not in ("channels", "ranges_V")}
    names, ranges_V = plain.get("channels"), plain.get("ranges_V")
    if not isinstance(names, list) or not isinstance(ranges_V, list):
        raise SerialiseError("setup: channels and ranges_V must be lists")
    channels = [
        version_1_channel(str(name), float(range_V))
        for name, range_V in zip(names, ranges_V, strict=True)
    ]
    return {**rest, "version": 1, "signals": to_plain(channels)}


def _check_numbers(rate_hz: float, frame_shape: tuple[int, int] | None) -> None:
    if not 0 <= rate_hz <= _MOST_HZ:
        raise BadInputError(f"A sample rate of {rate_hz} Hz cannot be recorded.")
    if frame_shape is not None and not all(0 < size <= _MOST_PIXELS for size in frame_shape):
        raise BadInputError(f"Frames of {frame_shape} pixels cannot be recorded.")


def _check_names(what: str, names: Sequence[str], reserved: tuple[str, ...] = ()) -> None:
    for name in names:
        if not name or "/" in name or name in {".", ".."} or name in reserved or len(name) > 60:
            raise BadInputError(f"{name!r} cannot be the name of a {what} in a session file.")
    if len(set(names)) != len(names):
        raise BadInputError(f"Two have the same {what} name among {', '.join(names)}.")
