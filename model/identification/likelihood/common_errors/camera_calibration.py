"""What is not known of the camera's calibration, common to all curves: columns of the base model.

A calibration states how well it knows scale, direction and origin. What is off by no more than that
is no effect.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState
from model.measurements import CameraUncertainty, FloatArray


@dataclass(frozen=True, kw_only=True)
class CalibrationErrors:
    """Errors of scale, direction and origin as base parameters, those that are stated."""

    first: int  # place
    stated: CameraUncertainty

    @property
    def sigma(self) -> list[float]:
        """Return their standard uncertainties: of the scale, direction (rad), origin (m, x, y)."""
        origin_m = self.stated.origin_m
        each = (self.stated.scale, self.stated.roll_rad, origin_m, origin_m)
        return [one for one in each if one > 0.0]

    @property
    def places(self) -> range:
        """Return their places among all base parameters."""
        return range(self.first, self.first + len(self.sigma))

    def rows(self, forward: ForwardModel, c: int, state: ModelState) -> FloatArray:
        """Return the rows of one configuration by each of them, (N, q)."""
        seen, solved = forward.points(c, state.beam, state.solved), state.solved
        x, y, nx, ny = seen.x_m, seen.y_m, solved.nx, solved.ny
        origin_m = self.stated.origin_m
        moved = (
            (self.stated.scale, x * nx + y * ny), (self.stated.roll_rad, x * ny - y * nx),
            (origin_m, nx), (origin_m, ny),
        )  # fmt: skip
        none = forward.no_step(c)
        steps = [replace(none, points_m=along_normal) for sigma, along_normal in moved if sigma > 0]
        return np.asarray(forward.rows_of_each(c, state, steps).T)
