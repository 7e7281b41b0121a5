"""Sessions of the world that moves, and the dynamics of its sheets in the model's words."""

from __future__ import annotations

from collections.abc import Mapping
from contextlib import AbstractContextManager
from dataclasses import replace
from functools import cache
from unittest.mock import patch

import numpy as np

from benchmarks.worlds.contract import Design
from benchmarks.worlds.generators import _moving_sheet as world
from benchmarks.worlds.generators._moving_noise import strips
from benchmarks.worlds.generators.moving import WORLD
from model import Along, Parameter, SheetModel
from model.dynamics import DynamicSheet, PronyTerm
from model.measurements import Condition, Measurements, SheetGeometry, TimeSeries
from model.sheet.configured_sheet import ConfiguredSheet

FEW_M = (0.0, 0.01, 0.02, 0.03)
MOST_M = (0.0, 0.005, 0.01, 0.015, 0.02, 0.025, 0.03)
SLOW_GEL_S, FINE_S = 4.0, 1e-3
# viscous time in s, share of B that relaxes in 30 ms, and the damping ratio of both at 3.3 Hz
LOSSES = {"usual": (4e-3, 0.35, 0.12), "small": (4e-4, 0.14, 0.036), "least": (2e-4, 0.045, 0.012)}


@cache
def session(
    seed: int, hidden: tuple[tuple[str, float], ...], positions_m: tuple[float, ...] = FEW_M,
    readings: int = 4, free_shapes: int = 1, loss: str = "usual",
) -> Measurements:  # fmt: skip
    """The long sheet of the world with one of `LOSSES`, and kinds of these sizes hidden."""
    design = Design(
        positions_m={"long": positions_m}, free_shapes=free_shapes, readings=readings,
        random_order=True,
    )  # fmt: skip
    with _world_of(loss):
        found = WORLD.measure(design, dict(hidden), seed)
        return replace(
            found, conditions=tuple(map(timed, found.conditions)),
            series=tuple(map(averaged, found.series)),
        )  # fmt: skip


def timed(condition: Condition) -> Condition:
    """A condition with the instants of its frames: the world's shapes are half a step old."""
    step_s = world.FREE_STEP_S if condition.position_m is None else world.HELD_STEP_S
    readings = (replace(r, frame_s=r.time_s - 0.5 * step_s) for r in condition.readings)
    return replace(condition, readings=tuple(readings))


def averaged(series: TimeSeries) -> TimeSeries:
    """A series whose drive is the mean about its times, as that of a recording is.

    The world takes two steps together, and states the middle of their beginnings.
    """
    before = np.concatenate([[0.0], series.drive_V[:-1]])
    return replace(series, drive_V=0.75 * series.drive_V + 0.25 * before)


def known(value: float, unit: str = "") -> Parameter:
    return Parameter(value=value, sigma=0.0, unit=unit)


def _world_of(loss: str) -> AbstractContextManager[object]:
    """The world with a loss; where it is small held sheets ring at 20 Hz, which asks for steps."""
    viscous_s, share, _ = LOSSES[loss]
    steps = {} if loss == "usual" else {"HELD_STEP_S": FINE_S, "FREE_STEP_S": FINE_S}
    return patch.multiple(world, VISCOUS_S=viscous_s, QUICK_SHARE=share, **steps)


def true_model(
    seed: int, hidden: Mapping[str, float], sheet: SheetGeometry, loss: str = "usual"
) -> SheetModel:
    """The long sheet with its dynamics as they are; its static EIBM is that of a full charge."""
    strip, (viscous_s, share, _) = strips(seed)["long"], LOSSES[loss]
    B, alpha = strip.stiffness_Nm2, strip.stiffness_Nm2 * strip.driven_per_m / world.DRIVE_V
    prony = [PronyTerm(share=known(share), time_s=known(world.QUICK_S))]
    if "slow_gel" in hidden:
        prony.append(PronyTerm(share=known(hidden["slow_gel"]), time_s=known(SLOW_GEL_S)))
    slower = 1.0 + hidden.get("sluggish_ions", 0.0)
    dynamic = DynamicSheet(
        mass_per_length_kg_per_m=known(world.SHEET_KG_PER_M),
        viscous_time_s=known(viscous_s),
        electrode_ohm_per_m=known(max(1.0, hidden.get("resistive_faces", 0.0))),
        capacitance_F_per_m=known(world.FARAD_PER_M),
        bulk_ohm_m=known(slower * world.RISE_S / world.FARAD_PER_M),
        leak_S_per_m=known(world.LEAK_S_PER_M), source_ohm=known(1e-4),
        moment_per_volt_Nm=(known(alpha), known(alpha * strip.negative)), prony=tuple(prony),
    )  # fmt: skip
    rest = Along(strip.nodes_m, strip.rest_per_m, np.zeros(len(strip.nodes_m)), "1/m")
    eibm = {
        v: Along.constant(known(alpha * v * r)) for v, r in ((2.0, 1.0), (-2.0, strip.negative))
    }
    one = ConfiguredSheet(sheet, known(B, "N m^2"), rest, eibm)
    return SheetModel(sheets={"long": one}, dynamic={"long": dynamic})
