"""Fit the base model quickly to mean forces and curves, with one more value free.

It has no noise model: residuals are judged against a fixed tolerance, which is about what noise and
scatter between set-ups leave. That is enough to tell a wrong unit from a right one, and costs a
few solutions of the model.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.data_checks.contract import Change
from model.identification.base_model import BaseOptions, bases_of, usual_stiffness
from model.identification.data.data_vector import data_vector_of, means_of
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.gauss_newton import (
    ENOUGH,
    least_squares,
    weighted_squares,
)
from model.identification.likelihood.linearisation import Bases, priors_of, sensitivities
from model.identification.observations import observe
from model.identification.starting_values import rest_field
from model.measurements import (
    Condition,
    Curve,
    FloatArray,
    Measurements,
    ModelError,
    Reading,
    scale_of_measurements,
)

CURVE_POINTS = 40
LEAST_FORCE_N, FORCE_SHARE = 3e-5, 0.03  # tolerance of a mean force: the larger of both
CURVE_SHARE = 1e-3  # tolerance of a curve, of the sheet's length
ROUNDS, SHORTEST = 8, 0.1  # of a continuous datum's fit, and share of a step that is still tried
SETTLED = 1e-3  # relative fall of the squares at which it ends
# A change that mends the data leaves less than a tenth of the squares that they have as stated. So
# it is given up where it has more than so many times these after a few steps; or where a straight
# line leaves more than such a share, from the second one on
FAR_WORSE, HARDLY_LESS = 10.0, 0.5


@dataclass(frozen=True)
class Tolerances:
    """What is no misfit, by configuration: of a mean force, N, and of a curve's modes, m."""

    force_N: dict[str, float]
    curve_m: dict[str, float]

    @staticmethod
    def of(measurements: Measurements) -> Tolerances:
        """From how far the forces of a configuration spread, and how long its sheet is."""
        force_N, curve_m = dict[str, float](), dict[str, float]()
        least_N = LEAST_FORCE_N * scale_of_measurements(measurements).force
        for name, sheet in measurements.sheets.items():
            own = [c for c in measurements.conditions if c.configuration == name]
            means = [c.readings[0].force_N for c in own if c.position_m is not None and c.readings]
            spread = float(np.std(means)) if means else 0.0
            force_N[name] = max(least_N, FORCE_SHARE * spread)
            curve_m[name] = CURVE_SHARE * (sheet.free_length_m + sheet.elongation_m)
        return Tolerances(force_N, curve_m)


@dataclass(frozen=True, kw_only=True)
class QuickFit:
    """The base model at its best."""

    forward: ForwardModel
    bases: Bases
    theta: FloatArray
    residual: FloatArray  # (N,) of all rows, N and m
    weights: FloatArray  # (N,) one over the tolerance; 0: neither a mean force nor a curve
    value: float  # of the datum that was changed
    sigma: float = np.nan

    @property
    def squares(self) -> float:
        """Of all residuals, in units of the tolerance; a curve counts as one number."""
        return float(np.sum((self.residual * self.weights) ** 2))

    @property
    def misfit(self) -> float:
        """Mean square of a condition's force and curve, in units of the tolerance."""
        return self.squares / max(1, self.count)

    @property
    def force_rms_N(self) -> float:
        """Root mean square residual of the mean forces."""
        parts = self.forward.row_index.blocks
        rows = np.concatenate([block.trend_rows[block.is_mean] for block in parts])
        return float(np.sqrt(np.mean(self.residual[rows] ** 2))) if len(rows) else np.nan

    @property
    def curve_rms_m(self) -> float:
        """Root mean square distance of the curves."""
        pairs = zip(self.forward.row_index.blocks, self.forward.configuration_models, strict=True)
        rows = np.concatenate(
            [block.mode_rows[configuration_model.has_curve] for block, configuration_model in pairs]
        )
        off = np.sum(self.residual[rows] ** 2, axis=1)
        return float(np.sqrt(np.mean(off))) if len(rows) else np.nan

    @property
    def count(self) -> int:
        """Number of forces and curves."""
        forces = sum(
            int(np.count_nonzero(block.is_mean)) for block in self.forward.row_index.blocks
        )
        curves = sum(
            int(np.count_nonzero(configuration_model.has_curve))
            for configuration_model in self.forward.configuration_models
        )
        return forces + curves


