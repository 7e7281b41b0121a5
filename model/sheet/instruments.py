"""What load cell and camera make of a condition, where a model says that they deceive.

Effects of the load cell see a typical run's readings in the order of time; those of the camera see
the curve's points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from model.effects.interface import ImagePoints
from model.measurements import FloatArray
from model.mechanics.equilibrium import Shapes
from model.sheet.applied_effects import acting, beam_problem, contact_solution, terms
from model.sheet.beam_problem import ActiveEffect, ConditionProblem
from model.sheet.effect_hooks import (
    added_force_N,
    image_change,
    image_displacement_m,
    load_cell_input,
)
from model.sheet.solution import SolvedProblems
from model.sheet.typical_run import mean_over, typical_run


def load_cell_N(
    effects: Sequence[ActiveEffect],
    found: SolvedProblems,
    rows: Mapping[float, int],
    voltage_V: float,
    position_m: float,
) -> float:
    """Return the load cell's contribution to the mean of a condition's readings, N.

    `rows` maps a voltage to its row in the solution; all rows are at this position. The run
    alternates between `voltage_V` and the other driving voltage there.
    """
    others = [v for v in rows if v not in (0.0, voltage_V)]
    run = typical_run(voltage_V, others[0] if others else 0.0)
    name = found.setups[0].sheet.configuration
    beam = beam_problem(found.setups, [position_m] * len(found.setups))
    of = np.array([rows.get(v, rows[0.0]) for v in run.clock.voltage_V])
    weighed = load_cell_input(beam, contact_solution(found, beam), run.clock, of)
    added_N = added_force_N(acting(effects, name), weighed, np.arange(len(of)))
    total = mean_over(added_N, run.at(voltage_V))
    for where, term in terms(effects, name):
        added = where.force(weighed, term)
        if added is not None:
            total += mean_over(added, run.at(voltage_V))
    return total


def as_pictured(setup: ConditionProblem, effects: Sequence[ActiveEffect]) -> ConditionProblem:
    """Return the sheet at the time of the image, which may be older than the reading."""
    name = setup.sheet.configuration
    inner = acting(effects, name)
    if setup.voltage_V == 0.0:
        return setup
    run = typical_run(setup.voltage_V, -setup.voltage_V, setup.sheet.rise_time_s)
    seen, use = image_change(inner, run.clock), run.at(setup.voltage_V)
    more = 0.0 if seen is None else mean_over(seen, use)
    at_m = (setup.angle_rad - setup.sheet.arc_origin_rad) * setup.sheet.arc_radius_m
    position_m = np.full(len(run.clock.voltage_V), at_m)
    for where, term in terms(effects, name) if setup.touches else ():
        changed = where.pictured(run.clock, position_m, term)
        if changed is not None:
            more += mean_over(changed, use)
    return replace(setup, eibm=setup.eibm * (1.0 + more))


def camera_m(
    effects: Sequence[ActiveEffect], setup: ConditionProblem, curve: Shapes
) -> tuple[FloatArray, FloatArray]:
    """Return the camera's contribution to the points of one curve, the first of `curve`."""
    s_m, x_m, y_m, phi_rad = curve.s_m, curve.x_m[0], curve.y_m[0], curve.phi_rad[0]
    name = setup.sheet.configuration
    points = ImagePoints(
        s_m=s_m[None], x_m=x_m[None], y_m=y_m[None], normal_x=-np.sin(phi_rad)[None],
        normal_y=np.cos(phi_rad)[None], scale_m=setup.sheet.free_length_m,
    )  # fmt: skip
    (dx,), (dy,) = image_displacement_m(acting(effects, name), points)
    for where, term in terms(effects, name):
        added = where.curve(points, term)
        if added is not None:
            dx, dy = dx + added[0][0], dy + added[1][0]
    return dx, dy
