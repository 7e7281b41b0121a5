"""How well a hidden effect can be seen: its true signature, measured against noise and scatter.

The session is made twice from the same seed, with and without the effect: noise and scatter are the
same, so the difference of the two is the effect's own signature s, whatever its form. B, EIBM and
whatever else the base model may choose are refitted to take up as much of it as they can. With W
the inverse covariance of noise and set-up scatter (as estimated where nothing is hidden) and X the
base model's columns,
    P = W - W X (X'WX)^-1 X'W,    d^2 = s'P s
is the detectability: the length of what B and EIBM cannot take up, in standard deviations. Effects
of the catalogue are compared with s itself, at the size at which each comes nearest to it. Where
the form is not the catalogue's, the right entry is some way off, too: another one is as far from
being the answer as it explains less,
    near^2 = (distance of the other)^2 - (distance of the right entry)^2
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from benchmarks.hidden_effects.in_common import in_common
from model import Measurements
from model.discrepancy.prepare import DiagnoseOptions, prepare
from model.discrepancy.search.evidence import Candidate, Projected, candidates
from model.effects.catalogue import catalogue
from model.effects.interface import Effect
from model.identification.data.data_vector import data_vector_of
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import linearise
from model.identification.likelihood.mixed_model_fit import (
    FitProblem,
    MixedModelFit,
    fit_mixed_model,
)
from model.identification.likelihood.noise.row_noise import noise_of
from model.measurements import FloatArray

ROUNDS = 8
SETTLED = 0.02  # standard deviations
KNOWN = 1e-3  # precision from which a base parameter counts as known beforehand
LARGEST_STEP = 20.0  # of ln B, and of the EIBM in 1/m


@dataclass(frozen=True)
class Visible:
    """What could be seen at best; the truth's business, not the diagnosis's."""

    d: tuple[float, ...]  # of each hidden effect, with the base refitted, and the others
    alone: tuple[float, ...]  # with the base refitted
    # by how many sigmas each further effect of the catalogue is farther away than the right entry,
    # of whichever hidden one it looks more like
    near: Mapping[str, float]
    # least share of d^2 that an effect of the catalogue leaves, as written, and its form tolerated
    left: Mapping[str, float]
    left_tolerant: Mapping[str, float]


def known(symmetric: bool, exclude: Sequence[str] = ()) -> list[Effect]:
    """The effects that `diagnose` considers."""
    asked = (e for name, e in catalogue().items() if name not in exclude)
    lacking = (e if symmetric else e.outside_base() for e in asked)
    found = (e.for_sessions(1) for e in lacking if e is not None)
    return [e for e in found if e is not None]


class Yardstick:
    """The session with nothing hidden, fitted.

    What is hidden may make conditions invalid; then those that are left are compared.
    """

    def __init__(self, bare: Measurements, symmetric: bool = False) -> None:
        self._session, self._options = bare, DiagnoseOptions(symmetric=symmetric)
        ready = prepare(bare, self._options)
        self._fitted = fit_mixed_model(ready.problem, ready.theta)
        self._bare = linearise(
            ready.problem.forward, ready.problem.bases, ready.problem.noise, self._fitted.theta
        ).residual

    def _beside(self, hidden: Sequence[Measurements]) -> tuple[Yardstick, list[Measurements]]:
        """Return the yardstick of what all of the sessions hold, and the sessions so."""
        bare, *others = in_common([self._session, *hidden])
        if bare is self._session:
            return self, others
        return Yardstick(bare, self._options.symmetric), others

    def signature(self, hidden: Measurements) -> tuple[FloatArray, MixedModelFit]:
        """What the base model cannot take up of a change, (N,), and the model where it is so.

        Of a session that holds what the yardstick's does.
        Parameters that are known beforehand, within a little, may take up as much as that allows.
        """
        problem, theta = self._problem(hidden), self._fitted.theta
        W, precision = self._fitted.solution.weights, self._fitted.linear.data.precision
        for _ in range(ROUNDS):
            linear = linearise(problem.forward, problem.bases, problem.noise, theta)
            rest, moved = linear.residual - self._bare, theta - self._fitted.theta
            WX = W @ linear.data.X
            A = np.einsum("rnp,rnq->pq", linear.data.X, WX) + np.diag(precision)
            b = np.einsum("rnp,rn->p", WX, problem.forward.row_index.pad(rest)) - precision * moved
            step = np.linalg.solve(A, b)
            if np.max(np.abs(step) * np.sqrt(np.diag(A))) < SETTLED:
                break
            theta = theta + step / max(1.0, float(np.max(np.abs(step))) / LARGEST_STEP)
        solution = replace(self._fitted.solution, covariance=np.linalg.inv(A))
        fitted = replace(
            self._fitted, problem=problem, theta=theta, linear=linear, solution=solution
        )
        known_before = precision > KNOWN
        return rest + linear.columns[:, known_before] @ moved[known_before], fitted

    def length(self, hidden: Measurements) -> float:
        """The detectability d."""
        yardstick, (hidden,) = self._beside([hidden])
        S, fitted = yardstick.signature(hidden)
        return float(np.sqrt(_products(fitted, S[:, None])[0, 0]))

    def _problem(self, hidden: Measurements) -> FitProblem:
        """The same design with other numbers."""
        own = self._fitted.problem
        data_vectors = [data_vector_of(hidden, name) for name in own.forward.names]
        forward = ForwardModel(
            data_vectors,
            [configuration_model.rest for configuration_model in own.forward.configuration_models],
        )
        return FitProblem.of(forward, own.bases, noise_of(forward))

    def visible(
        self,
        hidden: Measurements,
        parts: Sequence[Measurements],
        names: Sequence[str],
        exclude: Sequence[str] = (),
    ) -> Visible:
        """Of the effects of a session, each hidden alone in one of `parts`."""
        yardstick, (hidden, *parts) = self._beside([hidden, *parts])
        whole, fitted = yardstick.signature(hidden)
        alone = [whole] if len(parts) == 1 else [yardstick.signature(part)[0] for part in parts]
        effects = known(self._options.symmetric, exclude)
        return _compared(fitted, np.stack(alone, axis=1), names, effects)


def _products(fitted: MixedModelFit, S: FloatArray) -> FloatArray:
    """S'PS of columns (N, n)."""
    forward = fitted.problem.forward
    return Projected.of(forward, fitted.linear, fitted.solution).normal(forward, S)[0]


