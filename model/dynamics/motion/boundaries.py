"""What is prescribed of a motion: the direction of the clamp and the place of the rolls."""

from __future__ import annotations

from math import cos, sin

import numpy as np

from model.dynamics.beam import ClampTurn, ContactSetup
from model.measurements import FloatArray


class Boundaries:
    """Clamp and rolls at any time."""

    def __init__(self, setup: ContactSetup | None, clamp: ClampTurn | None) -> None:
        """Take them; None: there are no rolls, the clamp does not turn."""
        self._setup, self._turn = setup, clamp
        # the rolls' polar angle, where they do not move
        self._rests_rad = (
            float(setup.angles(np.zeros(1))[0])
            if setup is not None and not callable(setup.position_m)
            else None
        )

    def clamp(self, times: FloatArray) -> FloatArray:
        """Return psi and its two derivatives, (n, 3)."""
        out = np.zeros((len(times), 3))
        if self._turn is not None:
            out[:, 0] = self._turn.angle_rad(times)
            out[:, 1] = self._turn.rate_rad_per_s(times)
            out[:, 2] = self._turn.acceleration_rad_per_s2(times)
        return out

    def places(self, times: FloatArray) -> FloatArray:
        """Return p_hat, (n, 2)."""
        places = np.zeros((len(times), 2))
        if self._setup is None:
            return places
        R = self._setup.radius_m
        if self._rests_rad is not None:
            places[:] = (R * cos(self._rests_rad), R * sin(self._rests_rad))
        else:
            angles = self._setup.angles(times)
            places[:, 0], places[:, 1] = R * np.cos(angles), R * np.sin(angles)
        return places

    def polar(self, places: FloatArray) -> FloatArray | float:
        """Return the polar angles of the rolls; one where they rest."""
        if self._rests_rad is not None:
            return self._rests_rad
        return np.asarray(np.arctan2(places[:, 1], places[:, 0]))
