"""A model that is asked what it can describe, and the runs that it is asked with."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from enum import StrEnum

import numpy as np

from model.dynamics.models import DrivenSheet, PublishedModel, Response
from model.measurements import FloatArray, ModelError, SheetGeometry

Respond = Callable[[DrivenSheet], Response]
STEP_S, EVERY_S = 0.6, 5e-3  # of a step in contact or free, and between two of its samples
RAMP_S, RAMP_V = 1.0, 0.12  # so slow that nothing swings, and small
REST_PER_M = 5.0
UNEVEN = 0.1  # relative difference of curvatures
LONG = SheetGeometry(
    configuration="sheet", free_length_m=0.05, width_m=0.011, thickness_m=0.21e-3,
    elongation_m=0.0, arc_radius_m=0.04, arc_origin_rad=0.0, initial_curvature=None,
)  # fmt: skip
SHORT = replace(LONG, free_length_m=4.5e-3, elongation_m=0.04)


class FeatureMark(StrEnum):
    """Whether a model has a feature."""

    YES = "yes"
    NO = "no"
    UNKNOWN = "-"  # it predicts nothing that would show it


@dataclass(frozen=True)
class ProbedModel:
    """A model with numbers of its own."""

    title: str
    respond: Respond  # raises ModelError for a sheet that it cannot describe


def respond_of(model: PublishedModel) -> Respond:
    """Return a published model with its starting values; none is 0, so that every term acts."""
    values = {one.name: one.start or one.prior_scale for one in model.parameters}
    return lambda run: model.simulate(values, run)


def sheet(rest_per_m: float, geometry: SheetGeometry = LONG) -> SheetGeometry:
    """Return a sheet of uniform initial curvature."""
    s_m = np.array([0.0, geometry.free_length_m])
    return replace(geometry, initial_curvature=(s_m, np.full(2, rest_per_m)))


def step(
    volts: float, position_m: float | None, rest_per_m: float = REST_PER_M,
    geometry: SheetGeometry = LONG,
) -> DrivenSheet:  # fmt: skip
    """Return a step of the voltage at 0 s; position None: a free sheet."""
    time = np.arange(0.0, STEP_S, EVERY_S)
    return _run(np.full(len(time), volts), time, position_m, sheet(rest_per_m, geometry))


def ramp() -> DrivenSheet:
    """Return a slow ramp of the voltage on a free sheet that is straight at rest."""
    time = np.linspace(0.0, RAMP_S, 201)
    return _run(RAMP_V * time / RAMP_S, time, None, sheet(0.0))


def _run(
    volts: FloatArray, time: FloatArray, position_m: float | None, of: SheetGeometry
) -> DrivenSheet:
    return DrivenSheet(
        sheet=of, position_m=position_m, time_s=time, drive_V=volts, frames=np.arange(len(time))
    )


def answered(respond: Respond, run: DrivenSheet) -> Response:
    """Return the response; an empty one where the model cannot describe this sheet."""
    try:
        return respond(run)
    except ModelError:
        return Response()


def numbers(response: Response) -> dict[str, FloatArray]:
    """Return what was predicted, by quantity, without what is not finite."""
    found = {"force": response.force_N, "current": response.current_A}
    if response.curves_m is not None:
        found["curve"] = np.stack(response.curves_m)
    return {
        name: values
        for name, values in found.items()
        if values is not None and np.all(np.isfinite(values))
    }


def bends_unevenly(x: FloatArray, y: FloatArray) -> bool:
    """Whether the curvature of a shape differs between its halves.

    Directions are means over a fifth of the shape, so that links and points do not matter. A
    parabola of small slope counts as even.
    """
    angle = np.unwrap(np.arctan2(np.diff(y), np.diff(x)))
    n, middle = len(angle) // 5, (len(angle) - len(angle) // 5) // 2
    at = [float(np.mean(angle[i : i + n])) for i in (0, middle, len(angle) - n)]
    halves = np.diff(at)
    return bool(abs(halves[1] - halves[0]) > UNEVEN * np.max(np.abs(halves)))
