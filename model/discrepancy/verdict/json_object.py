"""A diagnosis as the object that `diagnose --json` prints."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

import numpy as np

from model.effects import title

if TYPE_CHECKING:
    from model.discrepancy.verdict.result import (
        ChosenValue,
        ClosedGap,
        Diagnosis,
        Named,
        Next,
        Promise,
        Unknown,
        Where,
    )
    from model.parameter import Parameter


def diagnosis_object(found: Diagnosis) -> dict[str, Any]:
    """Return the object; what does not exist is null."""
    return {
        "verdict": found.verdict,
        "effects": [_named(e) for e in found.effects],
        "invisible": list(found.invisible),
        "unknown": None if found.unknown is None else _unknown(found.unknown),
        "where": [_where(w) for w in found.where],
        "gap": {"fitted": found.fitted.to_json(), "held_out": found.held_out.to_json()},
        "gap_closed": _closed(found.closed_gap),
        "noise_floor": None if found.floor is None else found.floor.to_json(),
        "next_measurement": _next(found.next_measurement),
        "promises": [_promise(one) for one in found.promises],
        "sentence": found.sentence,
        "notes": list(found.notes),
        "data_checks": [one.to_json() for one in found.data_checks],
        **({"plugins": dict(found.plugins)} if found.plugins else {}),
    }


def _named(one: Named) -> dict[str, Any]:
    return {
        "name": one.name,
        "title": title(one.name),
        "slot": one.location,
        "parameters": {k: _parameter(p) for k, p in one.parameters.items()},
        "parameters_of": one.configuration or None,
        "interval90": {k: [number(v) for v in p.interval()] for k, p in one.parameters.items()},
        "by_configuration": {
            name: {
                k: {**_parameter(p), "interval90": [number(v) for v in p.interval()]}
                for k, p in own.items()
            }
            for name, own in one.by_configuration.items()
        },
        "confidence": round(one.confidence, 6),
        "confusable_with": list(one.confusable_with),
        "probabilities": {k: round(p, 6) for k, p in one.probabilities.items()},
        "form_share": round(one.form_share, 4),
        **({"choices": {k: _choice(c) for k, c in one.choices.items()}} if one.choices else {}),
    }


def _parameter(one: Parameter) -> dict[str, float | None]:
    return {"value": number(one.value), "sigma": number(one.sigma)}


def _closed(one: ClosedGap | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "share": round(one.share, 4), "quantity": one.quantity, "before": one.before,
        "after": one.after, "floor": one.floor, "unit": one.unit,
    }  # fmt: skip


def _next(one: Next | None) -> dict[str, Any] | None:
    if one is None:
        return None
    return {
        "why": one.why,
        "protocol": dict(one.protocol),
        "between": list(one.between),
        "separation_now": number(one.separation),
        "separation_expected": number(one.expected),
        "minutes": number(one.minutes),
    }


def _promise(one: Promise) -> dict[str, Any]:
    return {
        "between": list(one.proposal.between),
        "extra": one.proposal.extra,
        "separation_before": number(one.proposal.separation),
        "separation_promised": number(one.proposal.expected),
        "separation_found": number(one.found),
    }


def _choice(one: ChosenValue) -> dict[str, Any]:
    others = [{"meaning": m, "probability": round(p, 6)} for m, p in one.alternatives]
    return {
        "value": one.value,
        "meaning": one.meaning,
        "probability": round(one.probability, 6),
        "alternatives": others,
    }


def _unknown(one: Unknown) -> dict[str, Any]:
    return {
        "slot": one.location,
        "s_mm": one.s_mm.tolist(),
        "profile": one.profile.tolist(),
        "band": one.band.tolist(),
        "unit": one.unit,
        "along": one.along,
        "configuration": one.configuration,
        "depends": one.depends,
    }


def _where(one: Where) -> dict[str, Any]:
    result: dict[str, Any] = {
        "observable": one.observable, "configuration": one.configuration,
        "voltage_V": one.voltage_V, "position_mm": one.position_mm, "s_mm": one.s_mm,
        "z": round(one.z, 2),
    }  # fmt: skip
    if one.detail:
        result["detail"] = one.detail
    return result


def number(value: float) -> float | None:
    """Return a number that JSON has; others are null."""
    return float(value) if np.isfinite(value) else None
