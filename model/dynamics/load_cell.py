"""The load cell's own resonance: F_read'' + 2 zeta w F_read' + w^2 F_read = w^2 F.

The contact is 1e-4 as stiff as the cell, so the cell does not act back on the sheet.
"""

from __future__ import annotations

from itertools import pairwise
from typing import Any

import numpy as np

from model.dynamics.beam import ContactSetup
from model.measurements import FloatArray

ComplexArray = np.ndarray[Any, np.dtype[np.complex128]]
SAME_STEP = 1e-9  # relative: steps nearer than this are equal
FEW = 50  # steps for which a loop is quicker than scipy's filter


class LoadCellFilter:
    """Follows a force; exact where the force is a straight line in each step."""

    def __init__(self, setup: ContactSetup) -> None:
        """Begin at rest under the first force it is shown."""
        self.slow = bool(np.isfinite(setup.resonance_hz))
        self._state: ComplexArray | None = None
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
        start = np.full(2, force_N[0], complex) if self._state is None else self._state
        out = np.empty((len(force_N), 2), complex)
        out[0] = start
        x = -step_s[:, None] * self._poles
        gone = -np.expm1(-x)
        late = 1.0 - gone / x
        add: ComplexArray = np.asarray(
            (gone - late) * force_N[:-1, None] + late * force_N[1:, None], dtype=complex
        )
        # where steps are equal it is a linear recursion: z+ = keep z + add
        changes = (np.flatnonzero(np.abs(np.diff(step_s)) > SAME_STEP * step_s[1:]) + 1).tolist()
        for first, last in pairwise([0, *changes, len(step_s)]):
            if first == last:  # no step at all
                continue
            out[first + 1 : last + 1] = _recursion(1.0 - gone[first], add[first:last], out[first])
        self._state = out[-1]
        return np.asarray((out @ self._share).real)


def _recursion(keep: ComplexArray, add: ComplexArray, start: ComplexArray) -> ComplexArray:
    """Return z_n = keep z_n-1 + add_n from z_-1 = start, (n, 2)."""
    from scipy.signal import lfilter  # slow to import

    if len(add) < FEW:
        out, z = np.empty_like(add), start
        for n, more in enumerate(add):
            out[n] = z = keep * z + more
        return out
    columns = [
        lfilter([1.0], [1.0, -k], column, zi=[k * z])[0]
        for k, column, z in zip(keep, add.T, start, strict=True)
    ]
    return np.stack(columns, axis=1)
