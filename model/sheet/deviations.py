"""How the parameters of a configuration are uncertain together.

The sigma of each parameter says nothing of the others. The EIBM near the clamp and farther along
are uncertain in opposite ways; so are the mean EIBM and the length over which it falls. Here each
column changes all parameters at once, by one standard uncertainty; columns are independent.

Their variances are uncertain, too, and not independently: the scatter from one set-up to the next,
of which few set-ups know little, is in all of them. So the degrees of freedom of an answer are not
those of a sum of independent variances; `changes` says how all covariances go together.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from model.measurements import FloatArray, ModelError
from model.parameter import finite

STIFFNESS, FREEDOM, CHANGES = "B", "freedom", "covariance_changes"
LEAST_FREEDOM, USUAL_FREEDOM = 2.0, 1e4
SHARE_LEFT_OUT = 1e-3  # of the changes of covariances, of their sum of squares
DIGITS = 4  # of them, in a file
LEAST_SHARE = 1e-12  # of the largest variance; below it is rounding


def curvature_key(term: int) -> str:
    """Of the initial curvature, 1/m: a Legendre polynomial along the measured free length."""
    return f"initial_curvature {term}"


def eibm_key(voltage_V: float, term: int) -> str:
    """Of the EIBM at a voltage, N m: a Legendre polynomial along the measured free length."""
    return f"eibm {float(voltage_V)} {term}"


def effect_key(place: int, parameter: str) -> str:
    """Of an effect's parameter; effects are counted from 0."""
    return f"effect {place} {parameter}"


def form_key(place: int, term: int, node: int) -> str:
    """Of a node of a term of an effect's form."""
    return f"effect {place} form {term} {node}"


@dataclass(frozen=True)
class Deviations:
    """Rows by parameter, each with a number per column; the product of two is a covariance.

    The covariance of the columns' own numbers is the identity, but it is uncertain: `changes` are
    symmetric matrices, what it changes by, each by one standard uncertainty, independently.
    """

    rows: Mapping[str, FloatArray] = field(default_factory=dict)
    changes: FloatArray = field(default_factory=lambda: np.zeros((0, 0, 0)))  # (R, columns, same)

    def __len__(self) -> int:
        """Return the number of columns."""
        return int(self.changes.shape[1])

    def column(self, place: int) -> dict[str, float]:
        """Return what changes by one standard uncertainty, by parameter."""
        return {key: float(row[place]) for key, row in self.rows.items() if row[place]}

    def freedom(self, parts: FloatArray) -> FloatArray:
        """Return Satterthwaite's degrees of freedom of answers.

        parts: (columns, answers), what each column changes of each answer.
        """
        changed = np.einsum("ka,rkl,la->ra", parts, self.changes, parts)
        doubt = np.maximum(np.sum(changed**2, axis=0), 1e-300)
        free = 2.0 * np.sum(parts**2, axis=0) ** 2 / doubt
        return np.asarray(np.clip(free, LEAST_FREEDOM, USUAL_FREEDOM))

    def turned(self, rotation: FloatArray) -> Deviations:
        """Return other columns of the same covariance, or some of them: (m, n) orthonormal."""
        rows = {key: row @ rotation for key, row in self.rows.items()}
        return Deviations(rows, rotation.T @ self.changes @ rotation)

    def with_column(self, column: Mapping[str, float]) -> Deviations:
        """Return the deviations with a further column, whose variance is known."""
        rows = {key: np.append(row, column.get(key, 0.0)) for key, row in self.rows.items()}
        return Deviations(rows, np.pad(self.changes, ((0, 0), (0, 1), (0, 1))))

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        own = {key: row.tolist() for key, row in self.rows.items() if np.any(row)}
        upper = self.changes[:, *np.triu_indices(len(self))]
        changes = [[float(f"{much:.{DIGITS}g}") for much in one] for one in upper.tolist()]
        return {FREEDOM: self.freedom(np.eye(len(self))).tolist(), CHANGES: changes, **own}

    @staticmethod
    def from_dict(data: object, where: str) -> Deviations:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or not isinstance(data.get(FREEDOM), list):
            raise ModelError(f"{where}: a table with a list '{FREEDOM}' is wanted")
        count = len(data[FREEDOM])
        rows = {
            str(key): _numbers(row, count, f"{where}.{key}", f"as many numbers as in '{FREEDOM}'")
            for key, row in data.items()
            if key != CHANGES
        }
        freedom = rows.pop(FREEDOM)
        if np.any(freedom <= 0.0):
            raise ModelError(f"{where}.{FREEDOM}: positive numbers are wanted")
        if CHANGES in data:
            return Deviations(rows, _changes(data[CHANGES], count, f"{where}.{CHANGES}"))
        return Deviations(rows, independent(freedom))  # older files say nothing else


def independent(freedom: FloatArray) -> FloatArray:
    """Return `changes` of columns whose variances are uncertain independently."""
    one_each = np.eye(len(freedom))
    return np.asarray(np.einsum("rk,rl,r->rkl", one_each, one_each, np.sqrt(2.0 / freedom)))


def few_changes(changes: FloatArray) -> FloatArray:
    """Return few matrices that say of every answer nearly what all of them say: (R, k, k)."""
    R, k, _ = changes.shape
    _, size, ways = np.linalg.svd(changes.reshape(R, k * k), full_matrices=False)
    left = np.cumsum((size**2)[::-1])[::-1]
    kept = left > SHARE_LEFT_OUT * left[:1]
    return np.asarray((size[kept, None] * ways[kept]).reshape(-1, k, k))


def _changes(data: object, count: int, where: str) -> FloatArray:
    """Return symmetric matrices from the rows of their upper triangles."""
    if not isinstance(data, list):
        raise ModelError(f"{where}: a list of lists of numbers is wanted")
    upper = np.triu_indices(count)
    changes = np.zeros((len(data), count, count))
    for one, row in zip(changes, data, strict=True):
        one[upper] = _numbers(row, len(upper[0]), where, f"{len(upper[0])} numbers in each list")
    return changes + np.triu(changes, 1).transpose(0, 2, 1)


def _numbers(row: object, count: int, where: str, wanted: str) -> FloatArray:
    if not isinstance(row, list) or len(row) != count:
        raise ModelError(f"{where}: {wanted} are wanted")
    return np.array([finite(v, where) for v in row], dtype=float)


def columns_of(covariance: FloatArray) -> FloatArray:
    """Return D with D D^T = covariance, (p, m): its principal axes, the longest first."""
    variance, axes = np.linalg.eigh(covariance)
    kept = variance > LEAST_SHARE * max(float(variance.max(initial=0.0)), 1e-300)
    return np.asarray((axes * np.sqrt(np.maximum(variance, 0.0)))[:, kept][:, ::-1])


def few_columns(found: Deviations, seen: Sequence[FloatArray], left_out: float) -> FloatArray:
    """Return a rotation to few columns, (m, n), by what is seen of them: rows (., m).

    What all columns left out change of each row is at most `left_out` of its variance.
    """
    rows = np.concatenate([*seen, np.zeros((1, len(found)))])
    size = np.linalg.norm(rows, axis=1)
    rows = rows[size > 0.0] / size[size > 0.0, None]
    rotation = np.linalg.svd(rows)[2].T
    share = np.cumsum((rows @ rotation) ** 2, axis=1).min(axis=0, initial=1.0)
    count = int(np.searchsorted(share, 1.0 - left_out)) + 1
    return np.asarray(rotation[:, :count])
