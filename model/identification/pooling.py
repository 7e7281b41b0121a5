"""Puts the predictions of all configurations together, run by run, for the noise model."""

from __future__ import annotations

import numpy as np

from model.identification.likelihood.mixed_model import Data
from model.identification.residual_vector import Predicted, Shift, System
from model.measurements import FloatArray

# What differs from one set-up to the next, with a guess of its size: the prior's centre.
SCATTER = {
    "stiffness": 0.02,  # relative
    "eibm": 0.02,  # relative
    "eibm_condition": 0.003,  # relative, of one condition within a run
    "position": 1e-4,  # m
    "clamp_tilt": 1e-3,  # rad
    "registration": 1e-5,  # m, of the camera
    "force_zero": 2e-5,  # N, of the load cell
}
LEAST_MODE_M = 2e-7  # floor of a shape mode's noise
FORCE_GUESS_N = 2e-5


class Pool:
    """All data of a fit."""

    def __init__(self, systems: list[System]) -> None:
        self.systems = systems
        sizes = [s.layout.size for s in systems]
        self.offsets = np.concatenate([[0], np.cumsum(sizes)])
        self.runs: dict[tuple[str, float, int, int], list[tuple[int, int]]] = {}
        for n, system in enumerate(systems):
            for i, o in enumerate(system.observed.observations):
                self.runs.setdefault(o.run, []).append((n, i))
        self.modes = max(s.modes for s in systems)
        self.names = [*SCATTER]
        self.mask_names: list[str] = []
        for system in systems:
            name = system.observed.sheet.configuration
            self.mask_names += [f"{name} force", *(f"{name} mode {m}" for m in range(system.modes))]
        self.within = np.array([pooled_variance(s) for s in systems])

    def part(self, theta: FloatArray, n: int) -> FloatArray:
        """The parameters of one configuration."""
        return theta[self.offsets[n] : self.offsets[n + 1]]

    def data(
        self,
        predictions: list[Predicted],
        precision: FloatArray,
        away: FloatArray,
        added: list[FloatArray] | None = None,
    ) -> Data:
        """Residuals and derivatives of all runs; rows: force, modes of each condition in turn.

        `added` is what the set-ups added in the predictions; it is given back to the residuals, so
        that these are about nominal set-ups, linearised where the set-ups really are.
        """
        width = 1 + self.modes
        R, longest = len(self.runs), max(len(c) for c in self.runs.values())
        n, p = longest * width, int(self.offsets[-1])
        y, X, fixed = np.zeros((R, n)), np.zeros((R, n, p)), np.ones((R, n))
        masks = [np.zeros((R, n)) for _ in self.mask_names]
        groups = {name: np.zeros((R, n, 1)) for name in SCATTER}
        groups["eibm_condition"] = np.zeros((R, n, longest))
        groups["registration"] = np.zeros((R, n, 2))
        first = np.concatenate([[0], np.cumsum([1 + s.modes for s in self.systems])])
        for r, conditions in enumerate(self.runs.values()):
            for c, (system, i) in enumerate(conditions):
                found, observation = (
                    predictions[system],
                    self.systems[system].observed.observations[i],
                )
                row, own = c * width, slice(self.offsets[system], self.offsets[system + 1])
                if np.isfinite(found.force_N[i]) and np.isfinite(observation.force_N):
                    y[r, row] = observation.force_N - found.force_N[i]
                    X[r, row, own] = found.force_by[i]
                    fixed[r, row] = self.within[system] / observation.readings
                    masks[first[system]][r, row] = 1.0
                    self._force_rows(groups, r, row, c, found, i)
                if np.all(np.isfinite(found.modes_m[i])):
                    rows = slice(row + 1, row + 1 + self.systems[system].modes)
                    y[r, rows], X[r, rows, own] = found.modes_m[i], found.modes_by[i]
                    fixed[r, rows] = LEAST_MODE_M**2
                    for m in range(self.systems[system].modes):
                        masks[first[system] + 1 + m][r, row + 1 + m] = 1.0
                    self._mode_rows(groups, r, rows, c, found, i)
        columns = [groups[name] for name in SCATTER]
        for Z, u in zip(columns, added or [], strict=False):
            y += np.einsum("rnq,rq->rn", Z, u)
        return Data(y, X, columns, masks, fixed, precision, away)

    @staticmethod
    def _force_rows(
        groups: dict[str, FloatArray], r: int, row: int, c: int, found: Predicted, i: int
    ) -> None:
        names = ("stiffness", "eibm", "position", "clamp_tilt", "force_zero")
        for name, value in zip(names, found.force_at[i], strict=True):
            groups[name][r, row, 0] = value
        groups["eibm_condition"][r, row, c] = found.force_at[i][1]

    @staticmethod
    def _mode_rows(
        groups: dict[str, FloatArray], r: int, rows: slice, c: int, found: Predicted, i: int
    ) -> None:
        by = found.modes_at[i]
        for k, name in enumerate(("stiffness", "eibm", "position", "clamp_tilt")):
            groups[name][r, rows, 0] = by[:, k]
        groups["eibm_condition"][r, rows, c] = by[:, 1]
        groups["registration"][r, rows] = by[:, 4:6]

    def shifts(self, found: list[FloatArray]) -> list[Shift]:
        """What set-ups most likely added, as `noise.effects` has it, for each configuration."""
        u = dict(zip(SCATTER, found, strict=True))
        result = [Shift.none(len(s.observed.observations)) for s in self.systems]
        for r, conditions in enumerate(self.runs.values()):
            for c, (system, i) in enumerate(conditions):
                one = result[system]
                one.stiffness[i] = u["stiffness"][r, 0]
                one.eibm[i] = u["eibm"][r, 0] + u["eibm_condition"][r, c]
                one.position_m[i] = u["position"][r, 0]
                one.tilt_rad[i] = u["clamp_tilt"][r, 0]
                one.x_m[i], one.y_m[i] = u["registration"][r]
                one.force_N[i] = u["force_zero"][r, 0]
        return result

    def guess(self, predictions: list[Predicted]) -> FloatArray:
        """Ln of the scatter's prior centres; shape noise is guessed from the misfit."""
        values = list(SCATTER.values())
        for found in predictions:
            values.append(FORCE_GUESS_N)
            for m in range(found.modes_m.shape[1]):
                column = found.modes_m[:, m]
                column = column[np.isfinite(column)]
                size = 1.5 * np.median(np.abs(column)) if len(column) else 1e-5
                values.append(float(np.clip(size, 2e-6, 1e-3)))
        return np.log(np.array(values, dtype=np.float64))


def pooled_variance(system: System) -> float:
    """Variance of one force reading about its condition's mean, from all conditions together."""
    total, degrees = 0.0, 0
    for o in system.observed.observations:
        if np.isfinite(o.force_variance_N2):
            total += (o.readings - 1) * o.force_variance_N2
            degrees += o.readings - 1
    return total / degrees if degrees else 0.0
