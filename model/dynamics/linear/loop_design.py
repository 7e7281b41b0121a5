"""A controller for a sheet and a rig, and what the linear model says of the loop."""

from __future__ import annotations

from dataclasses import dataclass
from typing import assert_never

import numpy as np

from model.dynamics.linear.feedback import ForceController, Method, lqg, pi
from model.dynamics.linear.state_space import LinearSystem, balanced, discretised
from model.measurements import FloatArray, ModelError

PLANT_STATES = 12  # of the model that goes with a controller: 0.1 % of the static gain
DESIGN_STATES = 8  # of the one that LQG is made on
SETTLED = 0.02  # of the step
_RISEN = 0.9
_LEAST_DAMPING = 1e-9  # damping ratio of a mode: less is rounding
_LONGEST_S = 10.0


@dataclass(frozen=True, kw_only=True)
class StepFigures:
    """How the force follows a step of its reference, the voltage within its limits."""

    step_N: float
    rise_s: float  # until 90 % of the step; NaN: never within 10 s
    settled_s: float  # until it stays within 2 %; NaN likewise
    overshoot: float  # of the step, 0.03 is 3 %


@dataclass(frozen=True, kw_only=True)
class LoopDesign:
    """A controller with the sampled model of sheet, input and output for which it was made."""

    controller: ForceController
    plant: LinearSystem
    sensitivity_peak: float
    step: StepFigures


def designed(
    sheet: LinearSystem,
    method: Method,
    *,
    rate_hz: float,
    delay_s: float,
    limit_V: float,
    step_N: float = 1e-3,
) -> LoopDesign:
    """Return a controller for a sheet's linear model from voltage_V to force_N.

    `delay_s`: from a force to the voltage that it leads to, the mean age of the samples included.
    Raises ModelError where no controller of this kind keeps the loop's margin.
    """
    _check(rate_hz, limit_V, step_N)
    if abs(sheet.static_gain[0, 0]) == 0.0:
        raise ModelError("the voltage does not move the force, so nothing can be controlled")
    if np.any(sheet.poles.real >= -_LEAST_DAMPING * np.abs(sheet.poles)):
        raise ModelError(
            "a controller needs a model in which every motion dies out: give a load cell with a"
            " resonance a damping above 0"
        )
    sampled = discretised(sheet, 1.0 / rate_hz, delay_s)
    plant = _reduced(sheet, PLANT_STATES, rate_hz, delay_s)
    match method:
        case "pi":
            controller = pi(sampled)
        case "lqg":
            controller = lqg(sampled, _reduced(sheet, DESIGN_STATES, rate_hz, delay_s))
        case _:
            assert_never(method)
    if not controller.closed_loop(plant).is_stable:
        raise ModelError("the loop is unstable; use a higher rate or a shorter delay")
    return LoopDesign(
        controller=controller,
        plant=plant,
        sensitivity_peak=controller.sensitivity_peak(sampled),
        step=step_figures(controller, plant, step_N, limit_V),
    )


def _check(rate_hz: float, limit_V: float, step_N: float) -> None:
    for name, value, unit in (("rate", rate_hz, "Hz"), ("voltage limit", limit_V, "V")):
        if not 0.0 < value < np.inf:
            raise ModelError(
                f"the {name} of a loop must be positive and finite, not {value:g} {unit}"
            )
    if not np.isfinite(step_N) or step_N == 0.0:
        raise ModelError(
            f"the step of the force must be finite and not 0, it is {1e3 * step_N:g} mN"
        )


def step_figures(
    controller: ForceController, plant: LinearSystem, step_N: float, limit_V: float
) -> StepFigures:
    """Return how the linear loop follows a step."""
    samples = round(_LONGEST_S / controller.sample_time_s)
    force_N, _ = controller.follow(plant, np.full(samples, step_N), limit_V)
    return figures_of(force_N, controller.sample_time_s, step_N)


def figures_of(force_N: FloatArray, sample_time_s: float, step_N: float) -> StepFigures:
    """Return the figures of a force (samples,) that follows a step of its reference at sample 0."""
    share = np.asarray(force_N, dtype=float) / step_N
    risen = np.flatnonzero(share >= _RISEN)
    off = np.flatnonzero(np.abs(share - 1.0) > SETTLED)
    settled = 0 if not len(off) else int(off[-1]) + 1
    return StepFigures(
        step_N=step_N,
        rise_s=float(risen[0] * sample_time_s) if len(risen) else float("nan"),
        settled_s=settled * sample_time_s if settled < len(share) else float("nan"),
        overshoot=max(float(share.max()) - 1.0, 0.0),
    )


def _reduced(sheet: LinearSystem, states: int, rate_hz: float, delay_s: float) -> LinearSystem:
    return discretised(balanced(sheet, states)[0], 1.0 / rate_hz, delay_s)
