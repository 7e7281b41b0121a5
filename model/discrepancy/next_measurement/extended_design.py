"""A fitted design with a candidate measurement added: its geometry alone, without made-up data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.next_measurement.menu import CandidateMeasurement
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Bases, linearise
from model.identification.likelihood.mixed_model import weigh
from model.identification.likelihood.mixed_model_fit import FitProblem, MixedModelFit
from model.identification.likelihood.noise.row_noise import noise_of
from model.measurements import FloatArray


def extended(fitted: MixedModelFit, entry: CandidateMeasurement) -> MixedModelFit:
    """Return the design with an entry added: only its geometry counts, no data are made up."""
    problem = fitted.problem
    data_vectors = [
        replace(one, seen=(*one.seen, *entry.add(one))) for one in problem.forward.data_vectors
    ]
    rests = [
        configuration_model.rest for configuration_model in problem.forward.configuration_models
    ]
    forward = ForwardModel(data_vectors, rests, like=problem.forward)
    noise = noise_of(forward)
    bases = problem.bases
    if bases.further is not None:  # planned data are those of a sheet at rest
        bases = replace(bases, further=bases.further.of_rows(forward.row_index.size))
    larger = FitProblem.of(forward, bases, noise)
    if any(
        len(a.voltages_V) != len(b.voltages_V)
        for a, b in zip(data_vectors, problem.forward.data_vectors, strict=True)
    ):
        bases = _with_half(replace(problem, bases=bases), forward)
        larger = replace(larger, bases=bases)
    theta = fitted.theta
    if bases.size > problem.bases.size:
        theta = np.concatenate([theta, _half_start(problem, bases, theta)])
    linear = linearise(forward, bases, noise, theta)
    log_sigma = larger.guess.copy()
    n = min(len(log_sigma), len(fitted.solution.log_sigma))
    log_sigma[:n] = fitted.solution.log_sigma[:n]
    return MixedModelFit(
        problem=larger,
        theta=theta,
        found=(),
        linear=linear,
        solution=weigh(linear.data, log_sigma),
        deviance=0.0,
        spans=(),
    )


def _with_half(problem: FitProblem, forward: ForwardModel) -> Bases:
    """Parameters of the further voltages, after all others."""
    parts, place = [], problem.bases.size
    for one, own in zip(problem.bases.parts, forward.data_vectors, strict=True):
        eibm = dict(one.eibm)
        for volts in own.voltages_V:
            if volts not in eibm:
                eibm[volts], place = (place, 1.0), place + 1
        parts.append(replace(one, eibm=eibm))
    return replace(problem.bases, parts=tuple(parts), size=place)


def _half_start(problem: FitProblem, bases: Bases, theta: FloatArray) -> FloatArray:
    more = np.zeros(bases.size - problem.bases.size)
    for one in bases.parts:
        for volts, (i, _) in one.eibm.items():
            if i >= problem.bases.size:
                like = one.eibm.get(2.0 * volts)
                more[i - problem.bases.size] = 0.5 * theta[like[0]] if like else 0.0
    return more
