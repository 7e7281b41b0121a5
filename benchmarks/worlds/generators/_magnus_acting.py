"""How a hidden kind of this world acts, beyond what every generator's kinds may."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._magnus_rod import Cases
from benchmarks.worlds.session.effects import Acting, Image
from benchmarks.worlds.session.layout import READING, Samples

Array = npt.NDArray[np.float64]
SERIES = "series"


@dataclass
class Seen(Image):
    """Curves, and when each image was taken."""

    at: Samples


@dataclass(frozen=True, kw_only=True)
class Own(Acting):
    """`again` changes cases by what a first solution says: s_hat, N, the samples, the size."""

    again: Callable[[Cases, Array, Array, Samples, float], None] | None = None


def hidden(
    words: str, known_as: str | None, where: str, sizes: tuple[float, float], unit: str,
    needs: tuple[str, ...] = (), **hooks: Any,
) -> Own:  # fmt: skip
    """Make a kind; `sizes` are the typical and the largest."""
    kind = HiddenKind(
        words=words, known_as=known_as, locations=tuple(where.split()), typical=sizes[0],
        largest=sizes[1], unit=unit, needs=needs, own_form="parameters" in hooks,
    )  # fmt: skip
    return Own(kind=kind, **hooks)


def timing(at: Samples) -> tuple[float, float]:
    """Return how long a pulse is, and when after its edge a reading is taken."""
    later = at.slot > 0
    pulse = float(np.median((at.time_s - at.phase_s)[later] / at.slot[later]))
    return pulse, float(np.median(at.phase_s[at.role == READING]))


def per_slot(values: Array, at: Samples) -> tuple[Array, Array]:
    """Return the reading's value of each sample's slot, and of the slot before, run by run."""
    own, before = np.zeros(len(values)), np.zeros(len(values))
    for number in np.unique(at.run):
        rows = at.run == number
        read = rows & (at.role == READING)
        known = np.zeros(1 + int(np.max(at.slot[rows])))
        known[at.slot[read]] = values[read]
        own[rows] = known[at.slot[rows]]
        before[rows] = known[np.maximum(at.slot[rows] - 1, 0)]
    return own, before


def since_slot_before(values: Array, at: Samples) -> Array:
    """Return the change since the reading of the slot before; 0 until the first pulse."""
    _, before = per_slot(values, at)
    return np.where(at.pulse >= 0.0, values - before, 0.0)
