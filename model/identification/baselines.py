"""Simpler models people use, fitted to the same measurements: what large deflection is worth.

- constant curvature: the loaded sheet is a circular arc, (2) holds with its mean moment;
- linear beam: small deflections, uniform EIBM;
- equivalent beam: small deflections, and instead of a moment the voltage makes a force at the
  sheet's tip, the blocked force.
Each has B and one number for each voltage, found by least squares from all forces and curves; k0 is
known. The full model with constant EIBM is fitted to the same sum of squares; that with an EIBM
along the sheet is the one `fit` finds.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

import numpy as np

from model.identification.fit import fit
from model.identification.fit_result import ConfigurationFit, Fit
from model.identification.observations import Observation, Observed, observe
from model.identification.options import FitOptions
from model.identification.residuals import distance_to
from model.identification.starting_values import rest_field
from model.measurements import FloatArray, Measurements, ModelError, scale_of
from model.mechanics.arc import arc_contact, arc_points
from model.mechanics.equilibrium import SolverStatus, problems, solve
from model.mechanics.field import Field
from model.mechanics.linear_beam import LinearBeam

PLACES = 201  # of a shape
# of sessions of the paper's size: what is weighed as one, its own order of error, and a rough B
FORCE_SCALE_N, CURVE_SCALE_M, USUAL_B_NM2 = 1e-4, 3e-4, 1e-6


@dataclass(frozen=True)
class Answer:
    """One condition over B: force, and the shape of the sheet as points."""

    force_per_m2: float
    x_m: FloatArray
    y_m: FloatArray


OneAngle = Callable[[float], Answer]  # of the moment over B (or the tip force over B)
Simple = Callable[[Observed, Field, float], OneAngle]  # of the sheet, k0, the polar angle


def constant_curvature(observed: Observed, rest: Field, angle: float) -> OneAngle:
    """Fit an arc through the contact, or an arc whose straight elongation passes through it."""
    sheet = observed.sheet
    arc = arc_contact(rest, sheet.arc_radius_m, angle, elongation_m=np.inf)
    s = np.linspace(0.0, sheet.free_length_m, PLACES)
    x, y = arc_points(np.array([arc.curvature_per_m]), s)
    return lambda bend: Answer(float(arc.force_over_B(np.array(bend))), x[0], y[0])


def linear_beam(observed: Observed, rest: Field, angle: float) -> OneAngle:
    """Small deflections: y'' = k0 + Me/B - (N/B)(R - x), y(R) = R beta."""
    uniform = Field.constant(1.0, observed.sheet.free_length_m)
    return _small(observed, rest, uniform, angle)


def equivalent_beam(observed: Observed, rest: Field, angle: float) -> OneAngle:
    """Fit the voltage as a force f at the tip: y'' = k0 + (f/B)(l - x) - (N/B)(R - x)."""
    length = observed.sheet.free_length_m
    by_tip = Field.linear(np.array([0.0, length]), np.array([2.0, 0.0]), length)
    return _small(observed, rest, by_tip, angle)


def _small(observed: Observed, rest: Field, active: Field, angle: float) -> OneAngle:
    """Force and shape are linear in the bend: both are computed for 0 and 1/m alone."""
    sheet = observed.sheet
    beam, ends = LinearBeam(rest, active, sheet.arc_radius_m, angle), np.array([0.0, 1.0])
    x = np.linspace(0.0, sheet.free_length_m, PLACES)
    (force, force_1), (y, y_1) = beam.force_over_B(ends), beam.heights_m(x, ends)
    return lambda bend: Answer(
        float(force + bend * (force_1 - force)), x, np.asarray(y + bend * (y_1 - y))
    )


def full_model(observed: Observed, rest: Field, angle: float) -> OneAngle:
    """Large deflection, constant EIBM."""
    sheet = observed.sheet
    s = np.linspace(0.0, sheet.free_length_m, PLACES)

    def of(bend: float) -> Answer:
        kappa = rest + Field.constant(bend, sheet.free_length_m)
        found = solve(problems(kappa, angle, sheet.arc_radius_m, 10.0 * sheet.arc_radius_m))
        if found.status[0] != SolverStatus.SOLVED:
            raise ModelError("no equilibrium")
        shape = found.shapes(s)
        return Answer(float(found.force(1.0)[0]), shape.x_m[0], shape.y_m[0])

    return of


MODELS: dict[str, Simple] = {
    "full model, constant EIBM": full_model,
    "constant curvature": constant_curvature,
    "linear beam": linear_beam,
    "equivalent beam": equivalent_beam,
}


@dataclass(frozen=True, kw_only=True)
class BaselineRow:
    """One line of the comparison."""

    configuration: str
    model: str
    B_Nm2: float
    bend_per_m: dict[float, float]  # Me/B by voltage (mean over the sheet for the equivalent beam)
    force_rmse_N: float
    curve_rmse_m: float


def compare(
    measurements: Measurements, options: FitOptions | None = None, by_fit: Fit | None = None
) -> tuple[BaselineRow, ...]:
    """Every model against every configuration; `by_fit`: where the same was fitted already."""
    by_fit = by_fit or fit(measurements, options)
    options = options or FitOptions()
    names = options.configurations or tuple(
        n for n in measurements.sheets if any(c.configuration == n for c in measurements.conditions)
    )
    rows = []
    for name in names:
        observed = observe(measurements, name)
        rest, _ = rest_field(observed.sheet, observed)
        rows += [_fitted(label, simple, observed, rest) for label, simple in MODELS.items()]
        rows.append(_along(by_fit.configurations[name]))
    return tuple(rows)


def _along(one: ConfigurationFit) -> BaselineRow:
    bends = {v: p.value / one.B.value for v, p in one.eibm.items()}
    errors = one.rmse["varying"]
    return BaselineRow(
        configuration=one.configuration, model="full model, EIBM along the sheet",
        B_Nm2=one.B.value, bend_per_m=bends, force_rmse_N=errors.force_N,
        curve_rmse_m=errors.curve_m,
    )  # fmt: skip


def _fitted(label: str, simple: Simple, observed: Observed, rest: Field) -> BaselineRow:
    from scipy.optimize import least_squares  # slow to import

    used = [o for o in observed.touching() if np.isfinite(o.force_N)]
    if len(used) < 1 + len(observed.voltages_V):
        raise ModelError(
            f"configuration '{observed.sheet.configuration}' has too few conditions to compare"
            " models"
        )
    volts = observed.voltages_V
    scale = scale_of([observed.sheet], np.array([o.force_N for o in used]))
    conditions = [
        (o, _errors_of(o, observed, simple(observed, rest, _angle(observed, o)))) for o in used
    ]

    def errors(theta: FloatArray) -> tuple[FloatArray, FloatArray]:
        bends = {0.0: 0.0, **dict(zip(volts, theta[1:], strict=True))}
        forces, curves = [], []
        for o, predicted in conditions:
            force_per_m2, distance_m = predicted(float(bends[o.voltage_V]))
            forces.append(float(np.exp(theta[0])) * force_per_m2 - o.force_N)
            if distance_m is not None:
                curves.append(distance_m)
        return np.array(forces), np.array(curves)

    def residual(theta: FloatArray) -> FloatArray:
        force, curve = errors(theta)
        in_force, in_curve = FORCE_SCALE_N * scale.force, CURVE_SCALE_M * scale.length
        return np.concatenate([force / in_force, curve / in_curve])

    usual_B = USUAL_B_NM2 * scale.force * scale.length**2
    begin = np.array([np.log(usual_B), *(20.0 / scale.length * np.sign(v) for v in volts)])
    steps = [0.1, *(5.0 / scale.length for _ in volts)]
    found = least_squares(residual, begin, x_scale=steps)
    force, curve = errors(np.asarray(found.x))
    return BaselineRow(
        configuration=observed.sheet.configuration, model=label, B_Nm2=float(np.exp(found.x[0])),
        bend_per_m=dict(zip(volts, (float(v) for v in found.x[1:]), strict=True)),
        force_rmse_N=float(np.sqrt(np.mean(force**2))),
        curve_rmse_m=float(np.sqrt(np.mean(curve**2))) if len(curve) else float("nan"),
    )  # fmt: skip


def _errors_of(
    o: Observation, observed: Observed, answer_of: OneAngle
) -> Callable[[float], tuple[float, float | None]]:
    """Return the force over B and the distance of the curve, by the bend.

    The last ones are kept: of the search's steps along single parameters only one changes the bend
    of a condition.
    """

    @lru_cache(maxsize=2)
    def predicted(bend: float) -> tuple[float, float | None]:
        answer = answer_of(bend)
        if o.curve is None:
            return answer.force_per_m2, None
        length = observed.sheet.free_length_m
        return answer.force_per_m2, distance_to(answer.x_m, answer.y_m, o.curve, length)

    return predicted


def _angle(observed: Observed, o: Observation) -> float:
    sheet = observed.sheet
    return sheet.arc_origin_rad + (o.position_m or 0.0) / sheet.arc_radius_m


__all__ = ["MODELS", "Answer", "BaselineRow", "compare"]
