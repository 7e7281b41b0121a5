"""How a hidden kind of the world `relaxation` acts: functions with its size last."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from benchmarks.worlds.contract import HiddenKind
from benchmarks.worlds.generators._relaxation_strip import Array, Lanes, Rows, Setting, Strip
from benchmarks.worlds.session.effects import Acting, Load
from benchmarks.worlds.session.layout import FRAME, Samples


@dataclass
class Picture:
    """Frames of a configuration: (frames, places), but for the samples and contacts (frames,)."""

    strip: Strip
    at: Samples
    contact_m: Array  # along the sheet; beyond its end where nothing holds it
    s_m: Array  # (places,)
    x_m: Array
    y_m: Array
    phi_rad: Array

    def shift(self, dx_m: Array | float, dy_m: Array | float) -> None:
        """Move points."""
        self.x_m, self.y_m = self.x_m + dx_m, self.y_m + dy_m

    def aside(self, along_normal_m: Array) -> None:
        """Move points along the sheet's normal."""
        self.shift(-along_normal_m * np.sin(self.phi_rad), along_normal_m * np.cos(self.phi_rad))


@dataclass(frozen=True, kw_only=True)
class Act(Acting):
    """A kind, and where it acts."""

    alters: Callable[[Setting, Strip, float], None] | None = None
    lanes: Callable[[Lanes, Samples, Strip, float], None] | None = None
    rubs: Callable[[Array, Samples, float], Array] | None = None  # contact_m -> force over |N|
    felt: Callable[[Load, Strip, float], Array] | None = None  # added to the force, N
    seen: Callable[[Picture, float], None] | None = None


def act(
    words: str, known_as: str | None, locations: str, sizes: tuple[float, float], unit: str,
    needs: tuple[str, ...] = (), **hooks: Any,
) -> Act:  # fmt: skip
    """Make a kind; `sizes` are the typical and the largest, `locations` are words."""
    kind = HiddenKind(
        words=words, known_as=known_as, locations=tuple(locations.split()), typical=sizes[0],
        largest=sizes[1], unit=unit, needs=needs, own_form="parameters" in hooks,
    )  # fmt: skip
    return Act(kind=kind, **hooks)


def with_frames(at: Samples, find: Callable[[Samples], Array]) -> Array:
    """Return what depends on the history of each run; frames are given the value of their time.

    `find` has the samples of one run in the order of time.
    """
    result = np.zeros(len(at.run))
    for rows in at.each_run():
        result[rows] = find(at.take(rows))
        to_frames(at, rows, result)
    return result


def to_frames(at: Samples, rows: Rows, values: Array) -> None:
    """Give the frames of a run what is between the values of its other samples."""
    frames = np.flatnonzero((at.run == at.run[rows[0]]) & (at.role == FRAME))
    values[frames] = np.interp(at.time_s[frames], at.time_s[rows], values[rows])


def lagged(at: Samples, constant_s: float, rise_s: float) -> Array:
    """Return a voltage that follows the sheet's by a first-order lag, at samples of one run.

    Slots are as long as the samples' phases say; before the first all is at rest.
    """
    slots, first = np.unique(at.slot, return_index=True)
    wanted, before = at.drive_V[first], at.before_V[first]
    length = float((at.time_s - at.phase_s)[first][-1]) / max(int(slots[-1]), 1)
    own = (before - wanted) / (1.0 - constant_s / rise_s)
    own = np.where(before == wanted, 0.0, own)

    def after(slot: Array, start: Array, t: Array) -> Array:
        fast, slow = np.exp(-t / rise_s), np.exp(-t / constant_s)
        left = start - wanted[slot] - own[slot]
        return np.asarray(wanted[slot] + own[slot] * fast + left * slow)

    starts = np.zeros(len(slots))
    for k in range(1, len(slots)):
        starts[k] = after(np.array(k - 1), starts[k - 1], np.array(length))
    slot = np.searchsorted(slots, at.slot)
    return after(slot, starts[slot], np.maximum(at.phase_s, 0.0))