def _compared(
    fitted: MixedModelFit, S: FloatArray, names: Sequence[str], effects: Sequence[Effect]
) -> Visible:
    """Signatures (N, n) with one another and with the catalogue, the base as it is fitted."""
    A = _products(fitted, S)
    d = [float(np.sqrt(max(_without(_first(A, i), 1)[0, 0], 0.0))) for i in range(len(names))]
    far: list[dict[str, float]] = [{} for _ in d]  # least squared distance of each entry
    left: dict[str, float] = {}
    tolerant: dict[str, float] = {}
    for one in candidates(fitted, effects):
        for i, length in enumerate(d):
            others = np.delete(S, i, axis=1)
            columns = np.concatenate([S[:, i : i + 1], one.columns, others], axis=1)
            exact, free = _apart(
                _without(_products(fitted, columns), 1 + one.columns.shape[1]), one
            )
            far[i][one.name] = min(far[i].get(one.name, np.inf), exact)
            for shares, rest in ((left, exact), (tolerant, free)):
                share = rest / max(length**2, 1e-12)
                shares[one.name] = min(shares.get(one.name, 1.0), share)
    alone = tuple(np.sqrt(np.maximum(np.diag(A), 0.0)).tolist())
    return Visible(tuple(d), alone, _farther(far, names), left, tolerant)


def _farther(far: Sequence[Mapping[str, float]], names: Sequence[str]) -> dict[str, float]:
    """By how many sigmas each other entry is farther away than the right one."""
    near: dict[str, float] = {}
    for name, distances in zip(names, far, strict=True):
        own = distances.get(name, 0.0)  # none of its own: outside the catalogue, or taken out of it
        for other, distance in distances.items():
            if other not in names:
                away = float(np.sqrt(max(distance - own, 0.0)))
                near[other] = min(near.get(other, np.inf), away)
    return near


def _apart(A: FloatArray, one: Candidate) -> tuple[float, float]:
    """Squared distance of the first column from an effect as written, and its form tolerated."""
    if A[1, 1] <= 1e-12:
        return float(A[0, 0]), float(A[0, 0])
    assert one.effect is not None
    # where each sheet has its own size, the second column is the difference of the two
    sizes = 2 if one.effect.by_configuration and len(A) > 2 else 1
    fitted = np.linalg.lstsq(A[1 : 1 + sizes, 1 : 1 + sizes], A[1 : 1 + sizes, 0], rcond=1e-12)[0]
    exact = max(float(A[0, 0] - A[0, 1 : 1 + sizes] @ fitted), 0.0)
    precision = np.full(len(A) - 1, 1.0 / max(float(np.max(fitted**2)), 1e-12))
    precision[:sizes] = 0.0
    inner = np.linalg.lstsq(A[1:, 1:] + np.diag(precision), A[1:, 0], rcond=1e-12)[0]
    return exact, min(max(float(A[0, 0] - A[0, 1:] @ inner), 0.0), exact)


def _without(A: FloatArray, count: int) -> FloatArray:
    """S'PS of the first columns, the others refitted."""
    if count == len(A):
        return A
    inner = np.linalg.lstsq(A[count:, count:], A[count:, :count], rcond=1e-12)[0]
    result: FloatArray = A[:count, :count] - A[:count, count:] @ inner
    return result


def _first(A: FloatArray, i: int) -> FloatArray:
    """With another column in the first place."""
    order = [i, *(j for j in range(len(A)) if j != i)]
    return A[np.ix_(order, order)]
