"""Mixed model (REML): scatter of set-ups and readings, estimated from the residuals.

Ten repeats in one set-up do not contain the scatter from one set-up to the next; taken alone they
understate every uncertainty. Residuals y of R independent runs are modelled as
    y = X beta + sum_k Z_k u_k + e,   u_k ~ N(0, sigma_k^2),   e ~ N(0, fixed + sum_j tau_j^2 D_j),
and sigma, tau maximise the likelihood of what is left when beta has been fitted (Patterson &
Thompson 1971), under wide priors that matter only where the data say nothing.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray

Index = npt.NDArray[np.int64]

PRIOR_WIDTH = 2.5  # standard deviation of ln sigma about its guess
LONGEST = 1.5  # change of any ln sigma in one step
# Below these a cheaper way would lose digits: of a row's variance its own noise's share; the
# reciprocal condition of a matrix.
LEAST_SHARE, WELL_CONDITIONED = 1e-7, 1e-8
MANY = 5  # columns of a scatter that is rather a covariance of few rows, as a wander in time


@dataclass(frozen=True, kw_only=True)
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
    # the scatters and noises side by side, for all data that have the same
    stacks: list[_Stack] = field(default_factory=list, repr=False, compare=False)

    @property
    def stack(self) -> _Stack:
        """Return the scatters and noises side by side; they are put so once."""
        if not (self.stacks and self.stacks[-1].is_of(self)):
            self.stacks[:] = [_Stack.of_data(self)]
        return self.stacks[-1]


@dataclass(frozen=True, kw_only=True)
class Solution:
    """beta with its covariance, at given or estimated scatter."""

    beta: FloatArray
    covariance: FloatArray
    log_sigma: FloatArray  # groups, then masks
    weights: FloatArray  # (R, n, n) inverse covariances
    deviance: float = np.nan  # -2 ln of the restricted likelihood times prior, where estimated
    noise: _Covariance | None = field(default=None, repr=False, compare=False)


def _inverted(V: FloatArray) -> tuple[FloatArray, float]:
    """Inverses of positive matrices, and ln of the product of their determinants; V is used up."""
    from scipy.linalg.lapack import dpotrf, dpotri

    for one in V:
        # a symmetric matrix is its own transpose, which is what LAPACK works on without a copy
        if dpotrf(one.T, lower=1, clean=0, overwrite_a=1)[1]:
            raise np.linalg.LinAlgError("a covariance is not positive")
    logdet = 2.0 * float(np.sum(np.log(np.diagonal(V, axis1=1, axis2=2))))
    for one in V:
        dpotri(one.T, lower=1, overwrite_c=1)
    low, right = _below(V.shape[1])
    V[:, low, right] = V[:, right, low]
    return V, logdet


@lru_cache(maxsize=8)
def _below(n: int) -> tuple[Index, Index]:
    """Return the places below the diagonal of an n by n matrix."""
    return np.tril_indices(n, -1)


def _triangular(V: FloatArray) -> tuple[FloatArray, float]:
    """Inverses of Cholesky's factors, and ln of the product of the determinants."""
    from scipy.linalg.lapack import dtrtri

    L = np.linalg.cholesky(V)
    n = np.arange(V.shape[1])
    logdet = 2.0 * float(np.sum(np.log(L[:, n, n])))
    # three times quicker than numpy's, which does not know that they are triangular
    return np.stack([dtrtri(one, lower=1)[0] for one in L]), logdet


def weigh(data: Data, log_sigma: FloatArray) -> Solution:
    """Generalised least squares at given scatter."""
    noise = _Covariance.of(data, log_sigma)
    WX = noise.weights @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    beta = C @ _pull(data, WX)
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


def _pull(data: Data, WX: FloatArray) -> FloatArray:
    pull: FloatArray = _stacked(WX).T @ data.y.ravel() - data.precision * data.away
    return pull


def _stacked(X: FloatArray) -> FloatArray:
    """All runs' rows one below the other."""
    return X.reshape(-1, X.shape[2])


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


