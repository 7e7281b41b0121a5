"""A fitted design with a candidate measurement added: its geometry alone, without made-up data."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.discrepancy.next_measurement.menu import CandidateMeasurement
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.linearisation import Bases
from model.identification.likelihood.mixed_model_fit import (
    FitProblem,
    MixedModelFit,
    weighed_at,
)
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
    bases = problem.bases
    if bases.further is not None:  # planned data are those of a sheet at rest
        bases = replace(bases, further=bases.further.of_rows(forward.row_index.size))
    bases, theta = _with_half(bases, forward, fitted.theta)
    larger = FitProblem.of(forward, bases, noise_of(forward))
    # the effects that a model states stay in it, or the separations would be of another model
    return weighed_at(larger, theta, fitted.found, larger.noise_from(fitted.noise_found()))


def _with_half(bases: Bases, forward: ForwardModel, theta: FloatArray) -> tuple[Bases, FloatArray]:
    """Return bases and parameters with those of half voltages after all others.

    Each begins at half of the whole voltage's EIBM, and where that is one for both polarities the
    half voltages have one, too.
    """
    parts, more = [], list[float]()
    for one, own in zip(bases.parts, forward.data_vectors, strict=True):
        eibm, places = dict(one.eibm), dict[int, int]()
        for volts in (v for v in own.voltages_V if v not in one.eibm):
            whole, sign = one.eibm[2.0 * volts]
            if whole not in places:
                places[whole] = len(theta) + len(more)
                more.append(0.5 * float(theta[whole]))
            eibm[volts] = places[whole], sign
        parts.append(replace(one, eibm=eibm))
    larger = replace(bases, parts=tuple(parts), size=bases.size + len(more))
    return larger, np.concatenate([theta, more])
