"""What differs between two sessions."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np

from labrig.session.format.checksums import ATTRIBUTES_SINCE, blocks, covered, finished, version_of
from labrig.session.format.layout import DERIVED, SETUP
from labrig.session.reading.opening import open_file
from labrig.session.reading.session import VOLATILE, VOLATILE_UNDER
from labrig.session.reading.values import damage_told, dataset_names

# Where the derived measurements were taken from: differs with the file's name.
_VOLATILE = VOLATILE | {f"{DERIVED}/source"}
_DEVICES = {f"{SETUP}/devices"}


def compare_sessions(a: Path, b: Path) -> list[str]:
    """Return a sentence for each dataset that differs; none where they are equal to the last bit.

    Identifiers, times of day, versions and file names are left out of it.
    """
    with open_file(Path(a)) as first, open_file(Path(b)) as second:
        names_a, names_b = _names(first, Path(a)), _names(second, Path(b))
        if version_of(first) != version_of(second):  # only one of them has the devices
            names_a, names_b = names_a - _DEVICES, names_b - _DEVICES
        found = [f"{name} is only in {a}." for name in sorted(names_a - names_b)]
        found += [f"{name} is only in {b}." for name in sorted(names_b - names_a)]
        for name in sorted(names_a & names_b):
            with damage_told(Path(a), f"{name}, here or in {b},"):
                difference = _difference(first[name], second[name])
            if difference:
                found.append(f"{name} differs: {difference}.")
        with damage_told(Path(a), f"an attribute, here or in {b},"):
            return found + _attributes(first, second)


def _names(file: Any, path: Path) -> set[str]:
    names = dataset_names(file, path)
    return {name for name in names if not name.startswith(VOLATILE_UNDER)} - _VOLATILE


def _attributes(first: Any, second: Any) -> list[str]:
    """Return a sentence for each group or dataset of the recordings whose attributes differ."""
    if version_of(first) != version_of(second) or version_of(first) < ATTRIBUTES_SINCE:
        return []
    items_a, items_b = covered(first), covered(second)
    return [
        f"{name} differs: its attributes."
        for name in sorted(items_a.keys() & items_b.keys())
        if finished(items_a[name], ATTRIBUTES_SINCE) != finished(items_b[name], ATTRIBUTES_SINCE)
    ]


def _difference(a: Any, b: Any) -> str:
    if a.dtype != b.dtype:
        return f"its type is {a.dtype} and {b.dtype}"
    if a.shape != b.shape:
        return f"its shape is {a.shape} and {b.shape}"
    at = 0
    for part_a, part_b in zip(blocks(a), blocks(b), strict=True):
        unequal = _unequal_rows(part_a, part_b)
        if unequal.size:
            return f"first in row {at + unequal[0]}" if a.shape else "its value"
        at += len(part_a) if part_a.shape else 1
    return ""


def _unequal_rows(a: Any, b: Any) -> Any:
    """Rows whose bytes differ (so NaN equals NaN)."""
    count = len(a) if a.shape else 1
    if not count:
        return np.empty(0, dtype=int)
    bytes_a = np.ascontiguousarray(a).view(np.uint8).reshape(count, -1)
    bytes_b = np.ascontiguousarray(b).view(np.uint8).reshape(count, -1)
    return np.flatnonzero((bytes_a != bytes_b).any(axis=1))
