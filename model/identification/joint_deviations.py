"""How B, the EIBM along the sheet and k0 of a joint fit are uncertain together."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from model.identification.along_runs import eibm_along_runs
from model.identification.joint import Joint
from model.measurements import FloatArray
from model.mechanics.field import legendre_field
from model.sheet.deviations import (
    STIFFNESS,
    Deviations,
    columns_of,
    curvature_key,
    eibm_key,
    few_changes,
    few_columns,
)

PLACES = 25  # along the sheet, at which it is seen how much a deviation turns it
NEGLIGIBLE = 0.1  # of the mean EIBM's standard uncertainty: 0.5 % of the whole
LEFT_OUT = 0.01  # of the variance of the angle anywhere, and of B


def deviations(joint: Joint, n: int) -> Deviations:
    """Return those of the model with the EIBM along the sheet.

    Forces and shapes know of a deviation by how it turns the sheet: those that turn it nowhere are
    left out. Last comes, for each voltage, how far the EIBM of a single reading is from that of
    their mean.
    """
    own = joint.own_parameters(n)
    covariance = joint.fitted.covariance[np.ix_(own, own)]
    columns = columns_of(covariance)
    moves = np.zeros((len(joint.fitted.theta), columns.shape[1]))
    moves[own] = columns
    # systematic: where the shape at 0 V is not as stated, was it bent, or was there a moment?
    doubt = np.zeros(len(joint.fitted.theta))
    rest = list(joint.fitted.problem.bases.parts[n].rest)
    if joint.rest_counts(n):
        doubt[rest] = joint.fitted.theta[rest] / np.sqrt(12.0)
    changes = joint.fitted.spread.changes(joint.fitted.solution.covariance, own, columns)
    # the estimated scatter says nothing of the systematic doubt, the last column
    changes = np.pad(changes, ((0, 0), (0, 1), (0, 1)))
    found = Deviations(_rows(joint, n, moves, doubt), changes)
    found = found.turned(few_columns(found, _turns(joint, n, found.rows), LEFT_OUT))
    return _with_runs(joint, n, replace(found, changes=few_changes(found.changes)))


def _with_runs(joint: Joint, n: int, found: Deviations) -> Deviations:
    """Return the deviations with those of single readings; those that are negligible left out."""
    for voltage, share in eibm_along_runs(joint, n).items():
        mean = joint.terms(n, voltage)
        own = {eibm_key(voltage, k): share * much for k, much in enumerate(mean.tolist())}
        sigma = float(np.linalg.norm(found.rows[eibm_key(voltage, 0)]))
        if abs(own[eibm_key(voltage, 0)]) > NEGLIGIBLE * sigma:
            found = found.with_column(own)
    return found


def _rows(joint: Joint, n: int, moves: FloatArray, doubt: FloatArray) -> dict[str, FloatArray]:
    """Return the rows by parameter; the last column is the systematic doubt."""
    part, theta = joint.fitted.problem.bases.parts[n], joint.fitted.theta
    B = joint.stiffness(n).value
    rows = {STIFFNESS: np.append(B * moves[part.stiffness], 0.0)}
    for k, i in enumerate(part.rest):
        rows[curvature_key(k)] = np.append(moves[i], doubt[i])
    counted = dict(enumerate(part.rest)) if joint.rest_counts(n) else {}
    for voltage, (first, sign) in part.eibm.items():
        for k in range(len(part.forms)):
            i, j = first + k, counted.get(k)
            much, less = sign * theta[i], 0.0
            if j is not None:
                much, less = much + theta[j], -B * doubt[j]
            change = B * (sign * moves[i] + much * moves[part.stiffness])
            rows[eibm_key(voltage, k)] = np.append(change, less)
    return rows


def _turns(joint: Joint, n: int, rows: Mapping[str, FloatArray]) -> list[FloatArray]:
    """Return what the columns change of B, and of the angle along the sheet at each voltage."""
    part, length = joint.fitted.problem.bases.parts[n], joint.forward.configuration_models[n].length
    theta, B = joint.fitted.theta, joint.stiffness(n).value
    s, none = np.linspace(0.0, length, PLACES + 1)[1:], np.zeros_like(rows[STIFFNESS])
    terms = range(max(len(part.forms), len(part.rest)))
    angle = np.stack([legendre_field(k, length).integral(s) for k in terms], axis=1)
    rest = np.stack([rows.get(curvature_key(k), none) for k in terms])
    result = [rows[STIFFNESS][None], angle @ rest]
    for voltage, (first, sign) in part.eibm.items():
        moment = np.stack([rows.get(eibm_key(voltage, k), none) for k in terms])
        much = np.zeros(len(terms))
        much[: len(part.forms)] = sign * theta[first : first + len(part.forms)]
        if joint.rest_counts(n):
            much[: len(part.rest)] += theta[list(part.rest)]
        bent = (moment - much[:, None] * rows[STIFFNESS]) / B
        result.append(angle @ (rest + bent))
    return result
