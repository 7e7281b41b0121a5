"""Pieces of an open session file as Python values."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

import h5py
import numpy as np

from labrig.config import parse_json
from labrig.config.load_cell import raw_force_unit
from labrig.errors import BadInputError
from labrig.files import typed
from labrig.serialise import from_plain
from labrig.session.format import layout
from labrig.session.format.channels import channels_of
from labrig.session.format.devices import RecordedDevice
from labrig.session.format.extras import with_extras
from labrig.session.format.layout import Array
from labrig.session.format.setup import DEVICES_SINCE, SessionSetup, check_recorded
from labrig.session.recording.disk import is_of_writing
from protocols.errors import ScheduleError
from protocols.planning.schedule import Schedule


@contextmanager
def damage_told(path: Path, what: str = "the file") -> Iterator[None]:
    """Yield what the library says of a damaged file, as BadInputError in a sentence."""
    try:
        yield
    except (KeyError, OSError, RuntimeError) as error:
        if is_of_writing(error):  # another file, into which this one is copied
            raise
        raise BadInputError(
            f"{path}: {what} is damaged ({error}); where its journal still lies beside the file, "
            f"run labrig recover {typed(path)}."
        ) from None


def _require_open(file: Any, path: Path) -> None:
    if not file:  # h5py's closed objects are false
        raise BadInputError(f"{path}: this session was closed; open it again.")


def read_dataset(file: Any, name: str, path: Path) -> Any:
    """Return a dataset by its full name. Raises BadInputError when it is not there."""
    _require_open(file, path)
    with damage_told(path, name):
        found = file.get(name)
    if not isinstance(found, h5py.Dataset):
        raise BadInputError(f"{path}: {name} is missing, so this is no whole session.")
    return found


def read_array(dataset: Any, path: Path, rows: Any = ()) -> Array:
    """Return some or all of a dataset. Raises BadInputError when its bytes are damaged."""
    with damage_told(path, str(dataset.name)):
        return np.asarray(dataset[rows])


def read_text(file: Any, name: str, path: Path) -> str:
    """Return a scalar text."""
    value = read_array(read_dataset(file, name, path), path)
    if value.shape != () or value.dtype.kind != "S":
        raise BadInputError(f"{path}: {name} is no text, so this is no whole session.")
    try:
        return bytes(value[()]).decode("utf-8")
    except UnicodeDecodeError:
        raise BadInputError(f"{path}: {name} is damaged; it is no text in UTF-8.") from None


def text_attribute(item: Any, name: str) -> str:
    """Return a text attribute, of fixed length before version 5; empty where there is none."""
    value = item.attrs.get(name, "")
    return value.decode("utf-8", "replace") if isinstance(value, bytes) else str(value)


def read_texts(file: Any, name: str, path: Path) -> dict[str, str]:
    """All texts of a group."""
    _require_open(file, path)
    with damage_told(path, name):
        group = file.get(name)
        if not isinstance(group, h5py.Group):
            raise BadInputError(f"{path}: {name} is missing, so this is no whole session.")
        return {key: read_text(file, f"{name}/{key}", path) for key in group}


def dataset_names(file: Any, path: Path) -> set[str]:
    """Return the full names of all datasets."""
    found: set[str] = set()

    def note(name: str, item: Any) -> None:
        if isinstance(item, h5py.Dataset):
            found.add(f"/{name}")

    with damage_told(path):
        file.visititems(note)
    return found


def read_table(file: Any, name: str, kind: np.dtype[Any], path: Path) -> Array:
    """Return a table, its texts as str. Raises BadInputError when it has other columns."""
    dataset = read_dataset(file, name, path)
    if dataset.dtype != kind or len(dataset.shape) > 1:
        raise BadInputError(f"{path}: {name} has other columns than a session has.")
    return with_str(read_array(dataset, path))


def with_str(table: Array) -> Array:
    """Return the structured array with its bytes decoded to str."""
    columns = {name: table.dtype[name] for name in table.dtype.names or ()}
    wanted = [
        (name, f"<U{kind.itemsize}" if kind.kind == "S" else kind) for name, kind in columns.items()
    ]
    decoded = np.empty(table.shape, dtype=wanted)
    for name, kind in columns.items():
        values = table[name]
        decoded[name] = np.char.decode(values, "utf-8", "replace") if kind.kind == "S" else values
    return decoded


def read_setup(file: Any, path: Path) -> SessionSetup:
    """Return what the file was created from."""

    def scalar(name: str) -> Any:
        return read_array(read_dataset(file, f"{layout.SETUP}/{name}", path), path)[()]

    version = int(file.attrs["labrig_format"])
    signals = read_table(file, f"{layout.SETUP}/signals", layout.SIGNAL_ROWS[version], path)
    has_frames = f"{layout.SETUP}/frame_shape" in file
    shape = scalar("frame_shape") if has_frames else None
    frame_dtype = read_text(file, f"{layout.SETUP}/frame_dtype", path) if has_frames else "uint8"
    try:
        resolved = _resolved(file, path)
        schedule = from_plain(Schedule, _json(file, "schedule", path), "schedule")
        if f"{layout.SETUP}/extras" in file:
            schedule = with_extras(schedule, _json(file, "extras", path))
        check_recorded(schedule)
        return SessionSetup(
            schedule=schedule,
            texts=read_texts(file, f"{layout.SETUP}/texts", path),
            resolved=resolved,
            version=version,
            signals=channels_of(signals, version, raw_force_unit(resolved)),
            rate_hz=float(scalar("rate_hz")),
            frame_shape=None if shape is None else (int(shape[0]), int(shape[1])),
            frame_dtype=frame_dtype,
            keep_all_frames=bool(scalar("keep_all_frames")),
            simulated=bool(scalar("simulated")),
            devices=_devices(file, version, path),
            identifier=read_text(file, f"{layout.ENTRY}/identifier", path),
            versions=read_texts(file, f"{layout.SETUP}/versions", path),
        )
    except (ScheduleError, TypeError, ValueError, IndexError) as error:
        raise BadInputError(f"{path}: what was planned cannot be read: {error}.") from None
    except BadInputError as error:
        if str(path) in str(error):
            raise
        said = str(error)
        raise BadInputError(f"{path}: {said[:1].lower()}{said[1:]}") from None


def _resolved(file: Any, path: Path) -> Any:
    resolved = _json(file, "resolved", path)
    if not isinstance(resolved, dict):
        raise BadInputError(f"{path}: {layout.SETUP}/resolved is no table.")
    return resolved


def _devices(file: Any, version: int, path: Path) -> tuple[RecordedDevice, ...]:
    if version < DEVICES_SINCE:
        return ()
    plain = _json(file, "devices", path)
    return from_plain(tuple[RecordedDevice, ...], plain, "devices", lenient=True)


def _json(file: Any, name: str, path: Path) -> Any:
    text = read_text(file, f"{layout.SETUP}/{name}", path)
    return parse_json(text, f"{path}: {layout.SETUP}/{name}")
