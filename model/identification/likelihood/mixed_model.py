"""Mixed model (REML): scatter of set-ups and readings, estimated from the residuals.

Ten repeats in one set-up do not contain the scatter from one set-up to the next; taken alone they
understate every uncertainty. Residuals y of R independent runs are modelled as
    y = X beta + sum_k Z_k u_k + e,   u_k ~ N(0, sigma_k^2),   e ~ N(0, fixed + sum_j tau_j^2 D_j),
and sigma, tau maximise the likelihood of what is left when beta has been fitted (Patterson &
Thompson 1971), under wide priors that matter only where the data say nothing.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass, field
from functools import cached_property

import numpy as np

from model.identification.likelihood.noise.row_covariance import Data, RowCovariance
from model.measurements import FloatArray, ModelError

LONGEST = 1.5  # change of any ln sigma in one step
WELL_CONDITIONED = 1e-8  # reciprocal condition of a matrix; below it a cheaper way loses digits


class UnsettledError(ModelError):
    """A fit leads nowhere."""


def unsettled() -> UnsettledError:
    """Return the error of a fit that leads nowhere."""
    return UnsettledError("the fit did not settle: the data contradict the model too much")


@contextmanager
def _positive() -> Iterator[None]:
    """Raise `UnsettledError` where a matrix that should be positive is not.

    Far from the data numbers are so large that rounding alone may do that.
    """
    try:
        yield
    except np.linalg.LinAlgError as error:
        raise unsettled() from error


@dataclass(frozen=True, kw_only=True)
class Solution:
    """beta with its covariance, at given or estimated scatter."""

    beta: FloatArray
    covariance: FloatArray
    log_sigma: FloatArray  # groups, then masks
    weights: FloatArray  # (R, n, n) inverse covariances
    deviance: float = np.nan  # -2 ln of the restricted likelihood times prior, where estimated
    noise: RowCovariance | None = field(default=None, repr=False, compare=False)


@_positive()
def weigh(data: Data, log_sigma: FloatArray) -> Solution:
    """Generalised least squares at given scatter; raises UnsettledError where there is none."""
    noise = RowCovariance.of(data, log_sigma)
    WX = noise.weights @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    beta = C @ _right_side(data, WX)
    return Solution(
        beta=beta, covariance=C, log_sigma=log_sigma, weights=noise.weights, noise=noise
    )


def effects(data: Data, solution: Solution) -> list[FloatArray]:
    """Return the most likely random effects of each run's set-up: u (R, q) of every scatter."""
    error = data.y - data.X @ solution.beta
    We = (solution.weights @ error[:, :, None])[:, :, 0]
    variance = np.exp(2.0 * solution.log_sigma)
    return [
        value * np.einsum("rnq,rn->rq", Z, We)
        for value, Z in zip(variance, data.groups, strict=False)
    ]


def _right_side(data: Data, WX: FloatArray) -> FloatArray:
    """Return the right-hand side of the normal equations, (n,)."""
    right: FloatArray = _stacked(WX).T @ data.y.ravel() - data.precision * data.away
    return right


def _stacked(X: FloatArray) -> FloatArray:
    """All runs' rows one below the other."""
    return X.reshape(-1, X.shape[2])


@_positive()
def inverse_symmetric(A: FloatArray) -> FloatArray:
    """Inverse of a positive matrix of badly scaled rows."""
    from scipy.linalg.lapack import dpocon, dpotrf, dpotri

    scale = 1.0 / np.sqrt(np.maximum(np.diag(A), 1e-300))
    scaled = A * scale[:, None] * scale[None, :]
    factor, failed = dpotrf(scaled, lower=1)
    if not failed and len(A) and dpocon(factor, 1.0, uplo="L")[0] > WELL_CONDITIONED / len(A):
        low = np.tril(dpotri(factor, lower=1)[0])
        inner = low + np.tril(low, -1).T
    else:  # six times slower, and without a direction of which nothing is known
        inner = np.linalg.pinv(scaled, rcond=1e-14, hermitian=True)
    return np.asarray(inner * scale[:, None] * scale[None, :], dtype=np.float64)


