"""How well a hidden effect can be seen: its true signature, measured against noise and scatter.

The session is made twice from the same seed, with and without the effect: noise and scatter are the
same, so the difference of the two is the effect's own signature s, whatever its form. With W the
inverse covariance of noise and set-up scatter (as estimated where nothing is hidden) and X the base
model's columns,
    P = W - W X (X'WX)^-1 X'W,    d^2 = s'P s
is the detectability: the length of what B and EIBM cannot take up, in standard deviations. Effects
of the catalogue are compared with s itself, at the size at which each comes nearest to it.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model import Measurements
from model.discrepancy.prepare import Options, prepare
from model.discrepancy.score import Candidate, Projected, candidates
from model.discrepancy.settle import settle
from model.effects.catalogue import catalogue
from model.measurements import FloatArray


@dataclass(frozen=True)
class Visible:
    """What could be seen at best; the truth's business, not the diagnosis's."""

    d: tuple[float, ...]  # of each hidden effect, with the base refitted, and the others
    alone: tuple[float, ...]  # with the base refitted
    # distance in sigmas from each further effect of the catalogue, of whichever hidden is nearer
    near: Mapping[str, float]
    # least share of d^2 that an effect of the catalogue leaves, as written, and its form tolerated
    left: Mapping[str, float]
    left_tolerant: Mapping[str, float]


class Yardstick:
    """The session with nothing hidden, fitted."""

    def __init__(self, bare: Measurements, symmetric: bool = False) -> None:
        self._options = Options(symmetric=symmetric)
        ready = prepare(bare, self._options)
        self._fitted = settle(ready.problem, ready.theta)
        self._projected = Projected.of(
            ready.problem.study, self._fitted.linear, self._fitted.solution
        )
        self._bare = self._data(bare)

    def _data(self, measurements: Measurements) -> FloatArray:
        """All rows (N,) about the base model of the session with nothing hidden."""
        bases = self._fitted.problem.bases
        study = prepare(measurements, self._options).problem.study
        rows = np.zeros(study.layout.size)
        for c in range(len(study.names)):
            rows += study.state(c, bases.beam(study, c, self._fitted.theta), ()).residual
        return rows

    def signature(self, hidden: Measurements) -> FloatArray:
        """What hiding something has changed: (N,)."""
        return self._data(hidden) - self._bare

    def length(self, hidden: Measurements) -> float:
        """The detectability d."""
        A = self._normal(self.signature(hidden)[:, None])
        return float(np.sqrt(max(A[0, 0], 0.0)))

    def visible(
        self, hidden: Sequence[Measurements], names: Sequence[str], exclude: Sequence[str] = ()
    ) -> Visible:
        """Of the effects, each hidden alone in one of these sessions."""
        S = np.stack([self.signature(m) for m in hidden], axis=1)
        A = self._normal(S)
        alone = tuple(np.sqrt(np.maximum(np.diag(A), 0.0)).tolist())
        d = tuple(
            float(np.sqrt(max(_without(_first(A, i), 1)[0, 0], 0.0))) for i in range(len(names))
        )
        near: dict[str, float] = {}
        left: dict[str, float] = {}
        tolerant: dict[str, float] = {}
        for one in self._pool(exclude):
            exact, free = zip(*(self._apart(S, i, one) for i in range(len(names))), strict=True)
            if one.name not in names:
                near[one.name] = min(near.get(one.name, np.inf), *np.sqrt(exact).tolist())
            for shares, rest in ((left, exact), (tolerant, free)):
                share = min(r / max(x**2, 1e-12) for r, x in zip(rest, d, strict=True))
                shares[one.name] = min(shares.get(one.name, 1.0), share)
        return Visible(d, alone, near, left, tolerant)

    def _pool(self, exclude: Sequence[str]) -> list[Candidate]:
        skip = set(exclude) | (set() if self._options.symmetric else {"eibm_asymmetry"})
        return candidates(self._fitted, [e for n, e in catalogue().items() if n not in skip])

    def _apart(self, S: FloatArray, i: int, one: Candidate) -> tuple[float, float]:
        """Squared distance from an effect as written, and with the tolerance of its form."""
        others = np.delete(S, i, axis=1)
        columns = np.concatenate([S[:, i : i + 1], one.columns], axis=1)
        A = self._normal(np.concatenate([columns, others], axis=1))
        if others.shape[1]:
            A = _without(A, columns.shape[1])
        if A[1, 1] <= 1e-12:
            return float(A[0, 0]), float(A[0, 0])
        amplitude = A[0, 1] / A[1, 1]
        exact = max(float(A[0, 0] - A[0, 1] * amplitude), 0.0)
        ridge = A[1:, 1:] + np.eye(A.shape[0] - 1) / max(amplitude**2, 1e-12)
        free = float(A[0, 0] - A[0, 1:] @ np.linalg.solve(ridge, A[1:, 0]))
        return exact, min(max(free, 0.0), exact)

    def _normal(self, S: FloatArray) -> FloatArray:
        """S'PS."""
        return self._projected.normal(self._fitted.problem.study, S)[0]


def _without(A: FloatArray, count: int) -> FloatArray:
    """S'PS of the first columns, the others refitted."""
    inner = np.linalg.lstsq(A[count:, count:], A[count:, :count], rcond=1e-12)[0]
    result: FloatArray = A[:count, :count] - A[:count, count:] @ inner
    return result


def _first(A: FloatArray, i: int) -> FloatArray:
    """With another column in the first place."""
    order = [i, *(j for j in range(len(A)) if j != i)]
    return A[np.ix_(order, order)]
