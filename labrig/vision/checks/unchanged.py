"""A check of another distribution leaves the image and the fit as they are."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from typing import TypeVar

import numpy as np

from labrig.vision.checks.seen_curve import SeenCurve

T = TypeVar("T")


def asked_unchanged(finding: Callable[[SeenCurve], T], seen: SeenCurve) -> T:
    """Return what a check says of a curve. Raises ValueError where it writes into an array of it.

    What it wrote is undone: all other checks, and all other curves, are found in the same image.
    """
    before = [(name, array, array.copy()) for name, array in _arrays(seen)]
    try:
        found = finding(seen)
    finally:  # also where it failed after it had written
        written = [name for name, array, kept in before if _restored(array, kept)]
    if written:
        raise ValueError(f"it changes {written[0]}, which must stay as it is; work on a copy")
    return found


def _restored(array: np.ndarray, kept: np.ndarray) -> bool:
    """Put the values back; False: they are the same."""
    if np.array_equal(array, kept, equal_nan=True):
        return False
    array[...] = kept
    return True


def _arrays(seen: SeenCurve) -> Iterator[tuple[str, np.ndarray]]:
    """Yield the arrays of a curve and its image, also those that were measured on them."""
    parts = {"image": seen.image, "fit": seen.fit, "fit.shape": seen.fit.shape, "": seen}
    for prefix, part in parts.items():
        for name, value in vars(part).items():
            if isinstance(value, np.ndarray):
                yield ".".join(filter(None, ("seen", prefix, name))), value
