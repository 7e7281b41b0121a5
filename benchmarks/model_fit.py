"""A joint fit against what it is made of, and against the same fit on scipy's solve_bvp.

21 conditions (seven positions, three voltages) with a force and a curve of 50 points each, 19
parameters: ln B, six coefficients of Me/B for each driving voltage and of the initial curvature.
CPU times of one process.
"""

from __future__ import annotations

import benchmarks._one_thread  # noqa: F401  (before numpy)

# isort: split

import numpy as np

from benchmarks.model_equilibrium import R, by_scipy, cpu
from benchmarks.report import Report, Table
from model import (
    Along,
    Condition,
    ConfiguredSheet,
    Curve,
    Measurements,
    Parameter,
    Reading,
    SheetGeometry,
    SheetModel,
    predict,
)
from model.identification.base_model import BaseOptions, bases_of
from model.identification.data.data_vector import data_vector_of, means_of
from model.identification.fit import fit
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.gauss_newton import least_squares
from model.identification.observations import observe
from model.mechanics.field import Field

B, REST, BENDS = 1.27e-6, 14.0, {2.0: 25.0, -2.0: -20.0}


def made(seed: int = 0) -> Measurements:
    """Measurements of the base model with noise."""
    random = np.random.default_rng(seed)
    k0 = (np.zeros(1), np.array([REST]))
    sheet = SheetGeometry(
        configuration="long",
        free_length_m=0.05,
        width_m=0.011,
        thickness_m=0.21e-3,
        elongation_m=0.0,
        arc_radius_m=R,
        arc_origin_rad=0.0,
        initial_curvature=k0,
    )
    eibm = {
        v: Along.constant(Parameter(value=B * k, sigma=0.0, unit="N m")) for v, k in BENDS.items()
    }
    rest = Along(*k0, np.zeros(1), "1/m")
    model = SheetModel(
        sheets={
            "long": ConfiguredSheet(sheet, Parameter(value=B, sigma=0.0, unit="N m^2"), rest, eibm)
        }
    )
    conditions = []
    for position in np.linspace(0.0, 0.03, 7):
        for voltage in (0.0, 2.0, -2.0):
            p = predict(model, "long", float(position), voltage)
            s = np.linspace(0.0, 0.05, 50)
            x, y = (
                np.interp(s, p.s_m, v) + 1e-5 * random.standard_normal(50) for v in (p.x_m, p.y_m)
            )
            forces = p.F_N + 5e-5 * random.standard_normal(10)
            kind = "kept" if voltage else "zero"
            readings = tuple(
                Reading(index=i, kind=kind, force_N=float(f)) for i, f in enumerate(forces)
            )
            conditions.append(
                Condition(
                    configuration="long",
                    position_m=float(position),
                    voltage_V=voltage,
                    readings=readings,
                    curve=Curve(s_m=s, x_m=x, y_m=y),
                )
            )
    return Measurements(sheets={"long": sheet}, conditions=tuple(conditions))


class _Counted(ForwardModel):
    """Counts the evaluations of the model."""

    evaluations = 0

    def state(self, *where):
        self.evaluations += 1
        return super().state(*where)


def measure() -> Report:
    """About half a minute."""
    data = made()
    observed, rest = observe(data, "long"), Field.constant(REST, 0.05)

    def forward() -> _Counted:
        return _Counted([means_of(data_vector_of(data, "long"))], [rest])

    counted = forward()
    bases = bases_of(counted, [True], BaseOptions(along=True, rest_sigma_per_m=1.0))
    theta = np.zeros(bases.size)
    part = bases.parts[0]
    theta[part.stiffness] = np.log(2e-6)
    for volts, (first, _) in part.eibm.items():
        theta[first] = 5.0 * volts
    start, theta = theta, least_squares(counted, bases, theta)
    whole = cpu(lambda: least_squares(forward(), bases, start), 3)
    beam, configuration_model = bases.beam(counted, 0, theta), counted.configuration_models[0]
    kernel = (
        cpu(lambda: configuration_model.answers(beam, configuration_model.solve(beam)), 20)
        * counted.evaluations
    )
    each = [
        by_scipy(REST + BENDS.get(o.voltage_V, 0.0), 0.05, float(o.position_m) / R)
        for o in observed.observations
    ]
    by_bvp = cpu(
        lambda: [
            by_scipy(REST + BENDS.get(o.voltage_V, 0.0), 0.05, float(o.position_m) / R)
            for o in observed.observations
        ],
        1,
    )
    # the shape does not depend on ln B: the others to difference by, and the value itself
    scipy_fit = by_bvp * bases.size * counted.evaluations
    everything = cpu(lambda: fit(data), 1)
    rows = (
        ("joint fit, given noise", f"{whole * 1e3:.1f} ms", "1"),
        ("the equilibria, shapes and derivatives in it", f"{kernel * 1e3:.1f} ms",
         f"{whole / kernel:.2f}"),
        ("the same on solve_bvp (1e-6, differences; its equilibria alone)", f"{scipy_fit:.1f} s",
         f"{scipy_fit / whole:.0f}"),
        ("fit with scatter estimated, both models and tables", f"{everything * 1e3:.0f} ms",
         f"{everything / whole:.0f}"),
    )  # fmt: skip
    figures = {
        "fit_s": whole, "model_s": kernel, "solve_bvp_fit_s": scipy_fit, "whole_fit_s": everything,
        "evaluations": counted.evaluations,
        "B_error": float(np.exp(theta[part.stiffness]) / B - 1.0),
        "solve_bvp_converged": sum(good for _, good in each) / len(each),
    }  # fmt: skip
    notes = (
        f"{counted.evaluations} evaluations; B found {100 * figures['B_error']:+.2f} % off",
        "the second row's ratio is what the fit costs over its own model evaluations",
    )
    return Report(
        (Table("Joint fit, 21 conditions", ("", "CPU time", "ratio"), rows),), figures, notes
    )


if __name__ == "__main__":
    print(measure().text())
