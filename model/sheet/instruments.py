"""What load cell and camera make of a condition, where a model says that they deceive.

Effects of the load cell see a typical run's readings in the order of time; those of the camera see
the curve's points.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.effects.interface import BeamProblem, ContactSolution, Effect, ImagePoints
from model.measurements import FloatArray, length_scale
from model.mechanics.equilibrium import Shapes
from model.sheet.applied_effects import acting, beam_problem, contact_solution
from model.sheet.beam_problem import ActiveEffect, ConditionProblem
from model.sheet.effect_hooks import (
    Acting,
    added_force_N,
    image_change,
    image_displacement_m,
    load_cell_input,
)
from model.sheet.solution import SolvedProblems
from model.sheet.typical_run import mean_over, typical_run


def deceives_load_cell(effects: Sequence[ActiveEffect], configuration: str) -> bool:
    """Return whether any effect changes what the load cell reads."""
    return any(type(one.effect).force is not Effect.force for one in acting(effects, configuration))


@dataclass(frozen=True)
class LoadCellReadings:
    """What the load cell is given in solved conditions, and the effects that it adds."""

    acting: Sequence[Acting]
    positions_m: Sequence[float]  # of all rows of the solution
    beam: BeamProblem
    contact: ContactSolution

    @staticmethod
    def of(
        effects: Sequence[ActiveEffect], found: SolvedProblems, positions_m: Sequence[float]
    ) -> LoadCellReadings | None:
        """Return that of a solution; None: it reads what is there."""
        configuration = found.setups[0].sheet.configuration
        if not deceives_load_cell(effects, configuration):
            return None
        beam = beam_problem(found.setups, positions_m)
        inner = acting(effects, configuration)
        return LoadCellReadings(inner, positions_m, beam, contact_solution(found, beam))

    def added_N(self, rows: Mapping[float, int], voltage_V: float) -> float:
        """Return its contribution to the mean of a condition's readings, N.

        `rows` maps a voltage to its row in the solution; all of these are at one position. The run
        alternates between `voltage_V` and the other driving voltage.
        """
        others = [v for v in rows if v not in (0.0, voltage_V)]
        position_m = self.positions_m[rows[voltage_V]]
        run = typical_run(voltage_V, others[0] if others else 0.0, position_m=position_m)
        of = np.array([rows.get(v, rows[0.0]) for v in run.clock.voltage_V])
        weighed = load_cell_input(self.beam, self.contact, run.clock, of)
        added_N = added_force_N(self.acting, weighed, np.arange(len(of)))
        return mean_over(added_N, run.at(voltage_V))


def load_cell_N(
    effects: Sequence[ActiveEffect],
    found: SolvedProblems,
    positions_m: Sequence[float],
    rows: Mapping[float, int],
    voltage_V: float,
) -> float:
    """Return the load cell's contribution to the mean of a condition, N: see `LoadCellReadings`."""
    cell = LoadCellReadings.of(effects, found, positions_m)
    return 0.0 if cell is None else cell.added_N(rows, voltage_V)


def as_imaged(
    setup: ConditionProblem, effects: Sequence[ActiveEffect], position_m: float | None
) -> ConditionProblem:
    """Return the sheet at the time of the image, which may be older than the reading."""
    name = setup.sheet.configuration
    inner = acting(effects, name)
    if setup.voltage_V == 0.0:
        return setup
    at_m = np.nan if position_m is None else position_m
    run = typical_run(
        setup.voltage_V, -setup.voltage_V, setup.sheet.rise_time_s, at_m, setup.opposite_ratio
    )
    seen = image_change(inner, run.clock)
    if seen is None:
        return setup
    more = mean_over(seen, run.at(setup.voltage_V))
    induced = setup.eibm if setup.induced is None else setup.induced  # weight is never late
    return replace(setup, eibm=setup.eibm + induced * more)


def camera_m(
    effects: Sequence[ActiveEffect], found: SolvedProblems, curves: Shapes, row: int = 0
) -> tuple[FloatArray, FloatArray]:
    """Return the camera's contribution to the points of one of the curves of a solution."""
    setup = found.setups[row]
    s_m, x_m, y_m, phi_rad = curves.s_m, curves.x_m[row], curves.y_m[row], curves.phi_rad[row]
    points = ImagePoints(
        s_m=s_m[None], x_m=x_m[None], y_m=y_m[None], normal_x=-np.sin(phi_rad)[None],
        normal_y=np.cos(phi_rad)[None],
        length_scale=length_scale(setup.sheet),
        free_length_m=setup.sheet.free_length_m, contact_m=found.s_hat_m[row],
        pressed_per_m2=found.nu[row], session_number=float(setup.session),
        voltage_V=setup.voltage_V,
    )  # fmt: skip
    (dx,), (dy,) = image_displacement_m(acting(effects, setup.sheet.configuration), points)
    return dx, dy
