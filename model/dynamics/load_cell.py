"""The load cell's own resonance: F_read'' + 2 zeta w F_read' + w^2 F_read = w^2 F.

The contact is 1e-4 as stiff as the cell, so the cell does not act back on the sheet.
"""

from __future__ import annotations

import numpy as np

from model.dynamics.beam import ContactSetup
from model.measurements import FloatArray


class LoadCellFilter:
    """Follows a force; exact where the force is a straight line in each step."""

    def __init__(self, setup: ContactSetup) -> None:
        """Begin at rest under the first force it is shown."""
        self.slow = bool(np.isfinite(setup.resonance_hz))
        self._state: np.ndarray[tuple[int], np.dtype[np.complex128]] | None = None
        if self.slow:
            w, zeta = 2.0 * np.pi * setup.resonance_hz, setup.damping
            zeta = zeta if abs(zeta - 1.0) > 1e-6 else 1.0 + 1e-6  # equal poles have no sum of two
            root = np.sqrt(complex(zeta * zeta - 1.0))
            self._poles = w * np.array([-zeta + root, -zeta - root])
            # w^2/((p - s1)(p - s2)) as a sum of two lags 1/(1 - p/s)
            self._share = w * w / (self._poles - self._poles[::-1]) * (-1.0 / self._poles)

    def follow(self, step_s: FloatArray, force_N: FloatArray) -> FloatArray:
        """Return what is read at the ends of n steps, for the force (n + 1,) there."""
        if not self.slow:
            return force_N
        z = np.full(2, force_N[0], complex) if self._state is None else self._state
        out = np.empty((len(force_N), 2), complex)
        out[0] = z
        x = -step_s[:, None] * self._poles
        gone = -np.expm1(-x)
        late = 1.0 - gone / x
        add = (gone - late) * force_N[:-1, None] + late * force_N[1:, None]
        for n, (keep, more) in enumerate(zip(1.0 - gone, add, strict=True)):
            z = keep * z + more
            out[n + 1] = z
        self._state = z
        return np.asarray((out @ self._share).real)
