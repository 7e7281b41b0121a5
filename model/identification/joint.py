"""One fit to forces and shapes of all conditions, with noise that includes the set-ups' scatter.

Every configuration has its own B and EIBMs; what a set-up adds (EIBM, B, position, tilt of the
clamp, registration of the camera, zero of the load cell) is a random effect shared by the
conditions of a run, and its size is estimated from all configurations together. This is the
likelihood of `diagnose` without effects, of what does not depend on time.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.identification.base_model import (
    REST_PER_M,
    BaseOptions,
    bases_of,
    weighs,
    with_shared_width,
)
from model.identification.data.data_vector import data_vector_of, means_of
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.gauss_newton import least_squares
from model.identification.likelihood.linearisation import BaseParameters, Bases
from model.identification.likelihood.mixed_model import UnsettledError, estimate
from model.identification.likelihood.mixed_model_fit import (
    FitProblem,
    MixedModelFit,
    fit_at_set_ups,
)
from model.identification.likelihood.noise.row_noise import noise_of
from model.identification.likelihood.random_effects import WIDE
from model.identification.observations import Observed
from model.identification.options import FitOptions
from model.identification.starting_values import (
    Earlier,
    are_known,
    rest_field,
    start,
    with_measured_eibm,
)
from model.measurements import FloatArray, Measurements, ModelError
from model.mechanics.field import Field, legendre_field
from model.parameter import Parameter

FAR_M = 1e-3  # of a curve, RMS, from which on a fit begins anew from the measured curvatures


@dataclass(frozen=True)
class Joint:
    """The joint fit: parameters of all configurations, their covariance, the scatter."""

    fitted: MixedModelFit
    rest_known: list[bool]
    loaded_m: list[FloatArray]  # (K,) l_hat of the conditions of each configuration, nominal

    @property
    def forward(self) -> ForwardModel:
        """Return the forward model, which predicts the data."""
        return self.fitted.problem.forward

    def scatter(self) -> dict[str, float]:
        """Return standard deviations from one set-up to the next, of what these data know of."""
        names, groups = self.fitted.problem.noise.random_effects, self.fitted.linear.data.groups
        sizes = np.exp(self.fitted.solution.log_sigma).tolist()
        return {
            name: size for name, size, Z in zip(names, sizes, groups, strict=False) if np.any(Z)
        }

    def noise(self) -> dict[str, float]:
        """Return the standard deviations of force and shape modes."""
        noise = self.fitted.problem.noise
        values = np.exp(self.fitted.solution.log_sigma[len(noise.random_effects) :])
        return dict(zip(noise.names, values.tolist(), strict=True))

    def stiffness(self, n: int) -> Parameter:
        """B of a configuration; as uncertain as it is large where nothing was weighed."""
        found = replace(self.fitted.parameter(self._B(n), self._by_B(n), "N m^2"), low=0.0)
        return found if weighs(self.forward.data_vectors[n]) else replace(found, sigma=found.value)

    def constant_eibm(self, n: int, voltage_V: float) -> Parameter:
        """(9): mean of Me over [0, l_hat], averaged over the positions.

        As there, Me is what bends the sheet away from the k0 that was stated, where one was.
        """
        return self._eibm(n, *self._mean(n, voltage_V, self._loaded(n, voltage_V)))

    def mean_eibm(self, n: int, voltage_V: float) -> Parameter:
        """Mean of Me over [0, l]."""
        return self._eibm(
            n, *self._mean(n, voltage_V, [self.forward.configuration_models[n].length])
        )

    def mean_abs_eibm(self, n: int, voltages_V: list[float]) -> Parameter:
        """Mean of the absolute values of the constant EIBMs."""
        direction: FloatArray = np.zeros(len(self.fitted.theta))
        unsure = 0.0
        for voltage in voltages_V:
            row, doubt = self._mean(n, voltage, self._loaded(n, voltage))
            sign = float(np.sign(row @ self.fitted.theta)) / len(voltages_V)
            direction, unsure = direction + sign * row, unsure + sign * doubt
        return replace(self._eibm(n, direction, unsure), low=0.0)

    def along(self, n: int, voltage_V: float, s_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(8): Me(s) and its standard uncertainty; from the stated k0, where one was."""
        by = self._by_terms(n, voltage_V, np.stack([f(s_m) for f in self._basis(n)], axis=1))
        values = by @ self.fitted.theta
        by[:, self._part(n).stiffness] = values
        return values, self._sigma(by)

    def terms(self, n: int, voltage_V: float) -> FloatArray:
        """Return Me along the sheet as coefficients of Legendre polynomials."""
        return self._by_terms(n, voltage_V, np.eye(len(self._basis(n)))) @ self.fitted.theta

    def directions(self, n: int) -> dict[str, FloatArray]:
        """Return derivatives of B and the EIBMs, which a bootstrap checks, by all parameters."""
        result = {"B": self._by_B(n)}
        for voltage in self._part(n).eibm:
            row, _ = self._mean(n, voltage, self._loaded(n, voltage))
            row[self._part(n).stiffness] = row @ self.fitted.theta
            result[f"EIBM at {voltage:+g} V"] = row
        return result

    def own_parameters(self, n: int) -> list[int]:
        """Return where a configuration's parameters stand in the vector of all."""
        part = self._part(n)
        terms = range(len(part.forms))
        eibm = {first + i for first, _ in part.eibm.values() for i in terms}
        return sorted({part.stiffness, *eibm, *part.rest})

    def bootstrap(self, count: int, seed: int) -> FloatArray:
        """Deviations of the parameters (count, p) in sessions simulated with the noise found.

        Linear in the parameters, which scatter as their priors say; the scatter of set-ups is
        estimated anew in each.
        """
        random = np.random.default_rng(seed)
        linear, solution = self.fitted.linear.data, self.fitted.solution
        factor = np.linalg.cholesky(np.linalg.inv(solution.weights))
        empty = self.forward.row_index.pad(np.ones(self.forward.row_index.size)) == 0.0
        result = np.zeros((count, len(self.fitted.theta)))
        for b in range(count):
            y = (factor @ random.standard_normal((*linear.y.shape, 1)))[:, :, 0]
            y[empty] = 0.0
            away = random.standard_normal(len(linear.away)) / np.sqrt(linear.precision)
            data = replace(linear, y=y, away=away)
            result[b] = estimate(data, self.fitted.problem.guess, solution.log_sigma).beta
        return result

    def rest_sigma(self, n: int, s_m: FloatArray) -> FloatArray:
        """Return the standard uncertainty of k0 at s."""
        by = np.zeros((len(s_m), len(self.fitted.theta)))
        for i, f in zip(self._part(n).rest, self._basis(n), strict=False):
            by[:, i] = f(s_m)
        return self._sigma(by)

    def rest(self, n: int) -> Field:
        """k0 as the shapes have it."""
        field = self.forward.configuration_models[n].rest
        for i, f in zip(self._part(n).rest, self._basis(n), strict=False):
            field = field + f * float(self.fitted.theta[i])
        return field

    # -- where a later fit begins

    def carried(self) -> Earlier:
        """Return the parameters of each configuration."""
        parts = self.fitted.problem.bases.parts
        names = self.forward.names
        return {name: (part, self.fitted.theta) for name, part in zip(names, parts, strict=True)}

    def noise_found(self) -> dict[str, float]:
        """Return the logarithms of all standard deviations: scatters, then noises."""
        return self.fitted.noise_found()

    # -- rows whose products with the parameters are quantities

    def _part(self, n: int) -> BaseParameters:
        return self.fitted.problem.bases.parts[n]

    def _B(self, n: int) -> float:
        return float(np.exp(self.fitted.theta[self._part(n).stiffness]))

    def _by_B(self, n: int) -> FloatArray:
        row = np.zeros(len(self.fitted.theta))
        row[self._part(n).stiffness] = self._B(n)
        return row

    def _basis(self, n: int) -> list[Field]:
        part, length = self._part(n), self.forward.configuration_models[n].length
        return [legendre_field(i, length) for i in range(max(len(part.forms), len(part.rest)))]

    def _sigma(self, by: FloatArray) -> FloatArray:
        variance: FloatArray = np.einsum("si,ij,sj->s", by, self.fitted.covariance, by)
        return np.sqrt(variance)

    def rest_counts(self, n: int) -> bool:
        """Whether Me counts from the stated k0: not with one |EIBM|, which has to be odd in V."""
        part = self._part(n)
        one_size = len({place for place, _ in part.eibm.values()}) < len(part.eibm)
        return self.rest_known[n] and bool(part.rest) and not one_size

    def _loaded(self, n: int, voltage_V: float) -> list[float]:
        """l_hat of the positions at a voltage, in nominal set-ups."""
        configuration_model = self.forward.configuration_models[n]
        here = np.isfinite(configuration_model.stated_m) & (
            configuration_model.voltage_V == voltage_V
        )
        return self.loaded_m[n][here].tolist() or [configuration_model.length]

    def _by_terms(self, n: int, voltage_V: float, values: FloatArray) -> FloatArray:
        """Rows (m, p) whose products with the parameters are Me, by the basis (m, terms)."""
        part, B = self._part(n), self._B(n)
        (first, sign), count = part.eibm[voltage_V], len(part.forms)
        rows = np.zeros((len(values), len(self.fitted.theta)))
        rows[:, first : first + count] = sign * B * values[:, :count]
        if self.rest_counts(n):
            rows[:, list(part.rest)] = B * values[:, : len(part.rest)]
        return rows

    def _mean(self, n: int, voltage_V: float, lengths: list[float]) -> tuple[FloatArray, float]:
        """Row whose product with the parameters is a mean EIBM, and its systematic doubt."""
        means = np.array([[np.mean([f.mean(x) for x in lengths]) for f in self._basis(n)]])
        row, doubt = self._by_terms(n, voltage_V, means)[0], 0.0
        if self.rest_counts(n):
            # a shape at 0 V other than stated: was the sheet bent, or was there a moment?
            rest = list(self._part(n).rest)
            doubt = float(row[rest] @ self.fitted.theta[rest]) / np.sqrt(12.0)
        return row, doubt

    def _eibm(self, n: int, row: FloatArray, doubt: float) -> Parameter:
        value = float(row @ self.fitted.theta)
        direction = row.copy()
        direction[self._part(n).stiffness] = value
        return self.fitted.parameter(value, direction, "N m", doubt)


