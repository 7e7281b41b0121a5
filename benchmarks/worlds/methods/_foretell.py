"""What methods that write no model foretell, from what they fitted.

Effects that a method names become a model: the catalogue's forms at their word, their sizes fitted
again with the base model. What a method adds to forces and curves along the arc, whatever it is,
is interpolated between the positions by the method's own process, and added to the base model.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from numpy.polynomial import legendre

from benchmarks.hidden_effects.baseline_gp import guess
from benchmarks.hidden_effects.predicted import read_back
from benchmarks.worlds.methods._contract import Foretell
from model import predict
from model.discrepancy.prepare import DiagnoseOptions
from model.discrepancy.search.evidence import Candidate, Projected, score, unit_values
from model.discrepancy.verdict.written_model.fitted_model import sheet_model
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.identification.likelihood.model_state import Found
from model.measurements import FloatArray, Measurements, ModelError
from model.sheet.prediction import Prediction

Shapes = Mapping[str, tuple[float, float]]  # by kind of row: length (m) and share of noise


def of_model(fitted: MixedModelFit, measurements: Measurements) -> Foretell:
    """Return what a fitted model says, written to a file and read back."""
    return partial(predict, read_back(sheet_model(fitted, measurements, DiagnoseOptions())))


def of_effects(
    base: MixedModelFit, chosen: Sequence[Candidate], measurements: Measurements
) -> Foretell:
    """Return what the base model says with these effects; alone where that does not settle."""
    found = tuple(_found(base, *each) for each in zip(chosen, _sizes(base, chosen), strict=True))
    fitted = base
    with suppress(ModelError, np.linalg.LinAlgError):
        fitted = fit_mixed_model(base.problem, base.theta, found) if found else base
    return of_model(fitted, measurements)


def likeliest_shapes(
    base: MixedModelFit, pool: Sequence[Candidate], names: Sequence[str]
) -> list[Candidate]:
    """Return the shape of each named effect that has the most evidence."""
    forward = base.problem.forward
    projected = Projected.of(forward, base.linear, base.solution)
    return [
        max(
            (c for c in pool if c.name == name),
            key=lambda c: score(forward, projected, c).log_bayes,
        )
        for name in names
    ]


def _sizes(base: MixedModelFit, chosen: Sequence[Candidate]) -> list[float]:
    """Return the multiple of each one's own size that explains most, all of them together."""
    if not chosen:
        return []
    forward = base.problem.forward
    columns = np.stack([c.columns[:, 0] for c in chosen], axis=1)
    A, b = Projected.of(forward, base.linear, base.solution).normal(forward, columns)
    found: list[float] = np.linalg.lstsq(A, b, rcond=1e-10)[0].tolist()
    return found


def _found(base: MixedModelFit, one: Candidate, size: float) -> Found:
    assert one.effect is not None
    effect, amplitude = replace(one.effect, form_error_along=()), one.effect.amplitude
    values = unit_values(effect, one.values, size)
    if not amplitude.starting_values:
        values[amplitude.name] = float(
            np.clip(values[amplitude.name], amplitude.low, amplitude.high)
        )
    own = {name: dict(values) for name in base.problem.forward.names}
    return Found(effect=effect, values=own, width=max(3.0, 2.0 * abs(size)))


# ------------------------------------------------------------------------------ along the arc


@dataclass(frozen=True)
class _Added:
    """What is added at the positions of one voltage, (positions,) and (modes, positions)."""

    at_m: FloatArray
    values: FloatArray
    shape: tuple[float, float]

    def at(self, position_m: float) -> float:
        """Return what is added there."""
        return float(guess(self.at_m, self.values, np.array([position_m]), *self.shape)[0])


def along_arc(
    base: MixedModelFit, added: FloatArray, shapes: Shapes, measurements: Measurements
) -> Foretell:
    """Return the base model with what is added (N,) to the means of forces and curves' modes.

    Between voltages it is in proportion, as the EIBM is.
    """
    forward = base.problem.forward
    known: dict[tuple[str, int], dict[float, _Added]] = {}  # by configuration; force, or a mode
    ends_m = {}
    for c, (name, block, configuration_model) in enumerate(
        zip(forward.names, forward.row_index.blocks, forward.configuration_models, strict=True)
    ):
        ends_m[name] = float(np.max(configuration_model.curve_s))
        cells = [
            ("force", 0, int(k), int(row))
            for row, k in zip(block.trend_rows[block.is_mean], block.trend_of[block.is_mean],
                              strict=True)
        ]  # fmt: skip
        cells += [
            ("curve", m, int(k), int(row))
            for k in np.flatnonzero(configuration_model.has_curve)
            for m, row in enumerate(block.mode_rows[k])
        ]  # fmt: skip
        for volts in np.unique(configuration_model.voltage_V).tolist():
            own = [
                x for x in cells
                if configuration_model.voltage_V[x[2]] == volts
                and np.isfinite(configuration_model.stated_m[x[2]])
            ]  # fmt: skip
            for kind, m in sorted({x[:2] for x in own}):
                mine = [x for x in own if x[:2] == (kind, m)]
                one = _Added(
                    configuration_model.stated_m[[x[2] for x in mine]], added[[x[3] for x in mine]],
                    shapes[f"{kind} {c} {m}"],
                )  # fmt: skip
                known.setdefault((name, -1 if kind == "force" else m), {})[volts] = one
    plain = of_model(base, measurements)

    def foretell(configuration: str, position_m: float, voltage_V: float) -> Prediction:
        said = plain(configuration, position_m, voltage_V)
        if not said.reachable:
            return said
        more = {
            m: _between({v: a.at(position_m) for v, a in own.items()}, voltage_V)
            for (name, m), own in known.items() if name == configuration
        }  # fmt: skip
        modes = np.array([more[m] for m in sorted(more) if m >= 0])
        return _moved(said, more.get(-1, 0.0), modes, ends_m[configuration])

    return foretell


def _between(values: Mapping[float, float], voltage_V: float) -> float:
    volts = sorted(values)
    return float(np.interp(voltage_V, volts, [values[v] for v in volts]))


def _moved(said: Prediction, force_N: float, modes_m: FloatArray, end_m: float) -> Prediction:
    """Return a prediction with more force, and a curve moved along its normal by its modes."""
    if not len(modes_m):
        return replace(said, F_N=said.F_N + force_N)
    t = np.minimum(2.0 * said.s_m / end_m - 1.0, 1.0)
    count = len(modes_m)
    off = legendre.legvander(t, count - 1) * np.sqrt(2.0 * np.arange(count) + 1.0) @ modes_m
    dx, dy = np.gradient(said.x_m), np.gradient(said.y_m)
    size = np.hypot(dx, dy)
    return replace(
        said, F_N=said.F_N + force_N, x_m=said.x_m - off * dy / size, y_m=said.y_m + off * dx / size
    )
