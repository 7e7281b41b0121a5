"""What is known of a session before it begins; the file is made from it up front."""

from __future__ import annotations

import importlib.metadata
import json
import platform
import uuid
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from labrig.errors import BadInputError
from labrig.session import layout
from labrig.session.channels import check_channels, value_columns, version_1_channel
from protocols import Channel, schedule_from_dict, schedule_to_dict
from protocols.planning.schedule import Schedule

_MOST_HZ = 1e7
_MOST_PIXELS = 16_384  # rows or columns
_CHANNEL_KEYS = ("name", "quantity", "unit", "range_V", "gain", "offset")
_PACKAGES = ("labrig", "numpy", "scipy", "h5py", "nidaqmx", "opencv-python-headless", "numba")


def present_versions() -> dict[str, str]:
    """Return versions of labrig, its packages and plug-ins, Python and the platform."""
    found = {"python": platform.python_version(), "platform": platform.platform()}
    found |= _plugin_versions()
    for package in _PACKAGES:
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            found[package] = "absent"
    return found


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


def schedule_back(plain: Any) -> Schedule:
    """The schedule that `schedule_to_dict` was given; unlike one to be run it may have no runs.

    Raises ScheduleError.
    """
    if isinstance(plain, dict) and plain == schedule_to_dict(_imported(plain)):
        return _imported(plain)
    return schedule_from_dict(plain)


def _imported(plain: Mapping[str, Any]) -> Schedule:
    return Schedule(str(plain.get("protocol")), (), 25.0)


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
        plain = {
            "version": self.version,
            "schedule": schedule_to_dict(self.schedule),
            "texts": dict(self.texts),
            "resolved": dict(self.resolved),
            "signals": [_plain_channel(channel) for channel in self.signals],
            "rate_hz": self.rate_hz,
            "frame_shape": self.frame_shape,
            "frame_dtype": self.frame_dtype,
            "keep_all_frames": self.keep_all_frames,
            "simulated": self.simulated,
            "identifier": self.identifier,
            "versions": dict(self.versions),
        }
        return json.dumps(plain)

    @classmethod
    def from_json(cls, text: str) -> SessionSetup:
        """Return the setup of a text; raises ValueError, KeyError or TypeError for another one."""
        plain = json.loads(text)
        shape = plain.pop("frame_shape")
        version = plain.pop("version", 1)
        if version not in layout.READABLE:
            raise ValueError(f"version {version} of the layout is not known")
        return cls(
            version=version,
            schedule=schedule_back(plain.pop("schedule")),
            signals=_channels_back(plain, version),
            frame_shape=None if shape is None else (int(shape[0]), int(shape[1])),
            **plain,
        )


def _plain_channel(channel: Channel) -> dict[str, Any]:
    return {key: getattr(channel, key) for key in _CHANNEL_KEYS}


def _channels_back(plain: dict[str, Any], version: int) -> tuple[Channel, ...]:
    """Take the channels out of the plain setup."""
    if version == 1:
        pairs = zip(plain.pop("channels"), plain.pop("ranges_V"), strict=True)
        return tuple(version_1_channel(str(name), float(volts)) for name, volts in pairs)
    return tuple(Channel(**channel) for channel in plain.pop("signals"))


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
