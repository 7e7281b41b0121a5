"""Covariance of all rows at given scatter and noise, inverted run by run, with its derivatives."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property, lru_cache

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray

Index = npt.NDArray[np.int64]

PRIOR_WIDTH = 2.5  # standard deviation of ln sigma about its guess, where nothing else is said
# of a row's variance its own noise's share, below which the cheaper way would lose digits
LEAST_SHARE = 1e-7
# of a scatter that is rather a covariance of few rows, as a wander in time: the least number of its
# columns, and the most rows to each of them
MANY = 5
ROWS_A_COLUMN = 2


@dataclass(frozen=True, kw_only=True)
class Data:
    """R runs of up to n numbers; rows that a run does not have are zero, with variance one."""

    y: FloatArray  # (R, n)
    X: FloatArray  # (R, n, p)
    groups: list[FloatArray]  # of each scatter: Z (R, n, q)
    masks: list[FloatArray]  # of each further noise: D (R, n), its share of a row; 0: none
    fixed: FloatArray  # (R, n) known variances
    precision: FloatArray  # (p,) of a Gaussian prior on beta about -away
    away: FloatArray  # (p,) how far the present parameters are from their prior mean
    # (k, k) precision of the Gaussian prior on ln sigma about its guess
    scatter_precision: FloatArray | None = None
    # the scatters and noises side by side, for all data that have the same
    stacks: list[Stack] = field(default_factory=list, repr=False, compare=False)

    @property
    def prior_precision(self) -> FloatArray:
        """Return the precision of the prior on ln sigma; by PRIOR_WIDTH where none is given."""
        if self.scatter_precision is not None:
            return self.scatter_precision
        return np.eye(len(self.groups) + len(self.masks)) / PRIOR_WIDTH**2

    @property
    def stack(self) -> Stack:
        """Return the scatters and noises side by side; they are put so once."""
        if not (self.stacks and self.stacks[-1].is_of(self)):
            self.stacks[:] = [Stack.of_data(self)]
        return self.stacks[-1]


@dataclass(frozen=True, kw_only=True)
class Stack:
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
    def of_data(data: Data) -> Stack:
        """Return those of data."""
        R, n = data.y.shape
        Z = np.concatenate([np.zeros((R, n, 0)), *data.groups], axis=2)
        widths = [group.shape[2] for group in data.groups]
        belongs = np.repeat(np.arange(len(widths)), widths)
        of = np.eye(len(widths))[belongs]
        D = np.stack(data.masks, axis=2) if data.masks else np.zeros((R, n, 0))
        variance = Z**2 @ of
        touches = variance != 0.0
        most = np.max(np.sum(touches, axis=1), axis=0)
        many = [
            j
            for j, width in enumerate(widths)
            if width >= MANY and most[j] <= ROWS_A_COLUMN * width
        ]
        touched = np.any(touches[:, :, many], axis=2)
        m = int(np.max(np.sum(touched, axis=1)))
        rows = np.argsort(~touched, axis=1, kind="stable")[:, :m]
        within = np.zeros((len(data.groups), R, m, m))
        for j in many:
            own = data.groups[j][np.arange(R)[:, None], rows]
            within[j] = own @ own.transpose(0, 2, 1)
        few = np.flatnonzero(~np.isin(belongs, many))
        return Stack(
            Z=Z, of=of, D=D, variance=variance, groups=data.groups, masks=data.masks, few=few,
            rows=rows, within=within,
        )  # fmt: skip

    def is_of(self, data: Data) -> bool:
        """Return whether data have these scatters and noises."""
        return data.groups is self.groups and data.masks is self.masks


def _weights(data: Data, stack: Stack, log_sigma: FloatArray) -> tuple[FloatArray, float]:
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
class RowCovariance:
    """The covariance of all rows at given scatter, inverted."""

    stack: Stack
    fixed: FloatArray  # known variances of the data
    log_sigma: FloatArray
    weights: FloatArray
    logdet: float

    @staticmethod
    def of(data: Data, log_sigma: FloatArray) -> RowCovariance:
        """Return that of data at given scatter."""
        W, logdet = _weights(data, data.stack, log_sigma)
        return RowCovariance(
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
