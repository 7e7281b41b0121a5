"""The numbers that a report begins with, and its caveats."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Final, Literal

import numpy as np

from labrig.report.data.findings import Findings
from labrig.report.data.models import ALONG, CONSTANT
from labrig.report.data.paper import PAPER
from labrig.report.data.quality import MOST_WARNINGS
from labrig.report.data.selection import rest_position_m
from labrig.report.diagnosis.tables import suspicion_sentence
from labrig.report.parts.table import fixed, number, volts, with_sigma
from model import ConfigurationFit, Parameter
from protocols.execution.events import Outcome, OutputState

_KINDS: Final[tuple[tuple[Literal["varying", "constant"], str], ...]] = (
    ("varying", ALONG),
    ("constant", f"{CONSTANT}, B held"),
)
Parts = Mapping[str, ConfigurationFit]


@dataclass(frozen=True)
class Card:
    """A few numbers of one kind: (name, value, the paper's)."""

    title: str
    lines: tuple[tuple[str, str, str], ...]


def cards(found: Findings) -> list[Card]:
    """Return the session itself first, then the sheets' parameters and the model's errors."""
    made = [_session(found)]
    if found.fit is not None:
        parts = found.fit.configurations
        made += [_stiffness(parts), _eibm(parts), _forces(parts), *_curves(parts)]
    return made + _rest(found)


def _session(found: Findings) -> Card:
    session = found.session
    done = sum(run.completed for run in session.runs)
    lines = [("outcome", session.outcome.value, "")]
    if session.runs:
        lines.append(("runs complete", f"{done} of {len(session.runs)}", ""))
    if found.measurements is not None:
        conditions = found.measurements.conditions
        readings = [reading for c in conditions for reading in c.readings]
        good = sum(reading.valid for reading in readings)
        curves = sum(c.curve is not None for c in conditions)
        lines.append(("readings valid", f"{good} of {len(readings)}", ""))
        lines.append(("neutral curves", f"{curves} of {len(conditions)}", ""))
    return Card("Session", tuple(lines))


def _stiffness(parts: Parts) -> Card:
    lines = [(f"{name}: B, µN·m²", _stiff(one, one.B, 1e6), "") for name, one in parts.items()]
    lines += [(f"{name}: E, MPa", _stiff(one, one.E, 1e-6), "") for name, one in parts.items()]
    return Card("Bending stiffness B, Young's modulus E", tuple(lines))


def _stiff(one: ConfigurationFit, parameter: Parameter, factor: float) -> str:
    """Return what follows from forces; without them B was taken, not measured."""
    if one.B_known:
        return _scaled(parameter, factor)
    return f"{number(factor * parameter.value, 3)} (taken)"


def _eibm(parts: Parts) -> Card:
    lines = [
        (
            f"{name}, {volts(v)}" + (", B taken" if not one.B_known else ""),
            _scaled(one.eibm[v], 1e6),
            "",
        )
        for name, one in parts.items()
        for v in sorted(one.eibm, reverse=True)
    ]
    return Card("Constant EIBM, µN·m", tuple(lines))


def _scaled(parameter: Parameter, factor: float) -> str:
    return with_sigma(factor * parameter.value, factor * parameter.sigma)


def _forces(parts: Parts) -> Card:
    lines = [
        (
            f"{name}, {text}",
            fixed(1e3 * one.rmse[kind].force_N, 3),
            fixed(PAPER[name].force_rmse_mN[place], 3) if name in PAPER else "",
        )
        for name, one in parts.items()
        for place, (kind, text) in enumerate(_KINDS)
    ]
    return Card("Force error (RMSE), mN", tuple(lines))


def _curves(parts: Parts) -> list[Card]:
    lines = [
        (
            f"{name}, {text}",
            fixed(1e3 * one.rmse[kind].curve_m, 3),
            fixed(PAPER[name].curve_rmse_mm[place], 2) if name in PAPER else "",
        )
        for name, one in parts.items()
        for place, (kind, text) in enumerate(_KINDS)
        if np.isfinite(one.rmse[kind].curve_m)
    ]
    return [Card("Curve error (RMSE), mm", tuple(lines))] if lines else []


def _rest(found: Findings) -> list[Card]:
    if found.measurements is None:
        return []
    places = {name: rest_position_m(found.measurements, name) for name in found.names}
    lines = [
        (
            name,
            fixed(1e3 * place, 1),
            fixed(PAPER[name].rest_position_mm, 0) if name in PAPER else "",
        )
        for name, place in places.items()
        if place is not None
    ]
    return [Card("Rest position of the undriven sheet, mm", tuple(lines))] if lines else []


def remarks(found: Findings) -> list[str]:
    """Return the caveats, a sentence each; empty when there are none."""
    session, caveats = found.session, list[str]()
    if session.outcome is not Outcome.COMPLETED:
        reason = session.reason.rstrip(".") or "no reason was recorded"
        caveats.append(f"The session did not end as planned: {session.outcome.value} ({reason}).")
    if session.runs and session.output_state is not OutputState.SAFE:
        caveats.append(f"Output at the end: {session.output_state.value}.")
    if found.measurements is None:
        caveats.append(f"Nothing could be measured: {found.why_not}")
    elif not found.names:
        caveats.append("No condition was measured.")
    if len(found.names) == 1:
        caveats.append(f"Only the configuration {found.names[0]} was measured.")
    for name, why in found.fitted.missing.items():
        caveats.append(f"The configuration {name} could not be fitted: {why.rstrip('.')}.")
    caveats += [suspicion_sentence(one) for one in found.suspicions]
    caveats += found.quality.remarks
    if found.measurements is not None:
        warned = found.measurements.warnings
        caveats += [text.rstrip(".") + "." for text in warned[:MOST_WARNINGS]]
        if len(warned) > MOST_WARNINGS:
            caveats.append(
                f"{len(warned) - MOST_WARNINGS} more are listed with the data's quality."
            )
    return caveats