@dataclass(frozen=True)
class _Stack:
    """All scatters side by side, all noises side by side: one product does for all."""

    Z: FloatArray  # (R, n, Q)
    of: FloatArray  # (Q, groups) 1 where a column belongs to a scatter
    D: FloatArray  # (R, n, masks)
    variance: FloatArray  # (R, n, groups) by the scatters, of size one
    groups: list[FloatArray]  # of which it is
    masks: list[FloatArray]
    few: Index  # columns of the scatters that have few
    rows: Index  # (R, m) of each run, that the others touch, as a wander in time
    within: FloatArray  # (groups, R, m, m) covariance of these by the others, of size one

    @staticmethod
    def of_data(data: Data) -> _Stack:
        R, n = data.y.shape
        Z = np.concatenate([np.zeros((R, n, 0)), *data.groups], axis=2)
        widths = [group.shape[2] for group in data.groups]
        belongs = np.repeat(np.arange(len(widths)), widths)
        of = np.eye(len(widths))[belongs]
        D = np.stack(data.masks, axis=2) if data.masks else np.zeros((R, n, 0))
        variance = Z**2 @ of
        many = [j for j, width in enumerate(widths) if width >= MANY]
        touched = np.any(variance[:, :, many] != 0.0, axis=2)
        m = int(np.max(np.sum(touched, axis=1)))
        rows = np.argsort(~touched, axis=1, kind="stable")[:, :m]
        within = np.zeros((len(data.groups), R, m, m))
        for j in many:
            own = data.groups[j][np.arange(R)[:, None], rows]
            within[j] = own @ own.transpose(0, 2, 1)
        few = np.flatnonzero(~np.isin(belongs, many))
        return _Stack(Z, of, D, variance, data.groups, data.masks, few, rows, within)

    def is_of(self, data: Data) -> bool:
        """Return whether data have these scatters and noises."""
        return data.groups is self.groups and data.masks is self.masks


def _weights(data: Data, stack: _Stack, log_sigma: FloatArray) -> tuple[FloatArray, float]:
    """Inverse covariances (R, n, n), and ln of the product of the covariances' determinants.

    By Woodbury's identity: there are fewer scatters than rows, but for those of few rows.
    """
    groups, n = len(data.groups), np.arange(data.y.shape[1])
    sizes, squares = np.exp(stack.of @ log_sigma[:groups]), np.exp(2.0 * log_sigma)
    noise = data.fixed + stack.D @ squares[groups:]
    scatter = stack.variance @ squares[:groups]
    small = 0 < 2 * len(stack.few) <= len(n)
    if not small or np.any(noise <= LEAST_SHARE * (noise + scatter)):
        scaled = stack.Z * sizes
        V = scaled @ scaled.transpose(0, 2, 1)
        V[:, n, n] += noise
        return _inverted(V)
    scaled = stack.Z[:, :, stack.few] * sizes[stack.few]
    W, over = np.zeros((*noise.shape, len(n))), scaled / noise[:, :, None]
    W[:, n, n] = 1.0 / noise
    logdet = float(np.sum(np.log(noise)))
    if stack.rows.shape[1]:
        rows, R = stack.rows, np.arange(len(noise))[:, None]
        block = np.tensordot(squares[:groups], stack.within, axes=1)
        k = np.arange(rows.shape[1])
        block[:, k, k] += noise[R, rows]
        inverse, of_block = _inverted(block)
        W[R[:, :, None], rows[:, :, None], rows[:, None, :]] = inverse
        over[R, rows] = inverse @ scaled[R, rows]
        logdet += of_block - float(np.sum(np.log(noise[R, rows])))
    inner = scaled.transpose(0, 2, 1) @ over
    q = np.arange(inner.shape[1])
    inner[:, q, q] += 1.0
    half, of_inner = _triangular(inner)
    less = half @ over.transpose(0, 2, 1)
    W -= less.transpose(0, 2, 1) @ less
    return W, logdet + of_inner


