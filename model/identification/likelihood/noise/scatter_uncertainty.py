"""How sure the estimated scatter itself is, and what that does to the parameters weighed by it."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.identification.likelihood.mixed_model import Solution
from model.identification.likelihood.noise.row_covariance import Data, RowCovariance
from model.measurements import FloatArray

LEAST_CURVATURE = 0.1  # of the deviance by ln sigma: what data and priors hardly tell


@dataclass(frozen=True)
class Spread:
    """How sure the scatter itself is, and how beta and its covariance follow it."""

    root: FloatArray  # a square root of the covariance of ln sigma
    slopes: list[FloatArray]  # d(covariance)/d(ln sigma)
    shifts: FloatArray  # (p, k) d(beta)/d(ln sigma)

    def kackar_harville(self) -> FloatArray:
        """Return the covariance that beta has because the scatter it is weighed by is estimated.

        (p, p), beside its covariance at known scatter: Kackar & Harville 1984 (J. Am. Stat. Assoc.
        79, 853). It is large where there are few set-ups, and small where there are many.
        """
        moves = self.shifts @ self.root
        return np.asarray(moves @ moves.T)

    def changes(
        self, covariance: FloatArray, own: Sequence[int], columns: FloatArray
    ) -> FloatArray:
        """Return how the covariance of some parameters changes with what was estimated.

        covariance: (p, p), at the scatter found; own: m of the p parameters; columns: (m, k),
        principal axes of their covariance. (R, k, k), in terms of the columns, each by one standard
        uncertainty of the scatter and independently.
        """
        back = columns / np.sum(columns**2, axis=0)  # principal axes: this is the pseudo-inverse
        # the scatter is behind what the covariance is at this scatter, not behind what is beside it
        known = covariance[np.ix_(own, own)]
        back = back / np.sqrt(np.einsum("ik,ij,jk->k", back, known, back))
        slopes = np.stack([back.T @ one[np.ix_(own, own)] @ back for one in self.slopes])
        return np.asarray(np.tensordot(self.root.T, slopes, axes=1))


def spread(data: Data, solution: Solution) -> Spread:
    """Return how sure the scatter of a solution is, by the deviance's second derivatives."""
    by = _Derivatives.of(data, solution)
    curvature = by.curvature() + 2.0 * data.prior_precision
    values, vectors = np.linalg.eigh(0.5 * curvature)
    root = vectors / np.sqrt(np.maximum(values, LEAST_CURVATURE))
    return Spread(root, by.slopes(), by.shifts())


def freedom(solution: Solution, known: Spread, direction: FloatArray) -> float:
    """Satterthwaite's degrees of freedom of the variance of direction.beta."""
    slope = np.array([direction @ change @ direction for change in known.slopes])
    variance = direction @ solution.covariance @ direction
    doubt = float(np.sum((slope @ known.root) ** 2))
    return float(np.clip(2.0 * variance**2 / max(doubt, 1e-300), 2.0, 1e4))


