"""When a rigid elongation pays: least area with and without one, over working sections."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.design.force_map import force_map, known_voltages, resized
from model.design.sizing import Direction
from model.measurements import FloatArray, ModelError
from model.sheet.sheet_model import SheetModel

LENGTHS = 40  # that are tried, with and without an elongation
LONGEST_R = 1.8  # of a sheet without one, in radii of the arc
SHORTEST_R = 0.05  # of a sheet with one
_ELONGATION_R = 1.5  # reaches the object everywhere


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
    length_alone_m: FloatArray  # free length of those sheets; NaN where there is none
    length_elongated_m: FloatArray
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
    alone = _least(
        model, configuration, np.linspace(0.5 * R, LONGEST_R * R, LENGTHS), 0.0,
        (positions, low, high, direction),
    )  # fmt: skip
    elongated = _least(
        model, configuration, np.linspace(SHORTEST_R * R, R, LENGTHS), _ELONGATION_R * R,
        (positions, low, high, direction),
    )  # fmt: skip
    return ElongationMap(
        low_m=low, high_m=high, alone_m2_per_N=alone[0], elongated_m2_per_N=elongated[0],
        length_alone_m=alone[1], length_elongated_m=elongated[1], direction=direction,
    )  # fmt: skip


def _positions(low: FloatArray, high: FloatArray) -> FloatArray:
    """Return positions that hold every end, and lie 1 mm apart or less."""
    first, last = float(low.min()), float(high.max())
    even = np.linspace(first, last, max(2, int(np.ceil((last - first) / 1e-3)) + 1))
    return np.unique(np.concatenate([even, low, high]))


_Sections = tuple[FloatArray, FloatArray, FloatArray, Direction]


def _least(
    model: SheetModel, configuration: str, lengths: FloatArray, extra_m: float, asked: _Sections
) -> tuple[FloatArray, FloatArray]:
    """Return the least area over force, and its length, of each section."""
    positions, low, high, direction = asked
    area = np.full((len(low), len(high)), np.inf)
    best = np.full(area.shape, np.nan)
    for length in lengths:
        strength = _strength(model, configuration, float(length), extra_m, positions, direction)
        for i, j in np.ndindex(area.shape):
            if low[i] >= high[j]:
                area[i, j] = np.nan
                continue
            inside = (positions >= low[i]) & (positions <= high[j])
            weakest = float(np.min(strength[inside]))
            if weakest > 0.0 and length / weakest < area[i, j]:
                area[i, j], best[i, j] = length / weakest, length
    return area, best


def _strength(
    model: SheetModel,
    configuration: str,
    length_m: float,
    extra_m: float,
    positions: FloatArray,
    direction: Direction,
) -> FloatArray:
    """Return the force over width that is possible at each position, N/m; 0: not reachable."""
    changed = resized(model, configuration, length_m, extra_m)
    found = force_map(changed, configuration, positions, known_voltages(model, configuration))
    up, down = found.tangential_N.max(axis=1), -found.tangential_N.min(axis=1)
    choice = {"both": np.minimum(up, down), "positive": up, "negative": down}
    per_width = choice[direction] / model.sheet(configuration).sheet.width_m
    return np.where(found.reachable.all(axis=1), per_width, 0.0)
