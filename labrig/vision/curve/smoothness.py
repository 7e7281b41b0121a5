"""Smoothness priors of a sheet's curvature; the image decides among them.

Two kinds of priors, each of eight strengths: a curvature that wanders, int (dk/ds)^2 ds (the
minimum variation curve's), and one whose slope does, int (d2k/ds2)^2 ds. The second is what gels
and beams under forces are like; the first forgives a jump. A fit is the mean of all sixteen
answers, by how likely each prior makes the image; its covariance holds how much they differ.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]

PRIOR_TURNS_RAD = 10.0 ** np.arange(-2.0, 2.0, 0.5)  # that a prior lets a whole sheet make
USUAL_TURN_RAD = 2 * math.pi  # turn of a sheet with a curvature of usual size
JUMP_PRIORS = slice(0, len(PRIOR_TURNS_RAD))  # of the priors: those that forgive a jump
PRIOR_PROBABILITY_MIN = 1e-4  # an answer less likely than this is left out


def smooth_priors(first_form: FloatArray, second_form: FloatArray, length: float) -> FloatArray:
    """Return (16, n, n) information of each prior on the curvature's n coefficients.

    `first_form`, `second_form` (n, n): int (dk/ds)^2 ds and int (d2k/ds2)^2 ds as quadratic
    forms, of a sheet of this length. Weakly its curvature itself is of usual size, so that priors
    can be compared.
    """
    usual = (length / USUAL_TURN_RAD) ** 2 * np.eye(len(first_form))
    first_order = [first_form * length**3 / turn**2 for turn in PRIOR_TURNS_RAD]
    # a slope that so wanders leads about as far as a curvature that does
    second_order = [second_form * length**5 / 12 / turn**2 for turn in PRIOR_TURNS_RAD]
    return np.asarray([usual + each for each in first_order + second_order])


def block_diagonal(first: FloatArray, second: FloatArray) -> FloatArray:
    """Return (kinds, n + m, n + m) information on n coefficients and on m others.

    `first` (kinds, n, n), `second` (m, m).
    """
    kinds, n, m = len(first), first.shape[1], len(second)
    both = np.zeros((kinds, n + m, n + m))
    both[:, :n, :n], both[:, n:, n:] = first, second
    return both


def log_weights(priors: FloatArray) -> FloatArray:
    """Return (kinds,) half the logarithm of each prior's determinant."""
    return np.asarray(0.5 * np.linalg.slogdet(priors)[1])


def averaged(
    normal: FloatArray, pull: FloatArray, priors: FloatArray, log_weight: FloatArray
) -> FloatArray:
    """Return the parameters' mean over all priors.

    `normal @ parameters = pull` are the equations of the data; priors are on all parameters but the
    first two, which have theirs in `normal`.
    """
    answers, evidence, _ = _answers(normal, pull, priors, log_weight)
    odds = _odds(evidence)
    return np.asarray(odds @ answers)


def covariance(
    normal: FloatArray, pull: FloatArray, priors: FloatArray, log_weight: FloatArray
) -> FloatArray:
    """Return the parameters' covariance about that mean.

    Each answer's own, and how much they differ.
    """
    answers, evidence, factors = _answers(normal, pull, priors, log_weight)
    odds = _odds(evidence)
    likely = odds > PRIOR_PROBABILITY_MIN
    off = answers[likely] - odds @ answers
    root = np.linalg.inv(factors[likely])
    own = np.einsum("i,ikp,ikq->pq", odds[likely], root, root)
    return np.asarray(own + (off * odds[likely, None]).T @ off)


def _odds(evidence: FloatArray) -> FloatArray:
    odds = np.exp(evidence - evidence.max())
    return np.asarray(odds / odds.sum())


@jit
def _answers(
    normal: FloatArray, pull: FloatArray, priors: FloatArray, log_weight: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray]:
    """Return each prior's parameters, its evidence, and Cholesky's factor of its equations.

    Loops: to assign to a part of an array takes seconds to compile.
    """
    kinds, size = len(priors), len(pull)
    factors, answers = np.zeros((kinds, size, size)), np.zeros((kinds, size))
    evidence = np.zeros(kinds)
    for i in range(kinds):
        factor, answer = factors[i], answers[i]
        for p in range(size):
            answer[p] = pull[p]
            for q in range(size):
                factor[p, q] = normal[p, q]
                if p >= 2 and q >= 2:
                    factor[p, q] += priors[i, p - 2, q - 2]
        _factorise(factor)
        _forward(factor, answer)
        squares = 0.0
        for q in range(size):
            squares += answer[q] * answer[q]
        evidence[i] = log_weight[i] + 0.5 * squares
        for q in range(size):
            evidence[i] -= math.log(factor[q, q])
        _backward(factor, answer)
    return answers, evidence, factors


@jit
def _factorise(a: FloatArray) -> None:
    """Cholesky's factor, in place."""
    for i in range(len(a)):
        for j in range(i + 1):
            total = a[i, j]
            for q in range(j):
                total -= a[i, q] * a[j, q]
            a[i, j] = math.sqrt(total) if i == j else total / a[j, j]
        for j in range(i + 1, len(a)):
            a[i, j] = 0.0


@jit
def _forward(factor: FloatArray, x: FloatArray) -> None:
    for i in range(len(x)):
        for q in range(i):
            x[i] -= factor[i, q] * x[q]
        x[i] /= factor[i, i]


@jit
def _backward(factor: FloatArray, x: FloatArray) -> None:
    for i in range(len(x) - 1, -1, -1):
        for q in range(i + 1, len(x)):
            x[i] -= factor[q, i] * x[q]
        x[i] /= factor[i, i]
