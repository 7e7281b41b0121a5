"""The errors that a model file states: those of `predict` at the measured conditions."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.verdict.measured_places import Seen, seen_at
from model.identification.data.data_vector import ConditionData
from model.identification.likelihood.forward_model import ForwardModel
from model.identification.residuals import distance_to
from model.measurements import rms
from model.sheet import misfit
from model.sheet.sheet_model import SheetModel


@dataclass(frozen=True, kw_only=True)
class Error:
    """Errors of one condition, as those of a fit; NaN: not measured."""

    measured_N: float  # its mean force
    force_N: float
    curve_m: float  # RMS distance of the sheet itself, not its elongation


def with_stated_errors(
    model: SheetModel, forward: ForwardModel, without: Collection[int] = ()
) -> SheetModel:
    """Return the model with its errors; raise `ModelError` where it predicts nothing.

    Conditions `without`, by number over all, do not count, nor what no prediction is asked for:
    free shapes, and what was measured with the rig turned over.
    """
    own, first = dict[str, list[Error]](), 0
    for name, data_vector in zip(forward.names, forward.data_vectors, strict=True):
        some = [
            one for k, one in enumerate(data_vector.seen, first)
            if k not in without and not (one.free or one.zero or one.tilt_rad)
        ]  # fmt: skip
        first += len(data_vector.seen)
        own[name] = [
            error for number in sorted({one.session for one in some})
            for error in _errors(
                model.in_session(number), name, [o for o in some if o.session == number]
            )
        ]  # fmt: skip
    every = [error for errors in own.values() for error in errors]
    return model.with_merit(_merit(every), {name: _merit(errors) for name, errors in own.items()})


def _errors(model: SheetModel, name: str, some: Sequence[ConditionData]) -> list[Error]:
    """Return those of conditions of one session and configuration."""
    places = [(float(one.position_m), float(one.voltage_V)) for one in some]
    length_m = model.sheet(name).sheet.free_length_m
    seen = seen_at(model, name, places)
    return [_error(one, found, length_m) for one, found in zip(some, seen, strict=True)]


def _error(one: ConditionData, found: Seen, length_m: float) -> Error:
    measured_N = float(np.mean(one.kept_N)) if len(one.kept_N) else np.nan
    inside = found.s_m <= length_m * (1.0 + 1e-9)
    off_m = (
        np.nan
        if one.curve is None
        else distance_to(found.x_m[inside], found.y_m[inside], one.curve, length_m)
    )
    return Error(measured_N=measured_N, force_N=found.F_N - measured_N, curve_m=off_m)


def _merit(errors: Sequence[Error]) -> dict[str, float]:
    """Return the errors by the names that a model file has; those that exist."""
    merit = {
        misfit.FORCE: rms(np.array([e.force_N for e in errors])),
        misfit.CURVE: rms(np.array([e.curve_m for e in errors])),
        misfit.FORCE_SIZE: rms(np.array([e.measured_N for e in errors])),
    }
    return {name: value for name, value in merit.items() if np.isfinite(value)}
