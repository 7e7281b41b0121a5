"""One fit to forces and shapes of all conditions, with noise that includes the set-ups' scatter.

Every configuration has its own B and EIBMs; what a set-up adds (EIBM, B, position, tilt of the
clamp, registration of the camera, zero of the load cell) is a random effect shared by the
conditions of a run, and its size is estimated from all configurations together (`noise`).
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from model.identification.gauss_newton import gauss_newton
from model.identification.likelihood.mixed_model import (
    Data,
    Solution,
    Spread,
    effects,
    estimate,
    freedom,
    spread,
    weigh,
)
from model.identification.observations import Observed
from model.identification.options import FitOptions
from model.identification.pooling import SCATTER, Pool
from model.identification.residual_vector import Predicted, System
from model.identification.starting_values import (
    MODES_LONG,
    MODES_SHORT,
    first_guess,
    layout,
    precision,
    rest_field,
)
from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field
from model.parameter import Parameter

ROUNDS = 8


@dataclass(frozen=True)
class Joint:
    """The joint fit: parameters of all configurations, their covariance, the scatter."""

    pool: Pool
    theta: FloatArray
    data: Data
    solution: Solution
    guess: FloatArray
    spread: Spread
    predictions: list[Predicted]
    rest_known: list[bool]

    def index(self, configuration: str) -> int:
        """Which of the systems."""
        names = [s.observed.sheet.configuration for s in self.pool.systems]
        return names.index(configuration)

    def scatter(self) -> dict[str, float]:
        """Standard deviations from one set-up to the next."""
        return dict(zip(SCATTER, np.exp(self.solution.log_sigma).tolist(), strict=False))

    def noise(self) -> dict[str, float]:
        """Standard deviations of force and shape modes beyond the readings' scatter."""
        values = np.exp(self.solution.log_sigma[len(SCATTER) :])
        return dict(zip(self.pool.mask_names, values.tolist(), strict=True))

    def parameter(
        self, n: int, value: float, direction: FloatArray, unit: str, more: float = 0.0
    ) -> Parameter:
        """A quantity whose derivatives by the parameters of system n are `direction`.

        `more` is a further standard uncertainty, of the systematic kind.
        """
        whole = np.zeros(len(self.theta))
        whole[self.pool.offsets[n] : self.pool.offsets[n + 1]] = direction
        variance = float(whole @ self.solution.covariance @ whole)
        degrees = freedom(self.solution, self.spread, whole)
        sigma = float(np.sqrt(variance + more**2))
        return Parameter(value, sigma, unit, degrees)

    def stiffness(self, n: int) -> Parameter:
        """B of a configuration."""
        B = float(np.exp(self.pool.part(self.theta, n)[0]))
        direction = np.zeros(self.pool.systems[n].layout.size)
        direction[0] = B
        return self.parameter(n, B, direction, "N m^2")

    def constant_eibm(self, n: int, voltage_V: float) -> Parameter:
        """(9): mean of Me over [0, l_hat], averaged over the positions.

        As there, Me is what bends the sheet away from the k0 that was stated, where one was.
        """
        return self._eibm(n, *self._mean(n, voltage_V, self._loaded(n, voltage_V)))

    def mean_eibm(self, n: int, voltage_V: float) -> Parameter:
        """Mean of Me over [0, l]."""
        return self._eibm(n, *self._mean(n, voltage_V, [self.pool.systems[n].length]))

    def mean_abs_eibm(self, n: int, voltages_V: list[float]) -> Parameter:
        """Mean of the absolute values of the constant EIBMs."""
        direction: FloatArray = np.zeros(self.pool.systems[n].layout.size)
        unsure = 0.0
        for voltage in voltages_V:
            row, doubt = self._mean(n, voltage, self._loaded(n, voltage))
            sign = float(np.sign(row @ self.pool.part(self.theta, n))) / len(voltages_V)
            direction, unsure = direction + sign * row, unsure + sign * doubt
        return self._eibm(n, direction, unsure)

    def _from_stated(self, n: int) -> bool:
        """Whether Me counts from the stated k0: not with one |EIBM|, which has to be odd in V."""
        layout = self.pool.systems[n].layout
        return self.rest_known[n] and layout.rest > 0 and not layout.symmetric

    def _loaded(self, n: int, voltage_V: float) -> list[float]:
        """l_hat of the positions at a voltage."""
        system = self.pool.systems[n]
        if not system.touching:
            return [system.length]
        found = system.solve(self.pool.part(self.theta, n))
        rows = [
            row
            for row, i in enumerate(system.touching)
            if system.observed.observations[i].voltage_V == voltage_V
        ]
        return [float(found.l_hat_m[row]) for row in rows] or [system.length]

    def _mean(self, n: int, voltage_V: float, lengths: list[float]) -> tuple[FloatArray, float]:
        """Row whose product with the parameters is a mean EIBM, and its systematic doubt."""
        system, theta = self.pool.systems[n], self.pool.part(self.theta, n)
        where, sign = system.layout.of(voltage_V)
        B, row, doubt = float(np.exp(theta[0])), np.zeros(system.layout.size), 0.0
        means = np.array([np.mean([f.mean(x) for x in lengths]) for f in system.basis])
        row[where] = sign * B * means[: system.layout.eibm]
        if self._from_stated(n):
            rest = system.layout.rest_slice
            row[rest] = B * means[: system.layout.rest]
            # a shape at 0 V other than stated: was the sheet bent, or was there a moment?
            doubt = float(row[rest] @ theta[rest]) / np.sqrt(12.0)
        return row, doubt

    def _eibm(self, n: int, row: FloatArray, doubt: float) -> Parameter:
        value = float(row @ self.pool.part(self.theta, n))
        direction = row.copy()
        direction[0] = value
        return self.parameter(n, value, direction, "N m", doubt)

    def along(self, n: int, voltage_V: float, s_m: FloatArray) -> tuple[FloatArray, FloatArray]:
        """(8): Me(s) and its standard uncertainty; from the stated k0, where one was."""
        system, theta = self.pool.systems[n], self.pool.part(self.theta, n)
        where, sign = system.layout.of(voltage_V)
        B = float(np.exp(theta[0]))
        terms = np.stack([f(s_m) for f in system.basis], axis=1)
        by = np.zeros((len(s_m), system.layout.size))
        by[:, where] = sign * B * terms[:, : system.layout.eibm]
        if self._from_stated(n):
            by[:, system.layout.rest_slice] = B * terms[:, : system.layout.rest]
        values = by @ theta
        by[:, 0] = values
        own = slice(int(self.pool.offsets[n]), int(self.pool.offsets[n + 1]))
        C = self.solution.covariance[own, own]
        variance: FloatArray = np.einsum("si,ij,sj->s", by, C, by)
        return values, np.sqrt(variance)

    def directions(self, n: int) -> dict[str, FloatArray]:
        """Derivatives by all parameters of what a bootstrap checks: B and the EIBMs."""
        system, start = self.pool.systems[n], int(self.pool.offsets[n])
        result = {"B": np.zeros(len(self.theta))}
        result["B"][start] = float(np.exp(self.theta[start]))
        for voltage in system.observed.voltages_V:
            own = slice(start, start + system.layout.size)
            row = np.zeros(len(self.theta))
            row[own], _ = self._mean(n, voltage, self._loaded(n, voltage))
            row[start] = row @ self.theta
            result[f"EIBM at {voltage:+g} V"] = row
        return result

    def bootstrap(self, count: int, seed: int) -> FloatArray:
        """Deviations of the parameters (count, p) in sessions simulated with the noise found.

        Linear in the parameters; the scatter is estimated anew in each.
        """
        random = np.random.default_rng(seed)
        factor = np.linalg.cholesky(np.linalg.inv(self.solution.weights))
        result = np.zeros((count, len(self.theta)))
        for b in range(count):
            y = (factor @ random.standard_normal((*self.data.y.shape, 1)))[:, :, 0]
            y[np.all(self.data.X == 0.0, axis=2)] = 0.0
            data = replace(self.data, y=y, away=np.zeros_like(self.data.away))
            result[b] = estimate(data, self.guess, self.solution.log_sigma).beta
        return result

    def rest_sigma(self, n: int, s_m: FloatArray) -> FloatArray:
        """Standard uncertainty of k0 at s."""
        system = self.pool.systems[n]
        where = system.layout.rest_slice
        by = np.stack([f(s_m) for f in system.basis[: system.layout.rest]], axis=1)
        start = int(self.pool.offsets[n])
        own = slice(start + where.start, start + where.stop)
        C = self.solution.covariance[own, own]
        variance: FloatArray = np.einsum("si,ij,sj->s", by, C, by)
        return np.sqrt(variance)

    def rest(self, n: int) -> Field:
        """k0 as the shapes have it."""
        system, theta = self.pool.systems[n], self.pool.part(self.theta, n)
        return Field(system.breaks, system.curvature_row(theta, 0.0))


