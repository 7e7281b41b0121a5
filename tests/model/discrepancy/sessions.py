"""Sessions with something hidden in them, and what a diagnosis of them says; each made once."""

from __future__ import annotations

from dataclasses import replace
from functools import cache

from benchmarks.hidden_effects import Case, Extras, Hiding, case, hidden_session
from model.discrepancy import DiagnoseOptions, Diagnosis, diagnose
from model.discrepancy.prepare import prepare
from model.identification.likelihood.mixed_model_fit import MixedModelFit, fit_mixed_model
from model.measurements import Measurements
from tests.fits_unchecked import fits_unchecked

NOTHING = case(seed=1)
FALLING = Case((Hiding("nonuniform_eibm"),), seed=2)


@cache
def session(of: Case = NOTHING) -> Measurements:
    """What the rig handed over."""
    return hidden_session(of).measurements


def means_of(m: Measurements) -> Measurements:
    """The same as readings alone: no times, no curves of single readings, no series."""
    bare = {"time_s": None, "session_s": None, "wetted_s": None, "curve": None}
    conditions = [
        replace(c, readings=tuple(replace(r, **bare) for r in c.readings)) for c in m.conditions
    ]
    return replace(m, conditions=tuple(conditions), series=())


def of_one_sheet(m: Measurements, name: str) -> Measurements:
    """What was measured of one sheet, without series."""
    conditions = tuple(one for one in m.conditions if one.configuration == name)
    return replace(m, conditions=conditions, sheets={name: m.sheets[name]}, series=())


def without_first_pulses(m: Measurements) -> Measurements:
    """The same in which nobody wrote down what was discarded."""
    conditions = [
        replace(c, readings=tuple(r for r in c.readings if r.kind != "discarded"))
        for c in m.conditions
    ]
    return replace(m, conditions=tuple(conditions))


def fitted(m: Measurements, options: DiagnoseOptions = DiagnoseOptions()) -> MixedModelFit:  # noqa: B008 - frozen
    """The base model, settled."""
    ready = prepare(m, options)
    return fit_mixed_model(ready.problem, ready.theta, ready.found)


@cache
def base_fit(of: Case = NOTHING) -> MixedModelFit:
    """That of a session."""
    return fitted(session(of))


@cache
def diagnosed(of: Case = NOTHING, options: DiagnoseOptions = DiagnoseOptions()) -> Diagnosis:  # noqa: B008 - frozen
    """What is found, if nobody asks whether the data are right."""
    with fits_unchecked():
        return diagnose(session(of), options)


__all__ = [
    "FALLING",
    "NOTHING",
    "Case",
    "Extras",
    "Hiding",
    "base_fit",
    "diagnosed",
    "fitted",
    "means_of",
    "of_one_sheet",
    "session",
    "without_first_pulses",
]
