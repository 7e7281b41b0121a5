"""The bending stiffness that forces and curves ask for, whatever the EIBM along the sheet is.

It is (2) integrated up to the contact: the turn of each curve is linear in 1/B and Me/B. No
equilibrium is solved, so it has a value also where the base model with constant EIBM does not fit.
"""

from __future__ import annotations

from contextlib import suppress
from dataclasses import dataclass

import numpy as np

from model.identification.observations import Observed, observe
from model.identification.paper import Sample, loaded
from model.identification.starting_values import rest_field
from model.measurements import Measurements, ModelError

MEGA = 1e6  # 1/B is found in 1e6 per N m^2, so that it is of order one
FEWEST_SPARE = 2  # conditions more than unknowns, for a standard error that means something


@dataclass(frozen=True)
class ShapeCompliance:
    """1/B of one configuration by its curves under known forces, and its standard error."""

    value_per_Nm2: float
    sigma_per_Nm2: float

    @property
    def sigmas(self) -> float:
        """1/B in its standard errors."""
        return self.value_per_Nm2 / max(self.sigma_per_Nm2, 1e-300)


def shape_compliance(measurements: Measurements, configuration: str) -> ShapeCompliance | None:
    """Return 1/B by the curves of one configuration; None where they do not determine it."""
    try:
        return _regressed(*_samples(observe(measurements, configuration)))
    except (ModelError, np.linalg.LinAlgError):
        return None  # the fit says what is missing


def _samples(observed: Observed) -> tuple[list[Sample], bool]:
    """Return what each condition says by itself, and whether the initial curvature is stated."""
    rest, stated = rest_field(observed.sheet, observed)
    found = []
    for one in observed.touching():
        if one.curve is not None and np.isfinite(one.force_N):
            with suppress(ModelError):  # a curve that does not reach the arc
                found.append(loaded(observed, one, rest, 1.0))
    return found, stated


def _regressed(samples: list[Sample], stated: bool) -> ShapeCompliance | None:
    voltages = sorted({s.observation.voltage_V for s in samples} - {0.0})
    columns = [np.array([s.mean_moment_Nm * MEGA for s in samples])]
    columns += [
        np.array([float(s.observation.voltage_V == volts) for s in samples]) for volts in voltages
    ]
    if not stated:
        columns.append(np.ones(len(samples)))
    X = np.column_stack(columns)
    turns = np.array([s.turn_rad / s.l_hat_m for s in samples])
    spare = len(samples) - X.shape[1]
    if spare < FEWEST_SPARE or not (np.isfinite(X).all() and np.isfinite(turns).all()):
        return None
    scale = np.linalg.norm(X, axis=0)
    if not scale.all() or np.linalg.matrix_rank(X / scale) < X.shape[1]:
        return None
    X = X / scale
    found = np.linalg.lstsq(X, turns, rcond=None)[0]
    variance = float(np.sum((turns - X @ found) ** 2)) / spare
    sigma = float(np.sqrt(variance * np.linalg.inv(X.T @ X)[0, 0]))
    return ShapeCompliance(found[0] * MEGA / scale[0], sigma * MEGA / scale[0])