def joint_fit(observed: list[Observed], options: FitOptions) -> Joint:
    """Fit all configurations together."""
    systems, known, priors, theta = [], [], [], []
    for one in observed:
        rest, rest_known = rest_field(one.sheet, one)
        rest_known = rest_known and not options.measured_curvature
        long = one.sheet.free_length_m > 0.4 * one.sheet.arc_radius_m
        system = System(
            one, rest, layout(one, options, rest_known), MODES_LONG if long else MODES_SHORT
        )
        prior = precision(system, options, rest_known)
        start = first_guess(system)
        systems.append(system)
        known.append(rest_known)
        priors.append(prior)
        theta.append(gauss_newton(system, start, precision=prior)[0])
    pool = Pool(systems)
    return _refine(pool, np.concatenate(theta), np.concatenate(priors), known)


def _refine(pool: Pool, theta: FloatArray, prior: FloatArray, known: list[bool]) -> Joint:
    """Estimate scatter, parameters, and what each set-up added, in turn until they stand."""
    predictions = [s.predict(pool.part(theta, n)) for n, s in enumerate(pool.systems)]
    guess = pool.guess(predictions)
    data = pool.data(predictions, prior, _away(pool, theta))
    solution = estimate(data, guess)
    for turn in range(ROUNDS):
        theta = theta + _bounded(solution.beta)
        added = effects(data, solution)
        parts = zip(pool.systems, pool.shifts(added), strict=True)
        predictions = [s.predict(pool.part(theta, n), u) for n, (s, u) in enumerate(parts)]
        data = pool.data(predictions, prior, _away(pool, theta), added)
        if turn < ROUNDS - 1:
            solution = estimate(data, guess, solution.log_sigma)
        else:
            solution = weigh(data, solution.log_sigma)
        moved = np.abs(solution.beta) / np.sqrt(np.maximum(np.diag(solution.covariance), 1e-300))
        if np.max(moved) < 1e-2:
            break
    if not np.all(np.isfinite(theta)) or not np.all(np.isfinite(solution.covariance)):
        raise ModelError("the fit did not settle: the data contradict the model too much")
    known_spread = spread(data, solution, guess)
    return Joint(pool, theta, data, solution, guess, known_spread, predictions, known)


def _away(pool: Pool, theta: FloatArray) -> FloatArray:
    """Distance from the priors' means, which are 0; ln B has none."""
    away = theta.copy()
    away[pool.offsets[:-1]] = 0.0
    return away


def _bounded(step: FloatArray) -> FloatArray:
    """No step leaps where the linearisation means nothing."""
    return step / max(1.0, float(np.max(np.abs(step))) / 60.0)
