"""The electrodes as a ladder of resistors and double layers, compiled. Import where it is used.

Equations (D6): the voltage V between the electrodes falls along their resistance r, and charges
the double layers, at U, through the ionic resistance rho:

    V'' = r j,  j = (V - U)/rho + g V,  c U_t = (V - U)/rho;  V_s - V(0) = R_s i,  V'(end) = 0

The cells lie between (i - 1) h and i h; a step takes the means of V and U over it (trapezoidal).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit

Floats = npt.NDArray[np.float64]


class Ladder(NamedTuple):
    """The cells, each a rung, and what follows from them for a time step."""

    source_S: float  # from the source to the first cell
    side_S: float  # from cell to cell
    charge: float  # h/(rho (1 + y/2)): current that U at its start gives back
    y: float  # dt/(rho c)
    factor: Floats  # (n,) of the elimination
    pivot: Floats  # (n,)
    now_S: float  # current at once: now_S V_s - back_S . U ...
    back_S: Floats  # (n,)
    rise_S_per_s: float  # ... of which back_S . U rises with rise V_s - sink . U
    sink_S_per_s: Floats  # (n,)


def ladder(
    cells: int, length_m: float, dt: float, *, ohm_per_m: float, farad_per_m: float,
    bulk_ohm_m: float, leak_S_per_m: float, source_ohm: float,
) -> Ladder:  # fmt: skip
    """Lay a line out as so many cells, for steps of `dt`."""
    h = length_m / cells
    y = dt / (bulk_ohm_m * farad_per_m)
    source_S = 1 / (source_ohm + ohm_per_m * h / 2)
    side_S = 1 / (ohm_per_m * h)
    charge = h / (bulk_ohm_m * (1 + y / 2))
    factor, pivot = _eliminated(cells, source_S, side_S, h * leak_S_per_m + charge)
    rung_S = h * leak_S_per_m + h / bulk_ohm_m
    across = np.diag(np.full(cells, rung_S + 2 * side_S))
    across[0, 0] += source_S - side_S
    across[-1, -1] -= side_S
    across -= side_S * (np.eye(cells, k=1) + np.eye(cells, k=-1))
    inverse = np.linalg.inv(across)
    by_source, by_charge = source_S * inverse[:, 0], h / bulk_ohm_m * inverse
    back_S = source_S * by_charge[0]
    rate = 1 / (bulk_ohm_m * farad_per_m)
    return Ladder(
        source_S=source_S, side_S=side_S, charge=charge, y=y,
        factor=factor, pivot=pivot, now_S=source_S * (1 - by_source[0]), back_S=back_S,
        rise_S_per_s=rate * float(back_S @ by_source),
        sink_S_per_s=rate * (back_S - by_charge.T @ back_S),
    )  # fmt: skip


def _eliminated(cells: int, source_S: float, side_S: float, rung_S: float) -> tuple[Floats, Floats]:
    """Factors and pivots of the tridiagonal system of the cells' voltages."""
    factor, pivot = np.zeros(cells), np.empty(cells)
    for i in range(cells):
        sides = side_S * ((i > 0) + (i < cells - 1)) + source_S * (i == 0)
        pivot[i] = rung_S + sides
        if i > 0:
            factor[i] = side_S / pivot[i - 1]
            pivot[i] -= factor[i] * side_S
    return factor, pivot


@brief_jit
def charge(line: Ladder, source_V: float, U: Floats, work: Floats) -> float:
    """Move the double layers' voltages `U` (n,) on by a step; return its greatest change.

    `source_V`: the source's mean over the step. `work` (n,).
    """
    n = U.shape[0]
    for i in range(n):
        work[i] = line.charge * U[i]
        if i == 0:
            work[0] += line.source_S * source_V
        else:
            work[i] += line.factor[i] * work[i - 1]
    above = most = 0.0
    for i in range(n - 1, -1, -1):
        above = (work[i] + line.side_S * above) / line.pivot[i]
        new = ((1.0 - 0.5 * line.y) * U[i] + line.y * above) / (1.0 + 0.5 * line.y)
        most = max(most, abs(new - U[i]))
        U[i] = new
    return most