@dataclass(frozen=True, kw_only=True)
class _Derivatives:
    """What the derivatives by ln sigma are made of.

    With V the covariance of the rows, W its inverse, C that of beta and P = W - W X C X' W, one
    ln sigma changes V by V_k, P by -P V_k P and W e by -P V_k W e (Harville 1977, J. Am. Stat.
    Assoc. 72, 320). All V_k are of few columns, or diagonal.
    """

    noise: RowCovariance
    C: FloatArray  # (p, p)
    WX: FloatArray  # (R, n, p)
    We: FloatArray  # (R, n)
    ZWX: FloatArray  # (R, Q, p)
    VWe: FloatArray  # (R, n, k) of each ln sigma V_k W e
    inner: list[FloatArray]  # of each ln sigma X' W V_k W X (p, p)

    @staticmethod
    def of(data: Data, solution: Solution) -> _Derivatives:
        noise = solution.noise or RowCovariance.of(data, solution.log_sigma)
        stack, W = noise.stack, noise.weights
        WX = W @ data.X
        We = (W @ (data.y - data.X @ solution.beta)[:, :, None])[:, :, 0]
        turned = stack.Z.transpose(0, 2, 1)
        ZWX = turned @ WX
        by_scatter = stack.Z * (turned @ We[:, :, None]).transpose(0, 2, 1) @ stack.of
        twice = 2.0 * np.exp(2.0 * noise.log_sigma)
        VWe = twice * np.concatenate([by_scatter, stack.D * We[:, :, None]], axis=2)
        scatters = [np.concatenate(ZWX[:, own != 0.0]) for own in stack.of.T]
        noises = [_by_root(WX, share) for share in np.moveaxis(stack.D, 2, 0)]
        return _Derivatives(
            noise=noise, C=solution.covariance, WX=WX, We=We, ZWX=ZWX, VWe=VWe,
            inner=[
                much * (one.T @ one) for much, one in zip(twice, [*scatters, *noises], strict=True)
            ],
        )  # fmt: skip

    def slopes(self) -> list[FloatArray]:
        """Return d(C)/d(ln sigma), (p, p) each."""
        return [self.C @ one @ self.C for one in self.inner]

    def shifts(self) -> FloatArray:
        """Return d(beta)/d(ln sigma), (p, k)."""
        return -self.C @ self._XWVWe()

    def curvature(self) -> FloatArray:
        """Return the second derivatives of the deviance without the priors, (k, k)."""
        XWVWe, W = self._XWVWe(), self.noise.weights
        along = (
            np.sum(self.VWe.transpose(0, 2, 1) @ W @ self.VWe, axis=0) - XWVWe.T @ self.C @ XWVWe
        )
        result = 2.0 * along - self._traces()
        result[np.diag_indices_from(result)] += 2.0 * self._gradient()
        return np.asarray(result)

    def _XWVWe(self) -> FloatArray:
        return np.asarray(np.sum(self.WX.transpose(0, 2, 1) @ self.VWe, axis=0))

    def _gradient(self) -> FloatArray:
        """Of the deviance without the priors: tr(P V_k) - (W e)' V_k W e."""
        stack, W = self.noise.stack, self.noise.weights
        scatters = np.sum(stack.Z * self.noise.WZ, axis=(0, 1)) @ stack.of
        noises = np.einsum("rn,rnk->k", np.diagonal(W, axis1=1, axis2=2), stack.D)
        twice = 2.0 * np.exp(2.0 * self.noise.log_sigma)
        fitted = np.array([np.sum(self.C * one) for one in self.inner])
        squares = np.sum(self.We[:, :, None] * self.VWe, axis=(0, 1))
        return np.asarray(twice * np.concatenate([scatters, noises]) - fitted - squares)

    def _traces(self) -> FloatArray:
        """tr(P V_j P V_k), with P of all runs: they share beta."""
        stack, W, ZWX = self.noise.stack, self.noise.weights, self.ZWX
        D = stack.D.transpose(0, 2, 1)
        ZC, XC = ZWX @ self.C, self.WX @ self.C
        turned = stack.Z.transpose(0, 2, 1)
        ZZ = np.sum((turned @ self.noise.WZ) * (ZC @ ZWX.transpose(0, 2, 1)), axis=0)
        ZD = np.sum(D @ (self.noise.WZ * (self.WX @ ZC.transpose(0, 2, 1))), axis=0)
        DD = np.sum(D @ (W * (XC @ self.WX.transpose(0, 2, 1))) @ stack.D, axis=0)
        cross = ZD @ stack.of
        mixed = np.block([[stack.of.T @ ZZ @ stack.of, cross.T], [cross, DD]])
        variance = np.exp(2.0 * self.noise.log_sigma)
        weighed = [self.C @ one for one in self.inner]
        shared = np.array([[np.sum(a * b.T) for b in weighed] for a in weighed])
        within = self.noise.curvature - 8.0 * variance[:, None] * variance * mixed
        return np.asarray(within + shared)


def _by_root(rows: FloatArray, share: FloatArray) -> FloatArray:
    """Return the rows in which a noise has a share of the variance, times the root of that."""
    own = share != 0.0
    return np.asarray(rows[own] * np.sqrt(share[own])[:, None])