def bare(measurements: Measurements) -> Measurements:
    """Return mean forces and thinned mean curves alone."""
    conditions = [_bare(c) for c in measurements.conditions]
    return replace(measurements, conditions=tuple(conditions), series=())


def _bare(condition: Condition) -> Condition:
    used = condition.used()
    forces = [r.force_N for r in used]
    mean = (Reading(index=0, kind="kept", force_N=float(np.mean(forces))),) if forces else ()
    curve = condition.curve
    own = [r.curve for r in condition.readings if r.valid and r.curve is not None]
    if curve is None and own and len({len(c.s_m) for c in own}) == 1:
        s, x, y = (np.mean([getattr(c, a) for c in own], axis=0) for a in ("s_m", "x_m", "y_m"))
        curve = Curve(s_m=s, x_m=x, y_m=y)
    if curve is not None and len(curve.s_m) > CURVE_POINTS:
        keep = np.unique(np.linspace(0, len(curve.s_m) - 1, CURVE_POINTS).round().astype(int))
        curve = Curve(s_m=curve.s_m[keep], x_m=curve.x_m[keep], y_m=curve.y_m[keep])
    return replace(condition, readings=mean, curve=curve, contact=None)


@dataclass(frozen=True)
class _Posed:
    """The base model of some data, ready to be fitted."""

    forward: ForwardModel
    bases: Bases
    weights: FloatArray

    @staticmethod
    def of(measurements: Measurements, tolerances: Tolerances, *, along: bool = False) -> _Posed:
        """Of bare measurements; a `ModelError` where no configuration has a force.

        `along`: the EIBM may change along the sheet.
        """
        data_vectors, rests, known = [], [], []
        for name in measurements.sheets:
            own = [c for c in measurements.conditions if c.configuration == name]
            if not any(c.readings and c.position_m is not None for c in own):
                continue
            observed = observe(measurements, name)
            rest, stated = rest_field(observed.sheet, observed)
            data_vectors.append(means_of(data_vector_of(measurements, name)))
            rests.append(rest)
            known.append(stated)
        if not data_vectors:
            raise ModelError("no configuration has a force")
        forward = ForwardModel(data_vectors, rests)
        return _Posed(
            forward,
            bases_of(forward, known, BaseOptions(along=along)),
            _weights(forward, tolerances),
        )

    def start(self) -> FloatArray:
        """Return base parameters without EIBM."""
        theta = np.zeros(self.bases.size)
        for configuration_model, part in zip(
            self.forward.configuration_models, self.bases.parts, strict=True
        ):
            for i, (mean, _) in part.prior.items():
                theta[i] = mean
            theta[part.stiffness] = np.log(usual_stiffness(configuration_model.sheet))
        return theta

    def at(self, theta: FloatArray, value: float) -> QuickFit:
        """Return what is left at base parameters, at a value of the datum that is changed."""
        _, residual, _ = sensitivities(self.forward, self.bases, theta)
        return QuickFit(
            forward=self.forward, bases=self.bases, theta=theta, residual=residual,
            weights=self.weights, value=value,
        )  # fmt: skip


