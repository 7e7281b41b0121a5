"""Whitened differences between recordings and model, and how these change with each parameter."""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.noise import RecordingNoise, Whitening
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.runs import RecordedRun, RunPlan
from model.dynamics.line import LineModes
from model.dynamics.motion import SAME_TIME, Resolution, SheetMotion, Simulation
from model.measurements import FloatArray, ModelError

DIFFERENCE = 1e-3  # of a logarithm
# a step of 1 ms is off by as much as 25 frames of a release say
FINE = Resolution(step_s=5e-4, after_edges=1)
COARSE_STEP_S, COARSE_DEGREES = 2e-3, (6, 2)


def coarser(fine: Resolution) -> Resolution:
    """Return a resolution good enough for derivatives, and to come near."""
    return replace(
        fine, step_s=max(fine.step_s, COARSE_STEP_S), after_edges=1,
        degrees=tuple(min(pair) for pair in zip(fine.degrees, COARSE_DEGREES, strict=False)),
        free_degrees=min(fine.free_degrees, COARSE_DEGREES[0]),
    )  # fmt: skip


def in_milliseconds(fine: Resolution) -> Resolution:
    """Return a resolution that is right about what is lost in milliseconds, for half the time."""
    return replace(fine, step_s=max(fine.step_s, 1e-3), after_edges=1)


@dataclass(frozen=True, kw_only=True)
class PredictedRun:
    """What the model says of a run, as `RecordedRun` holds it."""

    force_N: FloatArray  # (n,)
    current_A: FloatArray
    x_m: FloatArray  # (m, p)
    y_m: FloatArray
    phi_rad: FloatArray
    break_m: float | None = None  # between the panels of the sheet; None: there is but one


def predict(beam: DynamicBeam, run: RunPlan, resolution: Resolution) -> PredictedRun:
    """Return the model's run. Raises ModelError, also where the sheet slips out of the rolls."""
    if not run.force and not len(run.frame_s):
        return _current_alone(beam, run, resolution)
    times = np.unique(np.concatenate([run.time_s, run.frame_s]))
    times = times[np.diff(times, prepend=-1.0) > SAME_TIME]
    points = run.points_m if len(run.points_m) else np.zeros(1)
    simulation = Simulation(beam, run.setup, run.drive, resolution=resolution)
    motion: SheetMotion = simulation.advance(run.drive, times, points)
    if motion.slipped_s is not None:
        raise ModelError(f"{run.name}: the sheet slips out of the rolls at {motion.slipped_s:g} s")
    samples = np.searchsorted(times, run.time_s - SAME_TIME)
    frames = np.searchsorted(times, run.frame_s - SAME_TIME)
    return PredictedRun(
        force_N=motion.reading_N[samples], current_A=motion.current_A[samples],
        x_m=motion.x_m[frames], y_m=motion.y_m[frames], phi_rad=motion.phi_rad[frames],
        break_m=simulation.break_m,
    )  # fmt: skip


def _current_alone(beam: DynamicBeam, run: RunPlan, resolution: Resolution) -> PredictedRun:
    """Return the current, for which the sheet need not move."""
    if beam.electrodes is None:
        raise ModelError("to predict a current the sheet's electrodes must be described")
    line = LineModes(beam.electrodes, beam.length_m, resolution.line_terms)
    inside = run.drive.time_s[(run.drive.time_s > 0.0) & (run.drive.time_s < run.time_s[-1])]
    knots = np.unique(np.concatenate([np.zeros(1), run.time_s, inside]))
    held = run.drive.at(0.5 * (knots[1:] + knots[:-1]))
    begun = line.charged(run.drive.time_s, run.drive.voltage_V)
    modes = line.respond(begun, np.diff(knots), held)
    current = line.current_A(modes, np.concatenate([held[:1], held]))
    none = np.zeros((0, 1))
    samples = np.searchsorted(knots, run.time_s)
    return PredictedRun(
        force_N=np.zeros(len(samples)), current_A=current[samples], x_m=none, y_m=none, phi_rad=none
    )


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
        self._away = away_from_edges(run, noise)
        if run.current and not self._away.any():
            raise ModelError(f"{run.name}: no sample of the current is away from the voltage edges")
        self._force = Whitening(noise.force, run.time_s, noise.mains_hz) if run.force else None
        self._current = (
            Whitening(noise.current, run.time_s[self._away], noise.mains_hz)
            if run.current else None
        )  # fmt: skip

    def with_resolution(self, resolution: Resolution) -> RunResiduals:
        """Return the same with other steps; the whitening, dear to prepare, is shared."""
        other = copy(self)
        other._resolution, other._break_m = resolution, None
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
        said = predict(beam, self.run, replace(self._resolution, break_m=self._break_m))
        self._break_m = said.break_m
        return said

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
        """Return d prediction/d theta, whitened, (N, p), by forward or central differences.

        One-sided ones are off by half a step's curvature, which tells apart what no data do: a
        free sheet of twice the stiffness, mass and moment moves as before.
        """
        at = self.predict(parameters.beam(theta))
        columns: list[tuple[PredictedRun, PredictedRun | RecordedRun]] = []
        for moved in DIFFERENCE * np.eye(len(theta)):
            after = self.predict(parameters.beam(theta + moved))
            before = self.predict(parameters.beam(theta - moved)) if symmetric else at
            columns.append((replace(before, phi_rad=at.phi_rad), after))
        return self.whitened(columns) / (DIFFERENCE * (2.0 if symmetric else 1.0))


def _difference(
    columns: list[tuple[PredictedRun, PredictedRun | RecordedRun]], name: str
) -> FloatArray:
    return np.stack([getattr(b, name) - getattr(a, name) for a, b in columns], axis=1)
