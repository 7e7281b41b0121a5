"""The initial curvature k0, from the frames of the free sheet before its first voltage.

What sheet.toml states is a polygon, or rounded; a sheet in time is compared to hundredths of a
millimetre, so its difference to the shape at rest would be taken for motion.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from numpy.polynomial import legendre

from model.dynamics import DynamicBeam, Resolution
from model.dynamics.identification import RecordedRun
from model.dynamics.identification.predicted_run import predict
from model.measurements import FloatArray
from model.mechanics.field import Field

TERMS = 4  # of a polynomial in s
STATED_SIGMA_PER_M = 1.0  # how far what sheet.toml states may be off, each term
UNKNOWN_SIGMA_PER_M = 50.0
STEP_PER_M = 0.1  # of a difference quotient
ROUNDS = 3
FEWEST_FRAMES = 3


@dataclass(frozen=True, kw_only=True)
class MeasuredRest:
    """k0 as measured; `sigma_per_m` of it, (S,) at `s_m`."""

    rest: Field
    s_m: FloatArray
    sigma_per_m: FloatArray


def rest_curvature(
    beam: DynamicBeam, runs: Sequence[RecordedRun], curve_m: float, *, stated: bool = True
) -> MeasuredRest | None:
    """Return the initial curvature with which `beam` has the recorded free shape at rest.

    curve_m: standard deviation of a curve's point; it does not average out over frames. None where
    no free sheet was filmed at rest. Raises ModelError.
    """
    seen = [one for one in map(_at_rest, runs) if one is not None]
    if not seen:
        return None
    terms = [_term(j, beam.length_m) for j in range(TERMS)]
    sigma_per_m = STATED_SIGMA_PER_M if stated else UNKNOWN_SIGMA_PER_M
    precision = np.eye(TERMS) / sigma_per_m**2
    found, hessian = np.zeros(TERMS), precision
    for _ in range(ROUNDS):
        hessian, gradient = precision.copy(), -precision @ found
        for run in seen:
            at = _bent(beam, terms, found)
            away = _across(run, at, at) / curve_m
            moves = np.stack([
                (away - _across(run, _bent(beam, terms, found + STEP_PER_M * e), at) / curve_m)
                / STEP_PER_M for e in np.eye(TERMS)
            ], axis=1)  # fmt: skip
            hessian += moves.T @ moves
            gradient += moves.T @ away
        found = found + np.linalg.solve(hessian, gradient)
    s_m = np.linspace(0.0, beam.length_m, 41)
    modes = legendre.legvander(2.0 * s_m / beam.length_m - 1.0, TERMS - 1)
    covariance = np.linalg.inv(hessian)
    return MeasuredRest(
        rest=_bent(beam, terms, found).rest, s_m=s_m,
        sigma_per_m=np.sqrt(np.einsum("si,ij,sj->s", modes, covariance, modes)),
    )  # fmt: skip


def _term(degree: int, length_m: float) -> Field:
    row = np.eye(TERMS)[degree]
    return Field(np.array([0.0, length_m]), np.array([legendre.leg2poly(row[: degree + 1])]))


def _bent(beam: DynamicBeam, terms: list[Field], by: FloatArray) -> DynamicBeam:
    rest = beam.rest
    for term, amount in zip(terms, by.tolist(), strict=True):
        rest = rest + term * amount
    return replace(beam, rest=rest)


def _at_rest(run: RecordedRun) -> RecordedRun | None:
    """Return the mean of the frames before the first edge, as one frame; None without some."""
    plan = run.plan
    edges = plan.drive.time_s[plan.drive.time_s > 0.0]
    if plan.setup is not None or not len(edges) or run.x_m is None or run.y_m is None:
        return None
    before = plan.frame_s < edges[0]
    whole = before & np.isfinite(run.x_m + run.y_m).all(axis=1)
    if whole.sum() < FEWEST_FRAMES:
        return None
    quiet = replace(
        plan, force=False, current=False, time_s=np.zeros(0), frame_s=plan.frame_s[whole][:1]
    )
    return RecordedRun(
        plan=quiet, x_m=run.x_m[whole].mean(axis=0)[None], y_m=run.y_m[whole].mean(axis=0)[None]
    )


def _across(run: RecordedRun, beam: DynamicBeam, normal_of: DynamicBeam) -> FloatArray:
    """Return how far the recorded points are from the sheet, across `normal_of`, (p,)."""
    said = predict(beam, run.plan, Resolution())
    phi = predict(normal_of, run.plan, Resolution()).phi_rad
    assert run.x_m is not None  # noqa: S101 - as `_at_rest` makes it
    assert run.y_m is not None  # noqa: S101
    return np.asarray((np.cos(phi) * (run.y_m - said.y_m) - np.sin(phi) * (run.x_m - said.x_m))[0])
