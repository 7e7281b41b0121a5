"""Conditions that a session does not hold, and what is true of them: no noise, nominal set-ups."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np

from benchmarks.hidden_effects.cases import Case
from benchmarks.hidden_effects.recipe import BOTH
from benchmarks.hidden_effects.sessions import prepared
from benchmarks.hidden_effects.visits import FREE_TRAIN, POSITIONS_M, train_of, visits
from model.measurements import FloatArray
from sim_hardware.world import (
    CurveErrors,
    Scatter,
    TimedRun,
    Visit,
    each_after,
)

DRIVEN_V = 2.0
BETWEEN_V = DRIVEN_V / 2.0
EXACT = CurveErrors(white_m=0.0, smooth_m=0.0)
QUIET = (
    "scatter.eibm", "scatter.stiffness", "scatter.position_mm", "scatter.clamp_tilt_rad",
    "scatter.registration_mm", "load_cell.noise_mN", "load_cell.drift_mN",
)  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class TrueCondition:
    """One condition, as a rig without noise measures it amid the session."""

    configuration: str
    position_m: float
    voltage_V: float
    force_N: float
    s_m: FloatArray  # (n,)
    points_m: FloatArray  # (n, 2)


def unmeasured(case: Case) -> list[TrueCondition]:
    """Return conditions half-way between the session's positions, some between its voltages."""
    recipe, _ = prepared(replace(case, outlier=False))
    for key in QUIET:
        recipe.set(key, 0.0)
    world, planned = recipe.settings(), list(visits(case))
    wanted = list(_wanted())
    runs = each_after(
        world, planned[: len(planned) // 2],
        [(visit, replace(train_of(case), voltages=(volts, -volts))) for visit, volts, _ in wanted],
        train=train_of(case), free_train=FREE_TRAIN, errors=EXACT,
    )  # fmt: skip
    return [
        _condition(run, volts)
        for run, (_, _, voltages) in zip(runs, wanted, strict=True) if run is not None
        for volts in voltages
    ]  # fmt: skip


def _wanted() -> Iterator[tuple[Visit, float, tuple[float, ...]]]:
    """Yield ten conditions of each configuration: the run, its voltage, and which of its means."""
    between = [0.5 * (a + b) for a, b in pairwise(POSITIONS_M)]
    for c, name in enumerate(BOTH):
        for k, at_m in enumerate(between):
            volts = (DRIVEN_V, -DRIVEN_V, 0.0)[(k + c) % 3]
            yield _visit(name, at_m), DRIVEN_V, (volts,)
        for at_m, voltages in zip(between[c::2], ((1.0,), (-1.0,), (1.0, -1.0)), strict=True):
            scaled = tuple(BETWEEN_V * v for v in voltages)
            yield _visit(name, at_m), BETWEEN_V, scaled


def _visit(configuration: str, position_m: float) -> Visit:
    return Visit(configuration=configuration, position_m=position_m, odd=Scatter())


def _condition(run: TimedRun, volts: float) -> TrueCondition:
    """Return the mean force and the curve of the mean image at a voltage of a run."""
    used = [r.force_N for r in run.readings if r.voltage_V == volts and r.kind in ("kept", "zero")]
    return TrueCondition(
        configuration=run.visit.configuration, position_m=run.visit.position_m or 0.0,
        voltage_V=volts, force_N=float(np.mean(used)), s_m=run.s_m, points_m=run.curves_m[volts],
    )  # fmt: skip