@dataclass(frozen=True, kw_only=True)
class _Covariance:
    """The covariance of all rows at given scatter, inverted."""

    stack: _Stack
    fixed: FloatArray  # known variances of the data
    log_sigma: FloatArray
    weights: FloatArray
    logdet: float

    @staticmethod
    def of(data: Data, log_sigma: FloatArray) -> _Covariance:
        W, logdet = _weights(data, data.stack, log_sigma)
        return _Covariance(
            stack=data.stack, fixed=data.fixed, log_sigma=log_sigma, weights=W, logdet=logdet
        )

    def is_of(self, data: Data, log_sigma: FloatArray) -> bool:
        """Return whether it is that of data at given scatter."""
        same = self.stack.is_of(data) and data.fixed is self.fixed
        return same and np.array_equal(log_sigma, self.log_sigma)

    @cached_property
    def WZ(self) -> FloatArray:
        """Of all scatters."""
        return self.weights @ self.stack.Z

    @cached_property
    def curvature(self) -> FloatArray:
        """Expected second derivatives of the deviance by ln sigma, without the priors."""
        Z, of, WZ = self.stack.Z, self.stack.of, self.WZ
        D = self.stack.D.transpose(0, 2, 1)
        ZWZ = np.sum((Z.transpose(0, 2, 1) @ WZ) ** 2, axis=0)
        cross = np.sum(D @ WZ**2, axis=0) @ of
        DWD = np.sum(D @ self.weights**2 @ self.stack.D, axis=0)
        X = np.block([[of.T @ ZWZ @ of, cross.T], [cross, DWD]])
        variance = np.exp(2.0 * self.log_sigma)
        curvature: FloatArray = 4.0 * variance[:, None] * variance * X
        return curvature


@dataclass(frozen=True, kw_only=True)
class _DeviancePoint:
    """-2 ln of the restricted likelihood times prior; its derivatives where somebody asks."""

    data: Data
    noise: _Covariance
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
        away = 2.0 * (log_sigma - self.guess) / np.square(self.data.width)
        gradient: FloatArray = 2.0 * np.exp(2.0 * log_sigma) * both + away
        return gradient

    @property
    def curvature(self) -> FloatArray:
        """Expected second derivatives."""
        curvature = self.noise.curvature.copy()
        curvature[np.diag_indices_from(curvature)] += 2.0 / np.square(self.data.width)
        return curvature


def _point(data: Data, noise: _Covariance, guess: FloatArray) -> _DeviancePoint:
    W, log_sigma = noise.weights, noise.log_sigma
    WX = W @ data.X
    information = _stacked(data.X).T @ _stacked(WX) + np.diag(data.precision)
    C = inverse_symmetric(information)
    beta = C @ _pull(data, WX)
    error = data.y - data.X @ beta
    We = (W @ error[:, :, None])[:, :, 0]
    away = (log_sigma - guess) / data.width
    value = noise.logdet + float(np.linalg.slogdet(information)[1])
    value += float(np.sum(error * We) + np.sum(data.precision * (beta + data.away) ** 2))
    value += float(away @ away)
    solution = Solution(
        beta=beta, covariance=C, log_sigma=log_sigma, weights=W, deviance=value, noise=noise
    )
    return _DeviancePoint(
        data=data, noise=noise, guess=guess, value=value, WX=WX, We=We, solution=solution
    )


def deviance(data: Data, log_sigma: FloatArray, guess: FloatArray) -> tuple[float, FloatArray]:
    """-2 ln of the restricted likelihood times prior, and its gradient by ln sigma."""
    point = _point(data, _Covariance.of(data, log_sigma), guess)
    return point.value, point.gradient


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
    """
    low, high = guess - 7.0, guess + 6.0
    at = np.clip(guess if start is None else start, low, high)
    known = None if there is None else there.noise
    if known is None or not known.is_of(data, at):
        known = _Covariance.of(data, at)
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
        other = _point(data, _Covariance.of(data, further), guess)
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
        up, down = (
            _point(data, _Covariance.of(data, solution.log_sigma + d), guess) for d in (step, -step)
        )
        curvature[k] = (up.gradient - down.gradient) / (2.0 * h)
        slopes.append((up.solution.covariance - down.solution.covariance) / (2.0 * h))
    values, vectors = np.linalg.eigh(0.25 * (curvature + curvature.T))
    return Spread(vectors / np.sqrt(np.maximum(values, 0.1)), slopes)


def freedom(solution: Solution, known: Spread, direction: FloatArray) -> float:
    """Satterthwaite's degrees of freedom of the variance of direction.beta."""
    slope = np.array([direction @ change @ direction for change in known.slopes])
    variance = direction @ solution.covariance @ direction
    doubt = float(np.sum((slope @ known.root) ** 2))
    return float(np.clip(2.0 * variance**2 / max(doubt, 1e-300), 2.0, 1e4))
