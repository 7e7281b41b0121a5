"""Whose code a failure is of: a part of another distribution has authors of its own."""

from __future__ import annotations

from collections.abc import Iterator
from importlib.metadata import EntryPoint, entry_points
from pathlib import Path
from traceback import walk_tb

from drivers.interfaces import DeviceError, behind


def foreign_place(error: BaseException) -> str | None:
    """Return "distribution version (file.py, line 14)" of the innermost foreign part, or None.

    A module belongs to a part when an entry point of labrig's leads to it or into its package.
    """
    owners = {name: point for point in _points() for name in (point.module, _package(point))}
    for frame, line in reversed(list(walk_tb(error.__traceback__))):
        module = frame.f_globals.get("__name__", "")
        point = owners.get(module) or owners.get(module.partition(".")[0])
        if point is not None and point.dist is not None:
            file = Path(frame.f_code.co_filename).name
            return f"{point.dist.name} {point.dist.version} ({file}, line {line})"
    return None


def device_sentence(fault: DeviceError) -> str:
    """Return a device's sentence; with the place where a foreign part's code raised its cause.

    A DeviceError that the part itself has raised is meant for the operator as it is.
    """
    cause = behind(fault)
    place = None if isinstance(cause, DeviceError) else foreign_place(cause)
    return str(fault) if place is None else f"{fault}, in {place}"


def _points() -> Iterator[EntryPoint]:
    every = entry_points()
    for group in every.groups:
        if group.startswith("labrig."):
            yield from every.select(group=group)


def _package(point: EntryPoint) -> str:
    return point.module.partition(".")[0]
