"""How much set-ups and readings scatter, estimated from the misfit itself (REML), and what follows.

Ten repeats in one set-up do not contain the scatter from one set-up to the next; taken alone they
understate every uncertainty. Residuals y of R independent runs are modelled as
    y = X beta + sum_k Z_k u_k + e,   u_k ~ N(0, sigma_k^2),   e ~ N(0, fixed + sum_j tau_j^2 D_j),
and sigma, tau maximise the likelihood of what is left when beta has been fitted (Patterson &
Thompson 1971), under wide priors that matter only where the data say nothing.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.measurements import FloatArray

Vector = np.ndarray[tuple[int], np.dtype[np.float64]]
PRIOR_WIDTH = 2.5  # standard deviation of ln sigma about its guess


@dataclass(frozen=True)
class Data:
    """R runs of up to n numbers; rows that a run does not have are zero, with variance one."""

    y: FloatArray  # (R, n)
    X: FloatArray  # (R, n, p)
    groups: list[FloatArray]  # of each scatter: Z (R, n, q)
    masks: list[FloatArray]  # of each further noise: D (R, n), 0 or 1
    fixed: FloatArray  # (R, n) known variances
    precision: FloatArray  # (p,) of a Gaussian prior on beta about -away
    away: FloatArray  # (p,) how far the present parameters are from their prior mean
    # of the priors of ln sigma about their guess, where not the same for all
    width: FloatArray | float = PRIOR_WIDTH


@dataclass(frozen=True)
class Solution:
    """beta with its covariance, at given or estimated scatter."""

    beta: FloatArray
    covariance: FloatArray
    log_sigma: FloatArray  # groups, then masks
    weights: FloatArray  # (R, n, n) inverse covariances


def _inverse(data: Data, log_sigma: FloatArray) -> tuple[FloatArray, float]:
    variance = np.exp(2.0 * log_sigma)
    diagonal = data.fixed.copy()
    for value, mask in zip(variance[len(data.groups) :], data.masks, strict=True):
        diagonal += value * mask
    V = np.zeros((*diagonal.shape, diagonal.shape[1]))
    n = np.arange(diagonal.shape[1])
    V[:, n, n] = diagonal
    for value, Z in zip(variance, data.groups, strict=False):
        V += value * (Z @ Z.transpose(0, 2, 1))
    L = np.linalg.cholesky(V)
    logdet = 2.0 * float(np.sum(np.log(L[:, n, n])))
    half = np.linalg.inv(L)
    return half.transpose(0, 2, 1) @ half, logdet


def weigh(data: Data, log_sigma: FloatArray) -> Solution:
    """Generalised least squares at given scatter."""
    W, _ = _inverse(data, log_sigma)
    WX = W @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    return Solution(C @ _pull(data, WX), C, log_sigma, W)


def effects(data: Data, solution: Solution) -> list[FloatArray]:
    """What each run's set-up most likely added: u (R, q) of every scatter."""
    error = data.y - data.X @ solution.beta
    We = (solution.weights @ error[:, :, None])[:, :, 0]
    variance = np.exp(2.0 * solution.log_sigma)
    return [
        value * np.einsum("rnq,rn->rq", Z, We)
        for value, Z in zip(variance, data.groups, strict=False)
    ]


def _pull(data: Data, WX: FloatArray) -> FloatArray:
    pull: FloatArray = _stacked(WX).T @ data.y.ravel() - data.precision * data.away
    return pull


def _stacked(X: FloatArray) -> FloatArray:
    """All runs' rows one below the other."""
    return X.reshape(-1, X.shape[2])


def inverse_symmetric(A: FloatArray) -> FloatArray:
    """Inverse of a positive matrix of badly scaled rows."""
    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-300))
    inner = np.linalg.pinv(A * scale[:, None] * scale[None, :], rcond=1e-14, hermitian=True)
    return np.asarray(inner * scale[:, None] * scale[None, :], dtype=np.float64)


def deviance(data: Data, log_sigma: FloatArray, guess: FloatArray) -> tuple[float, FloatArray]:
    """-2 ln of the restricted likelihood times prior, and its gradient by ln sigma."""
    W, logdet = _inverse(data, log_sigma)
    WX = W @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    beta = C @ _pull(data, WX)
    error = data.y - data.X @ beta
    We = (W @ error[:, :, None])[:, :, 0]
    _, more = np.linalg.slogdet(information)
    quadratic = float(np.sum(error * We) + np.sum(data.precision * (beta + data.away) ** 2))
    away = (log_sigma - guess) / data.width
    slopes = []
    for Z in data.groups:
        WZ = W @ Z
        ZX = Z.transpose(0, 2, 1) @ WX
        trace = np.sum(Z * WZ) - np.sum((ZX @ C) * ZX)
        slopes.append(trace - np.sum((Z * We[:, :, None]).sum(1) ** 2))
    n = np.arange(W.shape[1])
    rest = W[:, n, n] - np.sum((WX @ C) * WX, axis=2) - We**2
    slopes += [float(np.sum(mask * rest)) for mask in data.masks]
    gradient = 2.0 * np.exp(2.0 * log_sigma) * np.array(slopes) + 2.0 * away / data.width
    return logdet + float(more) + quadratic + float(away @ away), gradient


def estimate(
    data: Data, guess: FloatArray, start: FloatArray | None = None, accuracy: float = 2e-9
) -> Solution:
    """REML: the scatter that explains the misfit, and beta weighed with it.

    `accuracy` is that of the likelihood's logarithm, relative.
    """
    from scipy.optimize import minimize  # slow to import

    def cost(log_sigma: Vector) -> tuple[float, Vector]:
        value, gradient = deviance(data, log_sigma, guess)
        return value, gradient.reshape(log_sigma.shape)

    begin: Vector = (guess if start is None else start).reshape(len(guess))
    bounds = [(float(g) - 7.0, float(g) + 6.0) for g in guess]
    found = minimize(
        cost, begin, jac=True, method="L-BFGS-B", bounds=bounds,
        options={"maxiter": 80, "ftol": accuracy},
    )
    return weigh(data, np.asarray(found.x))


@dataclass(frozen=True)
class Spread:
    """How sure the scatter itself is, and how the covariance of beta follows it."""

    root: FloatArray  # a square root of the covariance of ln sigma
    slopes: list[FloatArray]  # d(covariance)/d(ln sigma)


def spread(data: Data, solution: Solution, guess: FloatArray) -> Spread:
    """By differences about the estimate."""
    h, size = 0.05, len(solution.log_sigma)
    curvature, slopes = np.zeros((size, size)), []
    for k in range(size):
        step = np.zeros(size)
        step[k] = h
        up, down = solution.log_sigma + step, solution.log_sigma - step
        curvature[k] = (deviance(data, up, guess)[1] - deviance(data, down, guess)[1]) / (2.0 * h)
        change = weigh(data, up).covariance - weigh(data, down).covariance
        slopes.append(change / (2.0 * h))
    values, vectors = np.linalg.eigh(0.25 * (curvature + curvature.T))
    return Spread(vectors / np.sqrt(np.maximum(values, 0.1)), slopes)


def freedom(solution: Solution, known: Spread, direction: FloatArray) -> float:
    """Satterthwaite's degrees of freedom of the variance of direction.beta."""
    slope = np.array([direction @ change @ direction for change in known.slopes])
    variance = direction @ solution.covariance @ direction
    doubt = float(np.sum((slope @ known.root) ** 2))
    return float(np.clip(2.0 * variance**2 / max(doubt, 1e-300), 2.0, 1e4))
