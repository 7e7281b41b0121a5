"""Adds to a session what only another, damaged one still holds, and cuts what is not whole."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np

from labrig.session.format import layout
from labrig.session.format.setup import SessionSetup
from labrig.session.reading.values import dataset_names
from labrig.session.recording.nexus import has_scan, scan_columns
from labrig.session.supplements.store import is_sealed


def add_missing(new: Any, old: Any, *, status_too: bool) -> list[str]:
    """Append the rows by which a dataset of `old` is longer; `status_too` copies scalars as well.

    Returns a sentence for each dataset of `old` that cannot be read.
    """
    notes: list[str] = []
    for name in sorted(dataset_names(new, Path(new.filename))):
        try:
            source = old[name]
            if new[name].shape == () or name.endswith("/acquisition"):
                if status_too:
                    _copy_value(new[name], source)
            elif name not in (layout.CHECKSUMS, f"{layout.SETUP}/signals"):
                _extend(new[name], source)
        except (KeyError, OSError, RuntimeError, TypeError, ValueError) as error:
            notes.append(f"{name} of the session file cannot be read ({error}).")
    return notes


def copy_supplements(new: Any, old: Any) -> list[str]:
    """Copy the supplements of `old` that are whole; returns a sentence for each other one."""
    notes: list[str] = []
    for name in layout.SUPPLEMENTS:
        try:
            if name not in old:
                continue
            if not is_sealed(old[name]):
                raise ValueError("its checksum is another one")
            old.copy(name, new[layout.ENTRY])
        except (KeyError, OSError, RuntimeError, ValueError) as error:
            notes.append(f"{name} of the session file is not whole and was left out ({error}).")
    return notes


def _copy_value(target: Any, source: Any) -> None:
    if source.shape != target.shape or source.dtype != target.dtype:
        raise ValueError("it has another type")
    target[()] = source[()]


def _extend(target: Any, source: Any) -> None:
    """Append what `source` has more, row by row as long as rows can be read."""
    if source.dtype != target.dtype or source.shape[1:] != target.shape[1:]:
        raise ValueError("it has another type")
    if target.maxshape[0] is not None:
        return
    step = target.chunks[0]
    while (have := target.shape[0]) < source.shape[0]:
        rows = source[have : min(have + step, source.shape[0])]
        target.resize(have + len(rows), axis=0)
        target[have:] = rows


def trim(file: Any, setup: SessionSetup) -> list[str]:
    """Cut columns that belong together to one length; returns a sentence for each that was cut."""
    notes: list[str] = []
    for run in setup.schedule.all_runs:
        group = file[layout.run_path(run.index)]
        notes.extend(_even(group["signals"], "samples"))
        if setup.frame_shape is not None:
            notes.extend(_even(group["frames"], "frames"))
        notes.extend(_loosen(group, setup))
    if has_scan(setup):
        _cut_scan(file, setup)
    return notes


def _cut_scan(file: Any, setup: SessionSetup) -> None:
    """Cut the columns of all readings to one length."""
    columns = [file[path] for path in scan_columns(setup)]
    least = min(column.shape[0] for column in columns)
    for column in columns:
        column.resize(least, axis=0)


def _even(group: Any, what: str) -> Iterator[str]:
    lengths = [group[name].shape[0] for name in group]
    least = min(lengths)
    if max(lengths) > least:
        for name in group:
            group[name].resize(least, axis=0)
        yield f"{group.name}: the last {max(lengths) - least} {what} are not whole and were cut."


def _loosen(group: Any, setup: SessionSetup) -> Iterator[str]:
    """Remove the frame from readings whose frame is not there any more."""
    frames = group["frames/images"].shape[0] if setup.frame_shape is not None else 0
    rows = group["readings"][()]
    lost = rows["frame"] >= frames
    if np.any(lost):
        rows["frame"][lost] = layout.NO_FRAME
        group["readings"][...] = rows
        yield f"{group.name}: the frames of {int(lost.sum())} readings were lost."
