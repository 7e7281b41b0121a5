"""Whitened differences between recordings and model, and how these change with each parameter."""

from __future__ import annotations

from copy import copy
from dataclasses import replace

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.noise import RecordingNoise, Whitening
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.predicted_run import PredictedRun, predict, predicted_current
from model.dynamics.identification.runs import RecordedRun, RunPlan
from model.dynamics.line import ElectrodeLine
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError

# Of a logarithm. One-sided differences are off by half a step's curvature, which tells apart what
# no data do: a free sheet of twice the stiffness, mass and moment moves as before. Of so short a
# step that is less than the weakest prior says; where it is still too much, take central ones.
DIFFERENCE, ONE_SIDED = 1e-3, 3e-5


def away_from_edges(
    run: RunPlan, noise: RecordingNoise
) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
    """Return which samples (n,) of the current count: at a voltage edge it jumps."""
    edges = run.drive.time_s
    near = np.zeros(len(run.time_s), dtype=bool)
    place = np.searchsorted(edges, run.time_s)
    for side in (place - 1, place):
        edge = edges[np.clip(side, 0, len(edges) - 1)]
        near |= np.abs(run.time_s - edge) <= noise.edge_s
    return ~near


class RunResiduals:
    """The residuals of one run."""

    def __init__(self, run: RunPlan, noise: RecordingNoise, resolution: Resolution) -> None:
        """Prepare the whitening."""
        self.run, self._resolution, self._curve_m = run, resolution, noise.curve_m
        self._break_m: float | None = None
        self._every = 1  # of how many samples one is computed
        self._known: tuple[ElectrodeLine, float, FloatArray] | None = None
        self._away = away_from_edges(run, noise)
        if run.current and not self._away.any():
            raise ModelError(f"{run.name}: no sample of the current is away from the voltage edges")
        self._force = Whitening(noise.force, run.time_s, noise.mains_hz) if run.force else None
        self._current = (
            Whitening(noise.current, run.time_s[self._away], noise.mains_hz)
            if run.current else None
        )  # fmt: skip

    def with_resolution(self, resolution: Resolution) -> RunResiduals:
        """Return the same with other steps; the whitening, dear to prepare, is shared.

        Steps longer than the samples are apart are taken as they are: most samples lie in between.
        """
        other = copy(self)
        other._resolution, other._break_m, other._known = resolution, None, None
        if len(self.run.time_s) > 1:
            apart_s = float(np.median(np.diff(self.run.time_s)))
            other._every = max(1, int(resolution.step_s / apart_s + 1e-6))
        return other

    def count(self, data: RecordedRun) -> int:
        """Return the number of values that are compared."""
        both = () if data.x_m is None or data.y_m is None else data.x_m + data.y_m
        seen = np.isfinite(np.asarray(both, dtype=float)).sum()
        return int(
            len(self.run.time_s) * self.run.force + self._away.sum() * self.run.current + seen
        )

    def predict(self, beam: DynamicBeam) -> PredictedRun:
        """Return what the model says of this run.

        The panels part where the first sheet asked about touches, so that all share their matrices.
        """
        by = replace(self._resolution, break_m=self._break_m)
        said = predict(beam, self.run, by, every=self._every, current_A=self._through(beam, by))
        self._break_m = said.break_m
        return said

    def _through(self, beam: DynamicBeam, by: Resolution) -> FloatArray:
        """Return the current; most parameters leave it as it was."""
        line, known = beam.electrodes, self._known
        if line is not None and known is not None and known[:2] == (line, beam.length_m):
            return known[2]
        found = predicted_current(beam, self.run, by)
        if line is not None:
            self._known = line, beam.length_m, found
        return found

    def whitened(
        self, columns: list[tuple[PredictedRun, PredictedRun | RecordedRun]]
    ) -> FloatArray:
        """Return whitened differences, second less first, (N, m) of m pairs.

        Curves differ across the sheet of the first: along it nothing can be told from a frame.
        """
        parts = []
        if self._force is not None:
            parts.append(self._force(_difference(columns, "force_N")))
        if self._current is not None:
            parts.append(self._current(_difference(columns, "current_A")[self._away]))
        if len(self.run.frame_s):
            across = [
                np.cos(a.phi_rad) * (b.y_m - a.y_m) - np.sin(a.phi_rad) * (b.x_m - a.x_m)
                for a, b in columns
                if b.x_m is not None and b.y_m is not None
            ]
            flat = np.stack([part.ravel() for part in across], axis=1)
            parts.append(np.where(np.isfinite(flat), flat, 0.0) / self._curve_m)
        return np.concatenate(parts)

    def sensitivity(
        self, parameters: LogParameters, theta: FloatArray, *, symmetric: bool
    ) -> FloatArray:
        """Return d prediction/d theta, whitened, (N, p), by one-sided or central differences."""
        at = self.predict(parameters.beam(theta))
        step = DIFFERENCE if symmetric else ONE_SIDED
        columns: list[tuple[PredictedRun, PredictedRun | RecordedRun]] = []
        told = np.ones(len(theta), dtype=bool)
        if not (self.run.force or len(self.run.frame_s)):  # the current, of the electrodes alone
            told = parameters.length_of_line != 0.0
        for moved in step * parameters.directions[told]:
            after = self.predict(parameters.beam(theta + moved))
            before = self.predict(parameters.beam(theta - moved)) if symmetric else at
            columns.append((replace(before, phi_rad=at.phi_rad), after))
        some = self.whitened(columns) / (2.0 * step if symmetric else step)
        changed = np.zeros((len(some), len(theta)))
        changed[:, told] = some
        return np.asarray(np.linalg.solve(parameters.directions, changed.T).T)


def _difference(
    columns: list[tuple[PredictedRun, PredictedRun | RecordedRun]], name: str
) -> FloatArray:
    return np.stack([getattr(b, name) - getattr(a, name) for a, b in columns], axis=1)
