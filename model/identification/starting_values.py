"""Where a fit begins: rest curvature, layout of the parameters, rough values of them."""

from __future__ import annotations

from contextlib import suppress

import numpy as np

from model.identification.curve_smoothing import smooth
from model.identification.observations import Observed
from model.identification.options import FitOptions
from model.identification.paper import Sample, loaded
from model.identification.residual_vector import ParameterLayout, System
from model.measurements import FloatArray, ModelError, SheetGeometry
from model.mechanics.equilibrium import SolverStatus
from model.mechanics.field import Field

LOOP_RAD = 2.0 * np.pi
MOST_TERMS = 6  # of a quantity along a sheet as long as the arc's radius
FREE_PER_M = 200.0  # prior width of an EIBM's mean, over B
FORM_PER_M = 60.0  # and of its change along the sheet
MODES_LONG, MODES_SHORT = 8, 5


def rest_field(sheet: SheetGeometry, observed: Observed) -> tuple[Field, bool]:
    """k0, and whether it is known (else: a rough value, to be refined by the data)."""
    length = sheet.free_length_m
    if sheet.initial_curvature is None:
        return Field.constant(_measured_curvature(observed, 0.0), length), False
    field = Field.linear(*sheet.initial_curvature, length)
    if abs(float(field.integral(length))) > LOOP_RAD:
        raise ModelError(
            f"the initial curvature of configuration '{sheet.configuration}' makes the sheet a loop"
            f" ({float(field.integral(length)):.1f} rad over {length * 1e3:g} mm);"
            " check its unit (per m)"
        )
    return field, True


def _measured_curvature(observed: Observed, voltage_V: float) -> float:
    curves = [
        smooth(o.curve, observed.sheet, o.name, terms=2)
        for o in observed.observations
        if o.curve is not None and o.voltage_V == voltage_V
    ]
    if not curves:
        raise ModelError(
            f"the initial curvature of configuration '{observed.sheet.configuration}' is to be"
            " measured, but there is no curve at 0 V"
        )
    return float(np.mean([c.coefficients[0] for c in curves]))


def layout(observed: Observed, options: FitOptions, rest_known: bool) -> ParameterLayout:
    """How many parameters there are, and an error where the data are too few for them."""
    sheet = observed.sheet
    curves = any(o.curve is not None for o in observed.observations)
    share = min(1.0, sheet.free_length_m / sheet.arc_radius_m)
    terms = 1 + round((MOST_TERMS - 1) * share)
    along = options.eibm_form == "along" and curves
    tolerant = curves and (not rest_known or options.initial_curvature_sigma_per_m > 0.0)
    result = ParameterLayout(
        tuple(observed.voltages_V),
        terms if along else 1,
        terms if tolerant else 0,
        options.symmetric,
    )
    forces = sum(bool(np.isfinite(o.force_N)) for o in observed.touching())
    wanted = 1 + len(result.groups) + (0 if rest_known else 1)
    if forces == 0:
        raise ModelError(
            f"configuration '{sheet.configuration}' has no valid force: shapes fix only Me/B,"
            " so B and the EIBM cannot be found"
        )
    if forces < wanted:
        raise ModelError(
            f"configuration '{sheet.configuration}': {forces} condition(s) with a force cannot fix"
            f" {wanted} parameters (B, one EIBM for each driving voltage); measure more positions"
        )
    return result


def precision(system: System, options: FitOptions, rest_known: bool) -> FloatArray:
    """Of the Gaussian priors: wide for EIBM and B, the stated tolerance for k0."""
    layout = system.layout
    values = np.zeros(layout.size)
    for voltage in layout.voltages_V:
        where, _ = layout.of(voltage)
        values[where] = FORM_PER_M**-2.0
        values[where.start] = FREE_PER_M**-2.0
    tolerance = options.initial_curvature_sigma_per_m if rest_known else FREE_PER_M
    values[layout.rest_slice] = tolerance**-2.0 if layout.rest else 0.0
    return values


def first_guess(system: System) -> FloatArray:
    """Rough parameters. With curves: (2) of every condition is linear in 1/B and Me/B."""
    observed, layout = system.observed, system.layout
    theta = np.zeros(layout.size)
    samples = _samples(system)
    if len(samples) < 2 + len(layout.groups):
        return _from_forces(system, theta)
    A = np.zeros((len(samples), layout.size))
    for row, sample in zip(A, samples, strict=True):
        row[0] = sample.mean_moment_Nm * 1e6  # so that 1/B in 1e6 per N m^2 is of order one
        if sample.observation.voltage_V != 0.0:
            where, sign = layout.of(sample.observation.voltage_V)
            row[where.start] = sign
        if layout.rest:
            row[layout.rest_slice.start] = 1.0
    turns = np.array([s.turn_rad / s.l_hat_m for s in samples])
    theta = np.asarray(np.linalg.lstsq(A, turns, rcond=1e-10)[0], dtype=np.float64)
    if theta[0] <= 0.0:
        raise _wrong_sign(observed)
    theta[0] = -np.log(theta[0]) - 6.0 * np.log(10.0)
    return theta


def _samples(system: System) -> list[Sample]:
    """Conditions whose curve is a smooth one; the others need not stop a rough guess."""
    result = []
    for o in system.observed.touching():
        if o.curve is not None and np.isfinite(o.force_N):
            with suppress(ModelError):
                result.append(loaded(system.observed, o, system.rest, 1.0))
    return result


def _from_forces(system: System, theta: FloatArray) -> FloatArray:
    observed = system.observed
    for group in system.layout.groups:
        theta[system.layout.of(group)[0].start] = 20.0 * np.sign(group)
    equilibria = system.solve(theta)
    forces = np.array([observed.observations[i].force_N for i in system.touching])
    by = equilibria.force(1.0)
    use = np.isfinite(forces) & (equilibria.status == SolverStatus.SOLVED)
    B = float(forces[use] @ by[use] / max(by[use] @ by[use], 1e-300)) if use.any() else 1e-6
    if B <= 0.0:
        raise _wrong_sign(observed)
    theta[0] = np.log(B)
    return theta


def _wrong_sign(observed: Observed) -> ModelError:
    return ModelError(
        f"configuration '{observed.sheet.configuration}': the forces have the opposite sign of what"
        " the shapes say, so B would be negative (check the load cell's sign and the arc's origin)"
    )
