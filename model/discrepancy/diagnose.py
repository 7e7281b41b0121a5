"""`diagnose`: from measurements to the effects that are not in the model."""

from __future__ import annotations

import time
from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from model.discrepancy.at_rest.at_rest import AtRest, at_rest, refuse_copies
from model.discrepancy.at_rest.outcome import with_dynamics
from model.discrepancy.at_rest.varied import Varied
from model.discrepancy.data_checks.check import CheckedData, check_data
from model.discrepancy.data_checks.outcome import contradiction, stopped, with_checks
from model.discrepancy.prepare import DiagnoseOptions, check_geometry, prepare, sessions, setups
from model.discrepancy.search.evidence import candidates
from model.discrepancy.search.forward_selection import search
from model.discrepancy.search.nonparametric_terms import unknowns
from model.discrepancy.search.null_calibration import null_gains, threshold
from model.discrepancy.search.order_of_positions import positions_in_order
from model.discrepancy.thresholds import (
    EVIDENCE_THRESHOLD_LN,
    FEWEST_SETUPS,
    LEAST_IMPROVEMENT,
)
from model.discrepancy.verdict.finding import Finding
from model.discrepancy.verdict.messages import nothing_separates
from model.discrepancy.verdict.result import Diagnosis, Next
from model.effects.catalogue import catalogue, effect
from model.effects.interface import Effect
from model.measurements import (
    Measurements,
    ModelError,
    Progress,
    scale_of_measurements,
    silent,
)

# of the time that a diagnosis takes: the search, and the calibration amid it where that is asked
_SEARCH_FROM, _SEARCH_TO = 0.05, 0.7
_CALIBRATION_FROM, _CALIBRATION_TO = 0.3, 0.45


def diagnose(
    measurements: Measurements,
    options: DiagnoseOptions | None = None,
    progress: Progress | None = None,
) -> Diagnosis:
    """Find the effects that the base model lacks; raise `ModelError` where it cannot be fitted."""
    began = time.perf_counter()
    options = options or DiagnoseOptions()
    say = progress or silent
    say(0.0, "checking the data")
    checked, rested = _checked(measurements, options)
    if checked.stops:
        return replace(stopped(checked), seconds=time.perf_counter() - began)
    finding = _searched(checked.measurements, options, say, rested.varied)
    result = with_checks(finding.diagnosis, checked)
    if options.model is not None:
        result = with_dynamics(result, rested, measurements, options.model)
    say(1.0, "done")
    return replace(result, seconds=time.perf_counter() - began)


def next_measurement(
    measurements: Measurements, between: tuple[str, ...], options: DiagnoseOptions | None = None
) -> Next:
    """Return which measurement separates effects best; raise `ModelError` where none does."""
    options = options or DiagnoseOptions()
    if len(set(between)) != 2 or len(between) != 2:
        raise ModelError("name two effects to be told apart, for example gravity and clamp_angle")
    for name in between:
        effect(name)  # an unknown name is refused before anything is fitted
    checked, rested = _checked(measurements, options)
    if checked.stops:
        raise ModelError(contradiction(checked))
    scale = scale_of_measurements(checked.measurements)
    chosen = [
        _in_sessions(name, sessions(checked.measurements)).at_scale(scale) for name in between
    ]
    finding = _searched(checked.measurements, options, silent, rested.varied)
    found = finding.separating(chosen)
    if found is None or found.expected <= found.separation * LEAST_IMPROVEMENT:
        raise ModelError(nothing_separates(between))
    return found


def _checked(measurements: Measurements, options: DiagnoseOptions) -> tuple[CheckedData, AtRest]:
    """Return measurements less what dynamics explain, as the data checks leave them.

    Where the dynamics have no answer the data as they are may say why; else raises ModelError.
    """
    if options.model is not None:
        refuse_copies(options.model)
    if options.model is None or not options.model.dynamic:
        return check_data(measurements), AtRest(measurements=measurements, dynamics={})
    for name, one in measurements.sheets.items():
        if name in options.model.dynamic:
            check_geometry(one, options.model.sheet(name).sheet)
    try:
        rested = at_rest(measurements, options.model)
    except ModelError:
        checked = check_data(measurements)
        if checked.stops:
            return checked, AtRest(measurements=measurements, dynamics={})
        raise
    checked = check_data(rested.measurements)
    return checked, rested.of(checked.measurements)


def _searched(
    measurements: Measurements,
    options: DiagnoseOptions,
    say: Progress,
    varied: Sequence[Varied],
) -> Finding:
    """Return the finished search of measurements that passed the data checks."""
    say(0.01, "fitting the base model")
    ready = prepare(measurements, options, varied)
    effects = _effects(options, measurements)
    if positions_in_order(ready.problem.forward.data_vectors):
        effects = [one.in_order_of_positions() for one in effects]

    enough = setups(ready) >= FEWEST_SETUPS
    calibrated = bool(options.calibrate) and enough
    limit, limit_from = EVIDENCE_THRESHOLD_LN, "the built-in value"
    if not enough:
        limit, limit_from = np.inf, "nothing is named: too few set-ups"
    outcome = search(
        ready.problem, ready.theta, effects, limit, options.most_effects, ready.found,
        _part(say, _SEARCH_FROM, _CALIBRATION_FROM if calibrated else _SEARCH_TO),
    )  # fmt: skip
    if calibrated:
        pool = [*candidates(outcome.base, effects), *unknowns(outcome.base)]
        simulating = _part(say, _CALIBRATION_FROM, _CALIBRATION_TO)
        gains = null_gains(outcome.base, pool, options.calibrate, options.seed, simulating)
        limit = threshold(gains)
        limit_from = f"{options.calibrate} simulated sessions of the base model"
        outcome = search(
            ready.problem, ready.theta, effects, limit, options.most_effects, ready.found,
            _part(say, _CALIBRATION_TO, _SEARCH_TO),
        )  # fmt: skip
    say(_SEARCH_TO, "comparing with other explanations")
    return Finding(
        measurements=measurements,
        options=options,
        ready=ready,
        outcome=outcome,
        effects=effects,
        threshold=limit,
        threshold_from=limit_from,
    )


def _part(say: Progress, first: float, last: float) -> Progress:
    """Return the progress of a part of the work, from one share of the whole to another."""

    def within(share: float, step: str) -> None:
        say(first + (last - first) * share, step)

    return within


def _in_sessions(name: str, count: int) -> Effect:
    found = effect(name).for_sessions(count)
    if found is None:
        raise ModelError(f"'{name}' needs several sessions analysed together; give all of them")
    return found


def _effects(options: DiagnoseOptions, measurements: Measurements) -> list[Effect]:
    """Return the effects to look for in the sessions and at the voltages that there are."""
    count, signs = sessions(measurements), np.sign([c.voltage_V for c in measurements.conditions])
    one_polarity = not (np.any(signs > 0.0) and np.any(signs < 0.0))
    every = catalogue()
    unknown = [name for name in options.exclude if name not in every]
    if unknown:
        raise ModelError(f"there is no effect called '{unknown[0]}'; `labrig effects` lists them")
    asked = (one for name, one in every.items() if name not in options.exclude)
    lacking = (one if options.symmetric else one.outside_base() for one in asked)
    of_these = (one.for_sessions(count) for one in lacking if one is not None)
    scale = scale_of_measurements(measurements)
    return [
        one.at_scale(scale)
        for one in of_these
        if one is not None and not (one_polarity and one.needs_both_polarities)
    ]
