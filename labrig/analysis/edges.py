"""Where a run's voltage really changed: each step of the drive, as its read-back shows it."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from drivers.interfaces import FloatArray
from labrig.session import RunRecord

SEEN_FROM_V = 0.1  # a smaller step is not looked for; its time is that of its write
LEAST_SAMPLES = 2  # nor one that is next to another, with fewer samples than these at either level
SEARCH_S = 0.05  # to either side of the write
LEVEL_S = 0.02  # over which the level before and after an edge is taken
SETTLE_S = 0.003  # next to the edge, left out of that
AGREES_SAMPLES = 0.25  # the two clocks are not one: a write this far outside is taken as inside
_LEFT = 0.05  # of the step: beyond it the level before has been left


@dataclass(frozen=True)
class VoltageEdge:
    """One step of the voltage. `index` is a sample index with its fraction."""

    step: int
    index: float
    why: str  # not empty: the read-back does not show the edge, and `index` is that of the write


def find_edges(run: RunRecord, drive_V: FloatArray) -> dict[int, VoltageEdge]:
    """Return the run's steps by their number, as far as they were written.

    An edge lies between the last sample at the level before and the first one beyond it. Where in
    between is known better from the write's own time; so that stands, unless it lies clearly
    outside, when the middle of the two samples does.
    """
    writes = run.writes
    rate_hz = run.sample_clock.rate_hz
    found: dict[int, VoltageEdge] = {}
    for at, write in enumerate(writes):
        before_V = float(writes["sheet_V"][at - 1]) if at else 0.0
        jump_V = float(write["sheet_V"]) - before_V
        written = float(write["sample_index"])
        if abs(jump_V) < SEEN_FROM_V:
            found[int(write["step"])] = VoltageEdge(int(write["step"]), written, "")
            continue
        around = _WriteAndNeighbours(
            begin=float(writes["sample_index"][at - 1]) if at else -np.inf,
            written=written,
            end=float(writes["sample_index"][at + 1]) if at + 1 < len(writes) else np.inf,
            rate_hz=rate_hz,
        )
        if around.samples_between_writes < LEAST_SAMPLES:
            found[int(write["step"])] = VoltageEdge(int(write["step"]), written, "")
            continue
        left = _last_before(drive_V, around, jump_V)
        found[int(write["step"])] = _edge(int(write["step"]), written, left)
    return found


def _edge(step: int, written: float, left: int | None) -> VoltageEdge:
    if left is None:
        reach_ms = SEARCH_S * 1e3
        return VoltageEdge(
            step, written, f"the drive shows no edge within {reach_ms:g} ms of the write"
        )
    nearest = min(max(written, float(left)), left + 1.0)
    agrees = abs(nearest - written) <= AGREES_SAMPLES
    return VoltageEdge(step, nearest if agrees else left + 0.5, "")


@dataclass(frozen=True, kw_only=True)
class _WriteAndNeighbours:
    """A write and its neighbours, as sample indices with their fractions."""

    begin: float  # of the write before
    written: float
    end: float  # of the next write
    rate_hz: float

    @property
    def settle(self) -> int:
        return max(1, round(SETTLE_S * self.rate_hz))

    @property
    def samples_between_writes(self) -> float:
        """Fewest settled samples at the level before or after."""
        return min(self.written - self.begin, self.end - self.written) - self.settle - 1


def _last_before(drive_V: FloatArray, around: _WriteAndNeighbours, jump_V: float) -> int | None:
    """Return the index of the last sample at the old level before the edge.

    None when there is no edge.
    """
    settle, level = around.settle, max(3, round(LEVEL_S * around.rate_hz))
    search = max(2, round(SEARCH_S * around.rate_hz))
    at = int(np.floor(around.written))
    # the write before made a level of its own: it stands from a little later on
    first = int(max(0, at - search, min(around.begin + settle, at - settle)))
    last = int(min(at + search, around.end, len(drive_V)))
    before = drive_V[max(first, at - settle - level) : max(0, at - settle)]
    after = drive_V[max(last - level, at + 1) : last]
    if before.size == 0 or after.size == 0:
        return None
    old, new = float(np.median(before)), float(np.median(after))
    # At least half of what was written, and to the same side, is an edge; less is a disturbance.
    if not (new - old) * np.sign(jump_V) > 0.5 * abs(jump_V):
        return None
    gone = (drive_V[first:last] - old) / (new - old)
    beyond_half = np.flatnonzero(gone >= 0.5)
    # The search reaches back to before the write, where an edge of the step before may be.
    beyond_half = beyond_half[beyond_half >= _start_of_old(gone, at - settle - first)]
    if beyond_half.size == 0:
        return None
    crossing = int(beyond_half[0])
    still = np.flatnonzero(gone[:crossing] <= _LEFT)
    return first + int(still[-1]) if still.size else None


def _start_of_old(gone: FloatArray, settled: int) -> int:
    """Return from where on the samples up to `settled` lie at the old level without a break."""
    off = np.flatnonzero(np.abs(gone[: max(settled, 0)]) > _LEFT)
    return int(off[-1]) + 1 if off.size else 0
