"""The scatter between set-ups is found from the misfit, and uncertainties follow it."""

from __future__ import annotations

import numpy as np
import pytest

from model.noise import Data, deviance, effects, estimate, freedom, spread, weigh


def made(random, runs=40, u=0.3, tau=0.1):
    """y = X beta + Z u + e with one random effect for each run of five numbers."""
    X = random.standard_normal((runs, 5, 2))
    Z = np.ones((runs, 5, 1)) + 0.2 * random.standard_normal((runs, 5, 1))
    shift = u * random.standard_normal((runs, 1))
    y = X @ np.array([2.0, -1.0]) + Z[:, :, 0] * shift + tau * random.standard_normal((runs, 5))
    data = Data(y, X, [Z], [np.ones((runs, 5))], np.full((runs, 5), 1e-6), np.zeros(2), np.zeros(2))
    return data, shift


def test_the_sizes_of_scatter_and_noise_are_recovered():
    found = [
        np.exp(estimate(made(np.random.default_rng(s))[0], np.log([0.1, 0.1])).log_sigma)
        for s in range(8)
    ]
    np.testing.assert_allclose(np.mean(found, axis=0), [0.3, 0.1], rtol=0.08)


def test_the_gradient_of_the_likelihood_is_exact():
    data, _ = made(np.random.default_rng(0), runs=6)
    at, guess = np.log([0.2, 0.15]), np.log([0.1, 0.3])
    _, gradient = deviance(data, at, guess)
    for k in range(2):
        h = np.eye(2)[k] * 1e-5
        slope = (deviance(data, at + h, guess)[0] - deviance(data, at - h, guess)[0]) / 2e-5
        assert gradient[k] == pytest.approx(slope, rel=1e-6)


def test_what_a_set_up_added_is_found_for_each_run():
    data, shift = made(np.random.default_rng(1))
    u = effects(data, estimate(data, np.log([0.1, 0.1])))[0]
    assert np.corrcoef(u[:, 0], shift[:, 0])[0, 1] > 0.97


@pytest.mark.slow
def test_stated_uncertainty_is_the_scatter_of_the_estimates():
    errors, stated = [], []
    for seed in range(60):
        data, _ = made(np.random.default_rng(seed), runs=10)
        solution = estimate(data, np.log([0.1, 0.1]))
        errors.append(solution.beta[0] - 2.0)
        stated.append(np.sqrt(solution.covariance[0, 0]))
    assert np.std(errors) == pytest.approx(np.mean(stated), rel=0.3)


def test_few_runs_leave_few_degrees_of_freedom():
    """A mean over set-ups is as unsure as the scatter between them, known from few of them."""
    random = np.random.default_rng(2)
    for runs, low, high in ((6, 2.5, 9.0), (40, 25.0, 60.0)):
        shift = 0.3 * random.standard_normal((runs, 1))
        ones = np.ones((runs, 4, 1))
        y = 1.0 + shift + 0.01 * random.standard_normal((runs, 4))
        data = Data(y, ones, [ones], [np.ones((runs, 4))], np.zeros((runs, 4)), *np.zeros((2, 1)))
        guess = np.log([0.3, 0.01])
        solution = estimate(data, guess)
        assert low < freedom(solution, spread(data, solution, guess), np.ones(1)) < high


def test_a_known_parameter_does_not_move():
    data, _ = made(np.random.default_rng(3))
    known = Data(**{**data.__dict__, "precision": np.array([1e12, 0.0]), "away": np.zeros(2)})
    assert abs(weigh(known, np.log([0.3, 0.1])).beta[0]) < 1e-6