def joint_fit(
    measurements: Measurements,
    observed: Sequence[Observed],
    options: FitOptions,
    earlier: Joint | None = None,
) -> Joint:
    """Fit all configurations that were observed together.

    An `earlier` fit with the same options, of somewhat fewer or more data, is where this one
    begins: it is several times as quick, and its outcome is the same.
    """
    rests, known = [], []
    for one in observed:
        rest, stated = rest_field(one.sheet, one)
        rests.append(rest)
        known.append(stated and not options.measured_curvature)
    data_vectors = [
        means_of(data_vector_of(measurements, one.sheet.configuration)) for one in observed
    ]
    forward = ForwardModel(data_vectors, rests)
    base = BaseOptions(
        symmetric=options.symmetric,
        along=options.eibm_form == "along",
        rest_sigma_per_m=(
            REST_PER_M / forward.scale.length
            if options.initial_curvature_sigma_per_m is None
            else options.initial_curvature_sigma_per_m
        ),
        stiffness_Nm2=options.stiffness_Nm2,
    )
    bases = with_shared_width(bases_of(forward, known, base))
    problem = FitProblem.of(forward, bases, noise_of(forward, WIDE))
    fitted = None if earlier is None else _fitted_from(earlier, problem, observed, known)
    if fitted is None:
        try:
            begin = _begin(observed, forward, bases, known)
            fitted = fit_at_set_ups(problem, begin)
        except (UnsettledError, np.linalg.LinAlgError):
            raise ModelError(_no_fit(forward.names)) from None
    loaded = [
        np.minimum(
            configuration_model.solve(bases.beam(forward, n, fitted.theta)).contact.s_hat_m,
            configuration_model.length,
        )
        for n, configuration_model in enumerate(forward.configuration_models)
    ]
    return Joint(fitted, known, loaded)


