"""The drawn session, measured on the moving world: a chain of links with an RC ladder.

Asked directly, without pixels and without the wire.
"""

from __future__ import annotations

import numpy as np

from benchmarks.dynamic_coverage.drawn import CURVE_M, DrawnSession
from model.dynamics.identification import RecordedRun, RunPlan
from sim_hardware.world.mechanics import Stage
from sim_hardware.world.motion.moving_history import MovingHistory
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.load_cell import SimulatedLoadCell
from sim_hardware.world.signals.noise import SlowWander

EXPOSURE_INSTANTS = 5
COMMON_CURVE_M = 2e-6  # error of a curve that all frames of a run share


class SlippedError(Exception):
    """The sheet left the rolls: nobody would use this run."""


def measured(session: DrawnSession, *, noisy: bool = True) -> list[RecordedRun]:
    """Return the session's runs. Raises SlippedError."""
    seeds = np.random.SeedSequence((session.seed, 0xD1CF)).spawn(len(session.plans))
    return [_run(session, p, s, noisy) for p, s in zip(session.plans, seeds, strict=True)]


def _run(
    session: DrawnSession, plan: RunPlan, seed: np.random.SeedSequence, noisy: bool
) -> RecordedRun:
    history = _history(session, plan)
    random = np.random.default_rng(seed)
    t, d = plan.time_s, session.disturbances
    force = current = None
    x = y = None
    if plan.current:
        current = history.current_A(t)
    if plan.setup is not None:
        moment = history.at(t)[0]
        if np.any(moment.true_N == 0.0):
            raise SlippedError
        if plan.force:
            force = moment.felt_N
    if noisy and force is not None:
        wander = SlowWander(int(seed.generate_state(1)[0]), 1, 1.5, 120.0)
        force = force + d.zero_N * random.standard_normal() + d.drift_N * wander.at(t)
        force += _hum(d.force_hum_N, d.mains_hz, t, random)
        force += d.force_white_N * random.standard_normal(t.size)
    if noisy and current is not None:
        current = current + d.current_zero_A * random.standard_normal()
        current += _hum(d.current_hum_A, d.mains_hz, t, random)
        current += d.current_white_A * random.standard_normal(t.size)
    if len(plan.frame_s):
        x, y = _frames(history, plan, session.settings.camera.exposure_s)
        if noisy:
            x, y = _seen(x, y, random)
    return RecordedRun(plan=plan, force_N=force, current_A=current, x_m=x, y_m=y)


def _history(session: DrawnSession, plan: RunPlan) -> MovingHistory:
    """The run in the world; it begins at rest and the drive is written as planned."""
    settings = session.settings
    amplifier = SimulatedAmplifier(settings.amplifier, 0.0)
    cell = SimulatedLoadCell(settings.load_cell, settings.seed)
    first = Stage(start_s=0.0, setup=session.mounted(plan))
    history = MovingHistory(settings, amplifier, cell, first, lambda *_: None)
    for when, volts in zip(plan.drive.time_s, plan.drive.voltage_V, strict=True):
        history.advance(float(when))
        amplifier.write(float(volts) / settings.amplifier.gain, float(when))
    return history


def _frames(
    history: MovingHistory, plan: RunPlan, exposure_s: float
) -> tuple[np.ndarray, np.ndarray]:
    """Mean curve over each exposure, at the plan's points: what the blurred middle line is."""
    instants = np.linspace(-0.5, 0.5, 2 * EXPOSURE_INSTANTS + 1)[1::2] * exposure_s
    moments = history.at((plan.frame_s[:, None] + instants).ravel())[0]
    n = EXPOSURE_INSTANTS
    curves = np.array([moments.curve(k, plan.points_m) for k in range(n * len(plan.frame_s))])
    mean = curves.reshape(len(plan.frame_s), n, *curves.shape[1:]).mean(axis=1)
    return mean[..., 0], mean[..., 1]


def _seen(x: np.ndarray, y: np.ndarray, random: np.random.Generator) -> tuple:
    """Points with errors across the curve."""
    off = CURVE_M * random.standard_normal(x.shape) + COMMON_CURVE_M * random.standard_normal(
        x.shape[1]
    )
    before = (
        np.concatenate([np.zeros((len(x), 1)), x], axis=1),
        np.concatenate([np.zeros((len(y), 1)), y], axis=1),
    )
    tx, ty = (np.gradient(b, axis=1)[:, 1:] for b in before)
    size = np.hypot(tx, ty)
    return x - off * ty / size, y + off * tx / size


def _hum(amplitude: float, hz: float, t: np.ndarray, random: np.random.Generator) -> np.ndarray:
    return amplitude * np.cos(2.0 * np.pi * (hz * t + random.uniform()))
