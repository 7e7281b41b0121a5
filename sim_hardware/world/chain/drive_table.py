"""Force and shape of one set-up as a smooth function of the drive: solved once, then interpolated.

The drive's range is cut into panels, each with Chebyshev nodes; a panel is made when the drive
first gets there, by following the chain from the panel beside it. Where the chain slips out, the
table ends.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from sim_hardware.world.chain.chain import Equilibrium
from sim_hardware.world.chain.contact import ContactState

FloatArray = npt.NDArray[np.float64]

PANEL = 0.5  # width in units of the drive
NODES = 14
# What a row of a panel's coefficients holds, before the link angles.
ALONG, OUTWARD, NORMAL, S, ANGLE = range(5)
_SCALARS = 5

# cos((2 k + 1) pi / 2 n) from -1 to 1, and the matrix from node values to coefficients
_NODES = -np.cos((2 * np.arange(NODES) + 1) * np.pi / (2 * NODES))
_TO_COEFFICIENTS = np.linalg.inv(np.polynomial.chebyshev.chebvander(_NODES, NODES - 1))


class DriveTable:
    """Equilibria of a held (or, with `angle_rad` None, of a free) chain over its drive."""

    def __init__(self, contact: ContactState, angle_rad: float | None) -> None:
        from sim_hardware.world.signals import kernels

        self._chebyshev = kernels.chebyshev
        self._contact = contact
        self._angle_rad = angle_rad
        self._panels: dict[int, FloatArray] = {}
        self._edges: dict[int, Equilibrium] = {}  # at drive = key * PANEL
        # Drives between these two are held; the chain slips out at the first and beyond.
        self.lowest, self.highest = -math.inf, math.inf
        if angle_rad is not None:
            start = contact.place(0.0, angle_rad)
            if start is None:
                self.lowest = self.highest = 0.0
            else:
                self._edges[0] = start

    @property
    def reachable(self) -> bool:
        """Whether the sheet could be put there at all."""
        return self.lowest < self.highest

    def slipped(self, drive: FloatArray) -> npt.NDArray[np.bool_]:
        """Return where the chain cannot be held."""
        self._cover(drive)
        return (drive <= self.lowest) | (drive >= self.highest)

    def forces_per_m2(self, drive: FloatArray) -> FloatArray:
        """Return the held object's forces over B (2, n): along the arc and outward."""
        return self._values(drive, slice(0, 2))

    def contact(self, drive: FloatArray) -> FloatArray:
        """Return the normal force over B and the place along the held sheet (2, n)."""
        return self._values(drive, slice(NORMAL, S + 1))

    def state(self, drive: float) -> Equilibrium:
        """Return the whole equilibrium at a drive that is held."""
        row = self._values(np.array([drive]), slice(None))[:, 0]
        s, angle = (float(row[S]), float(row[ANGLE])) if self._angle_rad is not None else _NOWHERE
        return Equilibrium(
            drive=drive,
            phi_rad=row[_SCALARS:],
            s_m=s,
            angle_rad=angle,
            normal_per_m2=float(row[NORMAL]),
            along_per_m2=float(row[ALONG]),
            outward_per_m2=float(row[OUTWARD]),
        )

    def _values(self, drive: FloatArray, rows: slice) -> FloatArray:
        if drive.size == 0:
            return np.empty((2, 0))
        first, last = self._cover(drive)
        result = np.empty((self._panels[first][rows].shape[0], drive.size))
        for k in range(first, last + 1):
            low, high = self._span(k)
            # An edge that two panels share has the same value in both.
            mine = np.flatnonzero((drive >= low) & (drive <= high))
            x = (2 * drive[mine] - low - high) / (high - low)
            self._chebyshev(self._panels[k][rows], x, result, mine)
        return result

    def _span(self, k: int) -> tuple[float, float]:
        return max(k * PANEL, self.lowest), min((k + 1) * PANEL, self.highest)

    def _cover(self, drive: FloatArray) -> tuple[int, int]:
        """Make the panels that these drives need, from 0 outward; the first and the last needed."""
        if drive.size == 0 or not self.reachable:
            return 0, 0
        first, last = (math.floor(float(d) / PANEL) for d in (drive.min(), drive.max()))
        if first in self._panels and last in self._panels:
            return first, last
        for k in range(max(last, 0) + 1):
            if k * PANEL < self.highest:
                self._make(k, upward=True)
        for k in range(-1, first - 1, -1):
            if (k + 1) * PANEL > self.lowest:
                self._make(k, upward=False)
        return first, last

    def _make(self, k: int, *, upward: bool) -> None:
        if k in self._panels:
            return
        if self._angle_rad is None:
            self._panels[k] = self._through([self._free(d) for d in self._nodes_of(k)])
            return
        near, far = (k, k + 1) if upward else (k + 1, k)
        end, whole = self._contact.drive_to(self._edges[near], far * PANEL, self._angle_rad)
        if whole:
            self._edges[far] = end
        elif upward:
            self.highest = max(end.drive, near * PANEL + 1e-9)
        else:
            self.lowest = min(end.drive, near * PANEL - 1e-9)
        nodes = self._nodes_of(k)
        states, state = [], self._edges[near]
        for drive in nodes if upward else nodes[::-1]:
            state, _ = self._contact.drive_to(state, float(drive), self._angle_rad)
            states.append(self._contact.yielded(state, self._angle_rad))
        self._panels[k] = self._through(states if upward else states[::-1])

    def _nodes_of(self, k: int) -> FloatArray:
        low, high = self._span(k)
        return (low + high) / 2 + (high - low) / 2 * _NODES

    def _free(self, drive: float) -> Equilibrium:
        return self._contact.chain.free(float(drive))

    def _through(self, states: list[Equilibrium]) -> FloatArray:
        """Coefficients (quantities, NODES) of the polynomials through states at the nodes."""
        rows = [
            np.concatenate(
                (
                    [e.along_per_m2, e.outward_per_m2, e.normal_per_m2],
                    [e.s_m, e.angle_rad] if e.touched else [0.0, 0.0],
                    e.phi_rad,
                )
            )
            for e in states
        ]
        return np.asarray(np.column_stack(rows) @ _TO_COEFFICIENTS.T)


_NOWHERE = (math.nan, math.nan)
