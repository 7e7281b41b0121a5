"""The amplitude of a named effect in parts of the data: at each voltage, place, time, quantity.

The effect's own form, without any tolerance, acts with a factor of its own in each group of rows;
everything else stays in the model. An effect that is there acts everywhere with about the factor
one. The factors follow from one linear solution (generalised least squares).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.search.evidence import Projected
from model.discrepancy.search.form_share import steps_of
from model.identification.data.data_vector import Index
from model.identification.likelihood.linearisation import with_only
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray

VAGUE = 10.0  # prior standard deviation of a factor about one


@dataclass(frozen=True)
class Group:
    """Rows in which an effect may have a factor of its own."""

    title: str  # "at +2 V"
    rows: Index


@dataclass(frozen=True)
class GroupAmplitude:
    """The factor of an effect in a group; one: as the name says."""

    title: str
    factor: float
    sigma: float


def group_amplitudes(
    fitted: MixedModelFit, index: int, groups: Sequence[Group], log_sigma: FloatArray
) -> list[GroupAmplitude]:
    """Return the factors of the effect at this place among the effects found, by group."""
    forward = fitted.problem.forward
    whole = np.zeros(forward.row_index.size)
    for c, step in steps_of(fitted, index):
        whole += forward.rows_of(c, fitted.linear.states[c], step)
    parts = {}
    for group in groups:
        parts[group.title] = np.zeros(len(whole))
        parts[group.title][group.rows] = whole[group.rows]
    return amplitudes(fitted, index, parts, log_sigma)


def amplitudes(
    fitted: MixedModelFit, index: int, parts: Mapping[str, FloatArray], log_sigma: FloatArray
) -> list[GroupAmplitude]:
    """Return the factor of each part of an effect, by title; the parts (N,) add up to it."""
    forward, S = fitted.problem.forward, np.stack(list(parts.values()), axis=1)
    keep = np.setdiff1d(
        np.arange(fitted.linear.columns.shape[1]),
        np.arange(fitted.spans[index].start, fitted.spans[index].stop),
    )
    linear = with_only(fitted.linear, keep)
    A, b = Projected.of(forward, linear, weigh(linear.data, log_sigma)).normal(forward, S)
    covariance = np.linalg.inv(A + VAGUE**-2.0 * np.eye(len(parts)))
    factors, sigma = 1.0 + covariance @ b, np.sqrt(np.diag(covariance))
    return [
        GroupAmplitude(title, float(f), float(s))
        for title, f, s in zip(parts, factors, sigma, strict=True)
    ]
