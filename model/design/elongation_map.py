"""When a rigid elongation pays: least area with and without one, over working sections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.design.strength import (
    ELONGATION_R,
    Direction,
    elongated_lengths_m,
    lengths_alone_m,
    shortest_alone_m,
    strength,
)
from model.measurements import FloatArray, ModelError
from model.sheet.sheet_model import SheetModel

LENGTHS = 40  # that are tried, with and without an elongation


@dataclass(frozen=True, kw_only=True)
class ElongationMap:
    """Least area over force, m²/N, of sections from `low_m` (L,) to `high_m` (H,); (L, H) arrays.

    The area grows in proportion to the force, so that their ratio goes for every force. `inf`: no
    sheet of this material can; NaN: no section (its end is not above its beginning).
    """

    low_m: FloatArray
    high_m: FloatArray
    alone_m2_per_N: FloatArray  # without an elongation
    elongated_m2_per_N: FloatArray
    direction: Direction

    @property
    def ratio(self) -> FloatArray:
        """Area with an elongation over that without: below 1 it pays, 0: only with one."""
        with np.errstate(invalid="ignore"):
            ratio: FloatArray = self.elongated_m2_per_N / self.alone_m2_per_N
        return ratio


def elongation_map(
    model: SheetModel,
    configuration: str,
    low_m: npt.ArrayLike,
    high_m: npt.ArrayLike,
    direction: Direction = "both",
) -> ElongationMap:
    """Compare the least areas for all sections between beginnings and ends.

    Each length is solved once, at all positions; a section asks for the weakest place in it. The
    material keeps its properties along the sheet from the clamp on. Raises ModelError.
    """
    low, high = (np.atleast_1d(np.asarray(values, float)) for values in (low_m, high_m))
    if not (np.isfinite(low).all() and np.isfinite(high).all() and low.min() < high.max()):
        raise ModelError("a map needs finite positions, and an end above a beginning")
    R = model.sheet(configuration).sheet.arc_radius_m
    positions = _positions(low, high)
    asked = (positions, low, high, direction)
    alone = _least_alone(model, configuration, asked)
    lengths = elongated_lengths_m(model, configuration, LENGTHS)
    elongated = _least(
        model, configuration, lengths, ELONGATION_R * R, asked, np.zeros(len(positions))
    )
    return ElongationMap(
        low_m=low, high_m=high, alone_m2_per_N=alone, elongated_m2_per_N=elongated,
        direction=direction,
    )  # fmt: skip


def _positions(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return positions that hold every end, and lie 1 mm apart or less."""
    first, last = float(low.min()), float(high.max())
    even = np.linspace(first, last, max(2, int(np.ceil((last - first) / 1e-3)) + 1))
    return np.unique(np.concatenate([even, low, high]))


_Sections = tuple[FloatArray, FloatArray, FloatArray, Direction]


def _least_alone(model: SheetModel, configuration: str, asked: _Sections) -> FloatArray:
    """Return the same without an elongation, where some length reaches."""
    needed_m = shortest_alone_m(model, configuration, asked[0])
    reaching = needed_m[np.isfinite(needed_m)]
    lengths = np.empty(0)
    if len(reaching):
        grid = lengths_alone_m(model, configuration, float(reaching.min()), LENGTHS)
        lengths = np.union1d(grid, reaching)  # mostly the shortest of a section is the best
    return _least(model, configuration, lengths, 0.0, asked, needed_m)


def _least(
    model: SheetModel,
    configuration: str,
    lengths: FloatArray,
    extra_m: float,
    asked: _Sections,
    needed_m: FloatArray,
) -> FloatArray:
    """Return the least area over force of each section.

    needed_m: the shortest length that is taken for each position.
    """
    positions, low, high, direction = asked
    area = np.full((len(low), len(high)), np.inf)
    for length in lengths:
        possible = strength(model, configuration, float(length), extra_m, positions, direction)
        possible[length < needed_m] = 0.0
        for i, j in np.ndindex(area.shape):
            if low[i] >= high[j]:
                area[i, j] = np.nan
                continue
            inside = (positions >= low[i]) & (positions <= high[j])
            weakest = float(np.min(possible[inside]))
            if weakest > 0.0 and length / weakest < area[i, j]:
                area[i, j] = length / weakest
    return area
