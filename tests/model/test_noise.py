"""The scatter between set-ups is found from the misfit, and uncertainties follow it."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from model.identification.likelihood.mixed_model import (
    deviance,
    effects,
    estimate,
    inverse_symmetric,
    weigh,
)
from model.identification.likelihood.noise.row_covariance import Data
from model.identification.likelihood.noise.scatter_uncertainty import freedom, spread
from model.measurements import ModelError


def made(random, runs=40, u=0.3, tau=0.1):
    """y = X beta + Z u + e with one random effect for each run of five numbers."""
    X = random.standard_normal((runs, 5, 2))
    Z = np.ones((runs, 5, 1)) + 0.2 * random.standard_normal((runs, 5, 1))
    shift = u * random.standard_normal((runs, 1))
    y = X @ np.array([2.0, -1.0]) + Z[:, :, 0] * shift + tau * random.standard_normal((runs, 5))
    data = Data(
        y=y,
        X=X,
        groups=[Z],
        masks=[np.ones((runs, 5))],
        fixed=np.full((runs, 5), 1e-6),
        precision=np.zeros(2),
        away=np.zeros(2),
    )
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
        data = Data(
            y=y, X=ones, groups=[ones], masks=[np.ones((runs, 4))], fixed=np.zeros((runs, 4)),
            precision=np.zeros(1), away=np.zeros(1),
        )  # fmt: skip
        guess = np.log([0.3, 0.01])
        solution = estimate(data, guess)
        assert low < freedom(solution, spread(data, solution), np.ones(1)) < high


def test_weights_by_a_scatter_that_is_hardly_known_make_the_mean_less_sure():
    """Two instruments of unknown noise, read four times each: their weighted mean."""
    squares, stated = [], []
    for seed in range(150):
        data = Data(
            y=0.1 * np.random.default_rng(seed).standard_normal((4, 2)), X=np.ones((4, 2, 1)),
            groups=[], masks=[np.tile(row, (4, 1)) for row in np.eye(2)], fixed=np.zeros((4, 2)),
            precision=np.zeros(1), away=np.zeros(1),
        )  # fmt: skip
        guess = np.log([0.1, 0.1])
        solution = estimate(data, guess)
        squares.append(solution.beta[0] ** 2)
        known = spread(data, solution).kackar_harville()[0, 0]
        stated.append((solution.covariance[0, 0], solution.covariance[0, 0] + known))
    without, together = np.mean(stated, axis=0)
    assert without < 0.7 * np.mean(squares)
    assert together == pytest.approx(np.mean(squares), rel=0.15)


def test_a_known_parameter_does_not_move():
    data, _ = made(np.random.default_rng(3))
    known = Data(**{**data.__dict__, "precision": np.array([1e12, 0.0]), "away": np.zeros(2)})
    assert abs(weigh(known, np.log([0.3, 0.1])).beta[0]) < 1e-6


# covariance of the prior on ln sigma: the two noises are unsure together as well
WIDTHS = np.diag([0.64, 1.0, 4.0, 0.09]) + np.pad(np.full((2, 2), 0.36), ((2, 0), (2, 0)))


def rich(seed: int = 5, runs: int = 14):
    """Two scatters and two noises, one of some rows in parts, with priors of their own."""
    random = np.random.default_rng(seed)
    X = random.standard_normal((runs, 6, 3))
    groups = [random.standard_normal((runs, 6, 1)), random.standard_normal((runs, 6, 2))]
    # the mean of some readings has a part of the noise of one
    masks = [np.ones((runs, 6)), np.tile([1.0, 0.0, 0.25, 0.0, 0.1, 0.0], (runs, 1))]
    y = 0.5 * random.standard_normal((runs, 6))
    for sigma, Z in zip((0.8, 0.4), groups, strict=True):
        y += sigma * np.einsum("rnq,rq->rn", Z, random.standard_normal((runs, Z.shape[2])))
    precision, away = np.array([0.0, 4.0, 1.0]), np.array([0.0, 0.3, -0.2])
    return Data(
        y=y,
        X=X,
        groups=groups,
        masks=masks,
        fixed=np.full((runs, 6), 0.01),
        precision=precision,
        away=away,
        scatter_precision=np.linalg.inv(WIDTHS),
    )


def test_the_gradient_is_exact_with_several_scatters_noises_and_priors():
    data = rich(runs=5)
    at, guess = np.log([0.7, 0.3, 0.4, 0.2]), np.log([0.5, 0.5, 0.5, 0.1])
    _, gradient = deviance(data, at, guess)
    for k in range(4):
        h = np.eye(4)[k] * 1e-5
        slope = (deviance(data, at + h, guess)[0] - deviance(data, at - h, guess)[0]) / 2e-5
        assert gradient[k] == pytest.approx(slope, rel=1e-6, abs=1e-7)


def test_what_follows_from_the_scatter_is_exact_with_several_scatters_noises_and_priors():
    """Second derivatives of the deviance, and how beta and its covariance follow."""
    data, guess = rich(), np.log([0.5, 0.5, 0.5, 0.1])
    at, h = estimate(data, guess).log_sigma + 0.05, 1e-5  # beside it, where slopes matter, too
    found = spread(data, weigh(data, at))
    curvature = np.zeros((4, 4))
    for k, step in enumerate(h * np.eye(4)):
        up, down = weigh(data, at + step), weigh(data, at - step)
        curvature[k] = deviance(data, at + step, guess)[1] - deviance(data, at - step, guess)[1]
        shift, slope = up.beta - down.beta, up.covariance - down.covariance
        np.testing.assert_allclose(found.shifts[:, k], shift / (2.0 * h), rtol=1e-6, atol=1e-8)
        np.testing.assert_allclose(found.slopes[k], slope / (2.0 * h), rtol=1e-6, atol=1e-8)
    of_log_sigma = np.linalg.inv(0.25 * curvature / h)
    np.testing.assert_allclose(found.root @ found.root.T, of_log_sigma, rtol=1e-6, atol=1e-8)


def test_an_estimate_ends_where_the_likelihood_is_level_wherever_it_began():
    data, guess = rich(), np.log([0.5, 0.5, 0.5, 0.1])
    found = [
        estimate(data, guess, guess + start, 1e-9).log_sigma
        for start in (np.zeros(4), np.array([2.0, -2.0, 1.0, -1.0]), np.full(4, -3.0))
    ]
    value, gradient = deviance(data, found[0], guess)
    assert np.max(np.abs(gradient)) < 1e-3
    for other in found[1:]:
        np.testing.assert_allclose(other, found[0], atol=1e-3)
    random = np.random.default_rng(1)
    for _ in range(20):
        assert deviance(data, found[0] + 0.2 * random.standard_normal(4), guess)[0] > value


def test_a_rough_estimate_is_within_its_accuracy_of_the_best():
    data, guess = rich(), np.log([0.5, 0.5, 0.5, 0.1])
    best = deviance(data, estimate(data, guess, None, 1e-10).log_sigma, guess)[0]
    rough = deviance(data, estimate(data, guess, None, 0.1).log_sigma, guess)[0]
    assert best <= rough < best + 0.2


def test_the_likelihood_is_that_of_a_gaussian_with_flat_parameters_integrated_out():
    """The difference between two scatters is that of the marginal likelihoods."""
    from scipy.stats import multivariate_normal

    data, guess = rich(runs=3), np.zeros(4)
    X, y = data.X.reshape(-1, 3), data.y.ravel()
    wide = 1e5 * np.outer(X[:, 0], X[:, 0])  # no prior on the first

    def marginal(at) -> float:
        sigma2, N = np.exp(2.0 * at), 6
        V = wide + X[:, 1:] @ np.diag([0.25, 1.0]) @ X[:, 1:].T
        for r in range(3):
            own = slice(N * r, N * r + N)
            V[own, own] += np.diag(
                data.fixed[r] + sigma2[2] * data.masks[0][r] + sigma2[3] * data.masks[1][r]
            )
            for value, Z in zip(sigma2, data.groups, strict=False):
                V[own, own] += value * Z[r] @ Z[r].T
        mean = -X[:, 1:] @ data.away[1:]
        away = at - guess
        prior = float(away @ np.linalg.solve(WIDTHS, away))
        return -2.0 * multivariate_normal(mean, V).logpdf(y) + prior

    one, two = np.log([0.7, 0.3, 0.4, 0.2]), np.log([0.2, 0.6, 0.5, 0.4])
    found = deviance(data, one, guess)[0] - deviance(data, two, guess)[0]
    assert found == pytest.approx(marginal(one) - marginal(two), rel=1e-4)


def covariance(data, log_sigma):
    """Of each run, written out."""
    variance = np.exp(2.0 * log_sigma)
    many, n = len(data.groups), np.arange(data.y.shape[1])
    V = sum(v * Z @ Z.transpose(0, 2, 1) for v, Z in zip(variance, data.groups, strict=False))
    V = V + np.zeros((*data.y.shape, len(n)))
    V[:, n, n] += data.fixed
    for v, D in zip(variance[many:], data.masks, strict=True):
        V[:, n, n] += v * D
    return V


@pytest.mark.parametrize(
    ("scatters", "noise"), [(0, 0.1), (1, 0.1), (2, 0.1), (4, 0.1), (1, 1e-3), (1, 1e-6)]
)
def test_weights_are_the_inverse_of_the_covariance_however_they_are_found(scatters, noise):
    random = np.random.default_rng(scatters)
    data, _ = made(random, runs=4)
    groups = [random.standard_normal((4, 5, 1)) for _ in range(scatters)]
    data = replace(data, groups=groups, fixed=np.zeros((4, 5)))
    log_sigma = np.log(np.append(np.full(scatters, 0.3), noise))
    V = covariance(data, log_sigma)
    W = weigh(data, log_sigma).weights
    inverse = np.linalg.inv(V)
    sure = 1e-15 * np.linalg.cond(V)[:, None, None] * np.abs(inverse).max((1, 2), keepdims=True)
    assert np.all(np.abs(W - inverse) < 100.0 * sure)


@pytest.mark.parametrize("solve", [weigh, lambda data, at: estimate(data, at)])
@pytest.mark.parametrize("scatters", [0, 1])
def test_a_covariance_that_is_not_positive_is_a_sentence(solve, scatters):
    data, _ = made(np.random.default_rng(0), runs=4)
    data = replace(data, groups=data.groups[:scatters], fixed=np.full((4, 5), -1.0))
    with pytest.raises(ModelError, match="the fit did not settle"):
        solve(data, np.log(np.append(np.full(scatters, 0.1), 0.1)))


def wandering(random):
    """Return runs of 14 numbers, the first few of which wander: none of the last run's."""
    touched = np.arange(14) < np.array([4, 3, 4, 0])[:, None]
    wander = [random.standard_normal((4, 14, q)) * touched[:, :, None] for q in (5, 6)]
    return Data(
        y=random.standard_normal((4, 14)),
        X=random.standard_normal((4, 14, 2)),
        groups=[random.standard_normal((4, 14, 1)), *wander, random.standard_normal((4, 14, 2))],
        masks=[np.ones((4, 14))],
        fixed=np.full((4, 14), 1e-3),
        precision=np.zeros(2),
        away=np.zeros(2),
    )