@dataclass(frozen=True, kw_only=True)
class _DeviancePoint:
    """-2 ln of the restricted likelihood times prior; its derivatives where somebody asks."""

    data: Data
    noise: RowCovariance
    guess: FloatArray
    value: float
    WX: FloatArray
    We: FloatArray
    solution: Solution

    @cached_property
    def gradient(self) -> FloatArray:
        """By ln sigma."""
        stack, W, WX, We = self.noise.stack, self.noise.weights, self.WX, self.We
        Z, D, C, log_sigma = stack.Z, stack.D, self.solution.covariance, self.noise.log_sigma
        turned = Z.transpose(0, 2, 1)
        ZX = turned @ WX
        slopes = np.sum(Z * self.noise.WZ, axis=(0, 1)) - np.sum((ZX @ C) * ZX, axis=(0, 2))
        slopes -= np.sum((turned @ We[:, :, None]) ** 2, axis=(0, 2))
        known = np.einsum("nq,nq->n", _stacked(WX) @ C, _stacked(WX)).reshape(We.shape)
        rest = np.diagonal(W, axis1=1, axis2=2) - known - We**2
        both = np.concatenate([slopes @ stack.of, np.tensordot(rest, D, axes=2)])
        away = 2.0 * self.data.prior_precision @ (log_sigma - self.guess)
        gradient: FloatArray = 2.0 * np.exp(2.0 * log_sigma) * both + away
        return gradient

    @property
    def curvature(self) -> FloatArray:
        """Expected second derivatives."""
        curvature: FloatArray = self.noise.curvature + 2.0 * self.data.prior_precision
        return curvature


def _point(data: Data, noise: RowCovariance, guess: FloatArray) -> _DeviancePoint:
    W, log_sigma = noise.weights, noise.log_sigma
    WX = W @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    beta = C @ _right_side(data, WX)
    error = data.y - data.X @ beta
    We = (W @ error[:, :, None])[:, :, 0]
    away = log_sigma - guess
    value = noise.logdet + float(np.linalg.slogdet(information)[1])
    value += float(np.sum(error * We) + np.sum(data.precision * (beta + data.away) ** 2))
    value += float(away @ data.prior_precision @ away)
    solution = Solution(
        beta=beta, covariance=C, log_sigma=log_sigma, weights=W, deviance=value, noise=noise
    )
    return _DeviancePoint(
        data=data, noise=noise, guess=guess, value=value, WX=WX, We=We, solution=solution
    )


def deviance(data: Data, log_sigma: FloatArray, guess: FloatArray) -> tuple[float, FloatArray]:
    """-2 ln of the restricted likelihood times prior, and its gradient by ln sigma."""
    point = _point(data, RowCovariance.of(data, log_sigma), guess)
    return point.value, point.gradient


@_positive()
def estimate(
    data: Data,
    guess: FloatArray,
    start: FloatArray | None = None,
    accuracy: float = 1e-5,
    *,
    there: Solution | None = None,
) -> Solution:
    """REML: the scatter that explains the misfit, and beta weighed with it, by Fisher's scoring.

    It ends when no more than `accuracy` of the deviance is to be had. `there` is a solution with
    other columns, where it may begin: of the same scatter the covariance is the same.
    Raises UnsettledError where there is no solution.
    """
    low, high = guess - 7.0, guess + 6.0
    at = np.clip(guess if start is None else start, low, high)
    known = None if there is None else there.noise
    if known is None or not known.is_of(data, at):
        known = RowCovariance.of(data, at)
    point, damping = _point(data, known, guess), 1e-3
    for _ in range(60):
        H = point.curvature  # not worked out at the last one, nor where the step was bad
        H[np.diag_indices_from(H)] *= 1.0 + damping
        held = ((at <= low) & (point.gradient > 0.0)) | ((at >= high) & (point.gradient < 0.0))
        gradient = np.where(held, 0.0, point.gradient)
        step = -np.linalg.solve(H, gradient)
        further = np.clip(at + step / max(1.0, float(np.max(np.abs(step))) / LONGEST), low, high)
        expected = -0.5 * float(gradient @ (further - at))
        if expected < accuracy:
            break
        other = _point(data, RowCovariance.of(data, further), guess)
        if other.value < point.value:
            done = point.value - other.value < accuracy
            at, point, damping = further, other, max(damping / 5.0, 1e-4)
            if done:
                break
        else:
            damping *= 10.0
            if damping > 1e6:
                break
    return point.solution
