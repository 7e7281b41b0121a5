"""Creep: what the sheet becomes when a part of its strain has stayed for ever.

Each hinge is a spring beside one that a dashpot lets go: its moment is B times the strain, less a
share of the strain as it was some time ago. That lag is the same as a change of the rest curvature.
The strain of a held sheet is a function of the drive d, well described by three parts that go with
1, d and d^2; each part lags behind on its own, and the sheet is solved once for each, fully lagged.
In between, what creep changes is taken to go with the parts: creep is a small effect.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Chain, ChainSheet
from sim_hardware.world.chain.drive_table import DriveTable

FloatArray = npt.NDArray[np.float64]

PARTS = 3
_DRIVE = 0.7  # at which the parts are separated


def parts_of(drive: FloatArray) -> FloatArray:
    """Return the factors of the three parts of the strain (n, PARTS)."""
    return np.column_stack((np.ones_like(drive), drive, drive**2))


def crept_sheets(chain: Chain, table: DriveTable, share: float) -> list[ChainSheet]:
    """Return sheets whose rest curvature is moved by each part of the strain, times `share`."""
    s_m = chain.hinge_m[1:]
    low, middle, high = (_curvature(chain, table, d) for d in (-_DRIVE, 0.0, _DRIVE))
    rest = np.asarray(chain.sheet.rest_curvature_per_m(s_m))
    odd, even = (high - low) / (2 * _DRIVE), (high + low - 2 * middle) / (2 * _DRIVE**2)
    return [_moved(chain.sheet, s_m, share * part) for part in (middle - rest, odd, even)]


def _curvature(chain: Chain, table: DriveTable, drive: float) -> FloatArray:
    if table.slipped(np.array([drive]))[0]:
        return _curvature(chain, table, drive / 2)
    return np.diff(table.state(drive).phi_rad) / chain.h_m


def _moved(sheet: ChainSheet, s_m: FloatArray, change_per_m: FloatArray) -> ChainSheet:
    rest = sheet.rest_curvature_per_m
    return replace(
        sheet, rest_curvature_per_m=lambda s: np.asarray(rest(s)) + np.interp(s, s_m, change_per_m)
    )