def _weights(forward: ForwardModel, tolerances: Tolerances) -> FloatArray:
    weights = np.zeros(forward.row_index.size)
    for name, block, configuration_model in zip(
        forward.names, forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        weights[block.trend_rows[block.is_mean]] = 1.0 / tolerances.force_N[name]
        weights[block.mode_rows[configuration_model.has_curve]] = 1.0 / tolerances.curve_m[name]
    return weights


def quick_fit(
    measurements: Measurements,
    tolerances: Tolerances,
    value: float = np.nan,
    enough: float = ENOUGH,
    stated: QuickFit | None = None,
    *,
    along: bool = False,
) -> QuickFit | None:
    """Return the fit of bare measurements; None where the model has no answer.

    `enough` is the share of the squares that a step may take for the fit to be settled. A fit that
    after a few steps is far worse than the one of the data as `stated` is left where it is.
    `along`: the EIBM may change along the sheet.
    """
    worthless = np.inf
    if stated is not None:
        worthless = FAR_WORSE * weighted_squares(stated.forward, stated.residual)
    try:
        with np.errstate(all="ignore"):  # data that fit nothing lead anywhere
            posed = _Posed.of(measurements, tolerances, along=along)
            theta = least_squares(posed.forward, posed.bases, posed.start(), enough, worthless)
            found = posed.at(theta, value)
    except (ModelError, np.linalg.LinAlgError):
        return None
    return found if np.isfinite(found.squares) else None


def fit_with(
    measurements: Measurements,
    tolerances: Tolerances,
    change: Change,
    begin: QuickFit | None,
    stated: QuickFit | None = None,
) -> QuickFit | None:
    """Return the fit of the base parameters together with one continuous datum, from `begin` on.

    One that promises hardly less than the fit of the data as `stated` ends where it is.
    """
    worthless = np.inf if stated is None else HARDLY_LESS * stated.squares

    def posed(value: float) -> _Posed:
        return _Posed.of(change.apply(measurements, value), tolerances)

    best = begin
    if best is None:
        return None
    with np.errstate(all="ignore"):
        for number in range(ROUNDS):
            try:
                direction, sigma, promised = _direction(best, posed, change.step)
            except (ModelError, np.linalg.LinAlgError):
                break
            best = replace(best, sigma=sigma)
            if number > 0 and promised > worthless:
                break
            further = _further(best, direction, posed, change.bounds)
            if further is None:
                break
            settled = best.squares - further.squares < SETTLED * best.squares
            best = replace(further, sigma=sigma)
            if settled:
                break
    return best


def _direction(
    at: QuickFit, posed: Callable[[float], _Posed], step: float
) -> tuple[FloatArray, float, float]:
    """Return the step of base parameters and datum, the datum last.

    And the datum's uncertainty, and the squares that the step would leave by a straight line.
    """
    _, residual, columns = sensitivities(at.forward, at.bases, at.theta)
    beside = posed(at.value + step).at(at.theta, at.value + step)
    if len(beside.residual) != len(residual):
        raise ModelError("the change adds or removes data")
    X = np.column_stack([columns, -(beside.residual - residual) / step]) * at.weights[:, None]
    mean, width = priors_of(at.bases)
    precision = np.append(width**-2.0, 0.0)
    A = X.T @ X + np.diag(precision)
    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-300))
    inverse = np.linalg.pinv(A * scale * scale[:, None], rcond=1e-12, hermitian=True)
    inverse = inverse * scale * scale[:, None]
    away = np.append(at.theta - mean, 0.0)
    found = inverse @ (X.T @ (residual * at.weights) - precision * away)
    sigma = float(np.sqrt(max(inverse[-1, -1], 0.0) * max(at.misfit, 0.1)))
    promised = float(np.sum((residual * at.weights - X @ found) ** 2))
    return np.asarray(found), sigma, promised


def _further(
    at: QuickFit,
    direction: FloatArray,
    posed: Callable[[float], _Posed],
    bounds: tuple[float, float],
) -> QuickFit | None:
    """Return the fit after as much of a step as helps, or None."""
    share = 1.0
    while share >= SHORTEST:
        value = float(np.clip(at.value + share * direction[-1], *bounds))
        try:
            other = posed(value).at(at.theta + share * direction[:-1], value)
            if other.squares < at.squares:
                return other
        except ModelError:
            pass
        share *= 0.4
    return None
