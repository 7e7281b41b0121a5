"""What planned runs will say about each parameter, before time is spent on them."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from model.dynamics.beam import DynamicBeam
from model.dynamics.identification.noise import RecordingNoise
from model.dynamics.identification.parameters import LogParameters
from model.dynamics.identification.residuals import RunResiduals
from model.dynamics.identification.runs import RunPlan
from model.dynamics.identification.uncertainty import DynamicParameter, judged
from model.dynamics.motion import Resolution
from model.measurements import FloatArray, ModelError


def information(
    beam: DynamicBeam,
    runs: Sequence[RunPlan],
    noise: RecordingNoise,
    resolution: Resolution | None = None,
) -> tuple[DynamicParameter, ...]:
    """Return each parameter of `beam` with the uncertainty after these runs (Cramer & Rao's bound).

    The weak priors are those of `identify`. Raises ModelError.
    """
    return expected(beam, information_matrix(beam, runs, noise, resolution))


def expected(beam: DynamicBeam, matrix: FloatArray) -> tuple[DynamicParameter, ...]:
    """Return the same after runs of this information: matrices of several runs are summed."""
    parameters = LogParameters(beam)
    return judged(parameters, parameters.theta, matrix)[0]


def information_matrix(
    beam: DynamicBeam,
    runs: Sequence[RunPlan],
    noise: RecordingNoise,
    resolution: Resolution | None = None,
) -> FloatArray:
    """Return Fisher's information (p, p) of the logarithms. Raises ModelError."""
    if not runs:
        raise ModelError("there is no run whose information could be told")
    parameters = LogParameters(beam)
    theta, p = parameters.theta, len(parameters.theta)
    total = np.zeros((p, p))
    for run in runs:
        of = RunResiduals(run, noise, resolution or Resolution())
        J = of.sensitivity(parameters, theta, symmetric=True)
        total += J.T @ J
    return total
