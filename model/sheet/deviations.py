"""How the parameters of a configuration are uncertain together.

The sigma of each parameter says nothing of the others. The EIBM near the clamp and farther along
are uncertain in opposite ways; so are the mean EIBM and the length over which it falls. Here each
column changes all parameters at once, by one standard uncertainty; columns are independent.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from model.measurements import FloatArray, ModelError
from model.parameter import finite

STIFFNESS, FREEDOM = "B", "freedom"
USUAL_FREEDOM = 1e4
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
    """Rows by parameter, each with a number per column; the product of two is a covariance."""

    rows: Mapping[str, FloatArray] = field(default_factory=dict)
    freedom: FloatArray = field(default_factory=lambda: np.zeros(0))  # of each column

    def __len__(self) -> int:
        """Return the number of columns."""
        return len(self.freedom)

    def column(self, place: int) -> dict[str, float]:
        """Return what changes by one standard uncertainty, by parameter."""
        return {key: float(row[place]) for key, row in self.rows.items() if row[place]}

    def turned(self, rotation: FloatArray, freedom: FloatArray) -> Deviations:
        """Return other columns of the same covariance, or some of them: (m, n) orthonormal."""
        return Deviations({key: row @ rotation for key, row in self.rows.items()}, freedom)

    def to_dict(self) -> dict[str, Any]:
        """For a model file."""
        own = {key: row.tolist() for key, row in self.rows.items() if np.any(row)}
        return {FREEDOM: self.freedom.tolist(), **own}

    @staticmethod
    def from_dict(data: object, where: str) -> Deviations:
        """From a model file; `where` names the place in errors."""
        if not isinstance(data, dict) or not isinstance(data.get(FREEDOM), list):
            raise ModelError(f"{where}: a table with a list '{FREEDOM}' is wanted")
        rows = {}
        for key, row in data.items():
            if not isinstance(row, list) or len(row) != len(data[FREEDOM]):
                raise ModelError(f"{where}.{key}: as many numbers as in '{FREEDOM}' are wanted")
            rows[str(key)] = np.array([finite(v, f"{where}.{key}") for v in row])
        freedom = rows.pop(FREEDOM)
        if np.any(freedom <= 0.0):
            raise ModelError(f"{where}.{FREEDOM}: positive numbers are wanted")
        return Deviations(rows, freedom)


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