def test_a_scatter_of_more_columns_than_rows_is_weighed_as_any_other():
    data, log_sigma = wandering(np.random.default_rng(3)), np.log([0.4, 0.5, 0.3, 0.6, 0.2])
    inverse = np.linalg.inv(covariance(data, log_sigma))
    np.testing.assert_allclose(weigh(data, log_sigma).weights, inverse, rtol=1e-9, atol=1e-9)
    _, gradient = deviance(data, log_sigma, log_sigma)
    for k in range(len(log_sigma)):  # of the determinant, too
        h = np.eye(len(log_sigma))[k] * 1e-5
        up, down = (deviance(data, at, at)[0] for at in (log_sigma + h, log_sigma - h))
        assert gradient[k] == pytest.approx((up - down) / 2e-5, rel=1e-6, abs=1e-6)


def test_an_inverse_is_good_where_a_direction_is_almost_unknown():
    random = np.random.default_rng(5)
    turn, _ = np.linalg.qr(random.standard_normal((6, 6)))
    size = 10.0 ** np.arange(6)  # badly scaled rows, as of parameters in different units
    for least in (1e-2, 1e-7, 1e-10):
        A = (turn * np.array([1.0, 1.0, 0.5, 0.1, 0.1, least])) @ turn.T
        found = inverse_symmetric(A * size * size[:, None]) * size * size[:, None]
        np.testing.assert_allclose(found @ A, np.eye(6), atol=1e-14 / least)


def test_an_estimate_says_its_deviance():
    data, _ = made(np.random.default_rng(2), runs=6)
    guess = np.log([0.1, 0.3])
    found = estimate(data, guess)
    assert found.deviance == deviance(data, found.log_sigma, guess)[0]