def _begin(
    observed: Sequence[Observed], forward: ForwardModel, bases: Bases, known: Sequence[bool]
) -> FloatArray:
    """Return base parameters near the data, from an even EIBM or from the measured curvatures."""
    found = least_squares(forward, bases, start(observed, forward, bases, known))
    is_even = all(len(part.forms) == 1 for part in bases.parts)
    far_m = FAR_M * forward.scale.length
    if is_even or _curves_off_m(forward, bases, found) < far_m:
        return found
    try:
        other = least_squares(forward, bases, with_measured_eibm(observed, forward, bases, found))
        closer = _curves_off_m(forward, bases, other) < _curves_off_m(forward, bases, found)
    except (ModelError, np.linalg.LinAlgError):
        return found
    return other if closer else found


def _curves_off_m(forward: ForwardModel, bases: Bases, theta: FloatArray) -> float:
    """Return how far the measured curves are off, root mean square of the worst; 0 without any."""
    worst_m = 0.0
    for c, one in enumerate(forward.configuration_models):
        modes = one.solve(bases.beam(forward, c, theta)).modes_m[one.has_curve]
        if len(modes):  # of unit mean square along the curve
            worst_m = max(worst_m, float(np.sqrt(np.max(np.sum(modes**2, axis=1)))))
    return worst_m


def _no_fit(names: Sequence[str]) -> str:
    quoted = " and ".join(f"'{name}'" for name in names)
    return (
        f"no fit of {quoted} was found: the model stays far from the measured forces and curves;"
        " check their units and signs (labrig diagnose names what contradicts)"
    )


def _fitted_from(
    earlier: Joint, problem: FitProblem, observed: Sequence[Observed], known: Sequence[bool]
) -> MixedModelFit | None:
    """Fit from where an earlier fit ended; None where that is too far away."""
    forward, bases = problem.forward, problem.bases
    before = earlier.carried()
    theta = start(observed, forward, bases, known, before)
    if not are_known(forward.names, bases, before):
        theta = least_squares(forward, bases, theta)
    try:
        return fit_at_set_ups(problem, theta, problem.noise_from(earlier.noise_found()))
    except ModelError:
        return None
