"""What the model says of a run, in as few steps as it needs."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.runs import RunPlan
from model.dynamics.line import LineModes
from model.dynamics.motion import Resolution, Simulation
from model.measurements import FloatArray, ModelError

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

    force_N: FloatArray  # (n,) 0 where none is measured
    current_A: FloatArray
    x_m: FloatArray  # (m, p)
    y_m: FloatArray
    phi_rad: FloatArray
    break_m: float | None = None  # between the panels of the sheet; None: there is but one


def predict(
    beam: DynamicBeam, run: RunPlan, resolution: Resolution, *, every: int = 1,
    current_A: FloatArray | None = None,
) -> PredictedRun:  # fmt: skip
    """Return the model's run. Raises ModelError, also where the sheet slips out of the rolls.

    The sheet is moved only as far as force or frames are measured: the current does not depend on
    it. every: the force of one in so many samples is computed, a straight line in between.
    current_A: the current of these electrodes, where it is known.
    """
    current = predicted_current(beam, run, resolution) if current_A is None else current_A
    frames = len(run.frame_s)
    if not (run.force or frames):
        none = np.zeros((0, 1))
        return PredictedRun(
            force_N=np.zeros(len(run.time_s)), current_A=current, x_m=none, y_m=none, phi_rad=none
        )
    simulation = Simulation(beam, run.setup, run.drive, resolution=resolution)
    times = run.frame_s
    if run.force:
        times = np.append(run.time_s[:-1:every], run.time_s[-1])
        if frames and run.frame_s[-1] > times[-1]:
            times = np.append(times, run.frame_s[-1])
    motion = simulation.advance(run.drive, times, np.zeros(0))
    if motion.slipped_s is not None:
        raise ModelError(f"{run.name}: the sheet slips out of the rolls at {motion.slipped_s:g} s")
    force = np.zeros(len(run.time_s))
    if run.force:
        force = np.interp(run.time_s, times, motion.reading_N)
    x_m, y_m, phi_rad = simulation.curves(run.frame_s, run.points_m if frames else np.zeros(1))
    return PredictedRun(
        force_N=force, current_A=current, x_m=x_m, y_m=y_m, phi_rad=phi_rad,
        break_m=simulation.break_m,
    )  # fmt: skip


def predicted_current(beam: DynamicBeam, run: RunPlan, resolution: Resolution) -> FloatArray:
    """Return the current (n,); none flows where no electrodes are described."""
    if beam.electrodes is None or not len(run.time_s):
        if run.current and not (run.force or len(run.frame_s)):
            raise ModelError("to predict a current the sheet's electrodes must be described")
        return np.zeros(len(run.time_s))
    line = LineModes(beam.electrodes, beam.length_m, resolution.line_terms)
    inside = run.drive.time_s[(run.drive.time_s > 0.0) & (run.drive.time_s < run.time_s[-1])]
    knots = np.unique(np.concatenate([np.zeros(1), run.time_s, inside]))
    held = run.drive.at(0.5 * (knots[1:] + knots[:-1]))
    begun = line.charged(run.drive.time_s, run.drive.voltage_V)
    modes = line.respond(begun, np.diff(knots), held)
    current = line.current_A(modes, np.concatenate([held[:1], held]))
    return np.asarray(current[np.searchsorted(knots, run.time_s)])
