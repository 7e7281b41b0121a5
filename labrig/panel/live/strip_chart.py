"""Signals as a page draws them: the least and the most of each 10 ms, so that no spike is lost."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.panel.live.packing import pack

Floats = npt.NDArray[np.float32]

BIN_S = 0.01
SIGNALS, PREDICTED = "signals", "predicted"
KEEP_S = 60.0  # for who is slow or comes later


@dataclass(frozen=True, eq=False, kw_only=True)
class StripChart:
    """A piece of one run's signals: `values` (1 + 2 keys, count), rows as `names` says."""

    run: int
    keys: tuple[str, ...]  # of the channels: drive_V, force_mN
    values: Floats
    fresh: bool = False  # earlier ones are to be forgotten
    kind: str = SIGNALS  # measured, or predicted by a model

    @property
    def names(self) -> list[str]:
        """Names of the rows: the time, then the least and the most of each channel."""
        return ["run_s", *(f"{key}_{end}" for key in self.keys for end in ("least", "most"))]

    def header(self) -> dict[str, Any]:
        """Return what stands before the numbers."""
        return {
            "type": self.kind,
            "run": self.run,
            "keys": list(self.keys),
            "rows": self.names,
            "count": self.values.shape[1],
            "fresh": self.fresh,
        }

    def packed(self) -> bytes:
        """As a binary frame."""
        return pack(self.header(), np.ascontiguousarray(self.values, dtype="<f4").tobytes())

    def as_fresh(self) -> StripChart:
        """Return the same, for somebody who knows nothing of it yet."""
        return replace(self, fresh=True)


def strip_from(header: dict[str, Any], payload: memoryview) -> StripChart:
    """Return the reverse of `StripChart.packed`. Raises ValueError, KeyError."""
    keys = tuple(str(key) for key in header["keys"])
    values = np.frombuffer(payload, dtype="<f4").reshape(1 + 2 * len(keys), int(header["count"]))
    return StripChart(
        run=int(header["run"]),
        keys=keys,
        values=values,
        fresh=bool(header["fresh"]),
        kind=str(header["type"]),
    )


def joined(strips: list[StripChart]) -> list[StripChart]:
    """Pieces of the same run made one, and not longer than `KEEP_S`; of other runs, kept apart.

    A fresh piece makes those of its kind before it pointless.
    """
    kinds: dict[str, list[StripChart]] = {}
    for strip in strips:
        kinds.setdefault(strip.kind, []).append(strip)
    return [strip for of_kind in kinds.values() for strip in _joined(of_kind)]


def newest_of_each(strips: list[StripChart]) -> list[StripChart]:
    """Return the last of each kind."""
    return list({strip.kind: strip for strip in strips}.values())


def _joined(strips: list[StripChart]) -> list[StripChart]:
    found: list[StripChart] = []
    for strip in strips:
        if strip.fresh or not found or found[-1].run != strip.run:
            found = [] if strip.fresh else found[-1:]
            found.append(strip)
        else:
            last = found[-1]
            values = np.concatenate([last.values, strip.values], axis=1)
            most = round(KEEP_S / BIN_S)
            cut = values.shape[1] > most
            found[-1] = replace(last, values=values[:, -most:] if cut else values)
    return found


class Envelope:
    """Makes strips of the samples of one run as they come."""

    def __init__(self, run: int, keys: Sequence[str]) -> None:
        self._run = run
        self._keys = tuple(keys)
        self._rest = np.empty((1 + len(self._keys), 0))  # samples whose 10 ms are not over
        self._fresh = True

    def add(self, samples: npt.NDArray[np.float64]) -> StripChart | None:
        """Add `samples` (1 + keys, n), run_s and each key's values; return a strip if due."""
        known = np.concatenate([self._rest, samples], axis=1)
        bins = np.floor(known[0] / BIN_S + 1e-6).astype(np.int64)
        whole = int(np.searchsorted(bins, bins[-1])) if bins.size else 0
        self._rest = known[:, whole:]
        if not whole:
            return None
        starts = np.flatnonzero(np.diff(bins[:whole], prepend=bins[0] - 1))
        least = np.fmin.reduceat(known[1:, :whole], starts, axis=1)
        most = np.fmax.reduceat(known[1:, :whole], starts, axis=1)
        values = np.empty((1 + 2 * len(self._keys), len(starts)), dtype=np.float32)
        values[0] = (bins[starts] + 0.5) * BIN_S
        values[1::2], values[2::2] = least, most
        fresh, self._fresh = self._fresh, False
        return StripChart(run=self._run, keys=self._keys, values=values, fresh=fresh)
