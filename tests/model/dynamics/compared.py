"""Recorded runs of an example sheet, made by a model with white noise."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.dynamics import ContactSetup, HeldVoltage
from model.dynamics.comparison import ComparedRun, Contender
from model.dynamics.identification import ChannelNoise, RecordedRun, RecordingNoise, RunPlan
from model.dynamics.models.conformance import SHEET

NOISE = RecordingNoise(
    force=ChannelNoise(white=1e-5), current=ChannelNoise(white=1e-4), curve_m=1e-4
)
PULSES = HeldVoltage(np.array([-9.0, -8.4, 0.1, 0.7, 1.3, 1.9]), np.array([1.0, 0, 1, -1, 1, 0]))
POINTS_M = SHEET.free_length_m * np.array([0.25, 0.5, 0.75, 0.9])


def planned(position_m: float | None, name: str = "") -> RunPlan:
    """Three pulses after a rest, at 200 Hz, with 12 frames a second; None: the load cell is away.

    A pulse of the run before has left some charge.
    """
    setup = None
    if position_m is not None:
        setup = ContactSetup(radius_m=SHEET.arc_radius_m, position_m=position_m)
    return RunPlan(
        drive=PULSES, time_s=np.arange(0.0, 2.5, 5e-3), setup=setup, force=setup is not None,
        frame_s=np.arange(0.02, 2.4, 0.083), points_m=POINTS_M, name=name or f"at {position_m}",
    )  # fmt: skip


def recorded(
    model: Contender, values: Mapping[str, float], position_m: float | None, seed: int
) -> ComparedRun | None:
    """Return what a model says of such a run, and noise; None where it says nothing."""
    random = np.random.default_rng(seed)
    plan = planned(position_m)
    shape = len(plan.frame_s), len(plan.points_m)
    blank = RecordedRun(
        plan=plan, force_N=np.zeros_like(plan.time_s) if plan.force else None,
        current_A=np.zeros_like(plan.time_s), x_m=np.zeros(shape), y_m=np.zeros(shape),
    )  # fmt: skip
    said = model.respond(values, ComparedRun(run=blank, sheet=SHEET, noise=NOISE))

    if said.force_N is said.current_A is said.curves_m is None:
        return None

    def noisy(exact, sigma):
        return None if exact is None else exact + sigma * random.standard_normal(exact.shape)

    x = y = None
    if said.curves_m is not None:
        (x, y), (ahead_x, ahead_y) = (_points(*said.curves_m, ahead) for ahead in (0.0, 1e-4))
        off = NOISE.curve_m / np.hypot(ahead_x - x, ahead_y - y) * random.standard_normal(x.shape)
        x, y = x - off * (ahead_y - y), y + off * (ahead_x - x)  # across the sheet
    plan = replace(
        plan, force=said.force_N is not None, current=said.current_A is not None,
        frame_s=plan.frame_s if y is not None else plan.frame_s[:0],
        points_m=POINTS_M if y is not None else POINTS_M[:0],
    )  # fmt: skip
    run = RecordedRun(
        plan=plan, force_N=noisy(said.force_N, NOISE.force.white),
        current_A=noisy(said.current_A, NOISE.current.white), x_m=x, y_m=y,
    )  # fmt: skip
    return ComparedRun(run=run, sheet=SHEET, noise=NOISE)


def _points(x_m, y_m, ahead_m):
    """Return the points of curves (m, n) at POINTS_M along them, or so much further."""
    steps = np.hypot(np.diff(x_m), np.diff(y_m))
    s = np.concatenate([np.zeros((len(x_m), 1)), np.cumsum(steps, axis=1)], axis=1)
    at = POINTS_M + ahead_m
    return (
        np.stack([np.interp(at, a, b) for a, b in zip(s, one, strict=True)]) for one in (x_m, y_m)
    )
