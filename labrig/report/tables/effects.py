"""The catalogue of effects, as text and as JSON."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from labrig.report.parts.table import Table, number
from model.effects import Effect, EffectParameter

_WIDTH = 96
BESIDE_DYNAMICS = "a model with dynamics explains it; beside one it is only a deviation from it"


def catalogue_table(effects: Mapping[str, Effect]) -> Table:
    """All effects, by what they act on."""
    rows = tuple(
        (
            one.name,
            one.location.replace("_", " "),
            ", ".join(_parameters(one)),
            _sentence(one.meaning),
        )
        for one in effects.values()
    )
    columns = ("effect", "acts on", "parameters", "what it is")
    explained = [one.name for one in effects.values() if one.explained_by_dynamics]
    note = f"Explained by a model with dynamics, and deviations from it: {', '.join(explained)}."
    return Table(title=f"The catalogue: {len(rows)} effects", columns=columns, rows=rows, note=note)


def _sentence(text: str) -> str:
    """Return the beginning of a text, as much as a table has room for."""
    clause = re.split(r", because|[;:.](?: |$)", text, maxsplit=1)[0]
    return textwrap.shorten(clause, 90, placeholder=" ...")


def _parameters(one: Effect) -> list[str]:
    return [parameter.name for parameter in one.parameters] + list(one.extra)


def effect_lines(one: Effect) -> Iterator[str]:
    """Everything the catalogue says of an effect."""
    yield f"{one.name}, shown as: {one.title}" if one.title else one.name
    for title, text in (
        ("meaning", one.meaning), ("form", one.form), ("acts on", one.location.replace("_", " ")),
        ("signature", one.signature), ("isolated by", one.isolates), ("source", one.source),
    ):  # fmt: skip
        yield textwrap.fill(
            text, _WIDTH, initial_indent=f"  {title:12s}", subsequent_indent=" " * 14
        )
    if one.explained_by_dynamics:
        yield f"  {'dynamics':12s}{BESIDE_DYNAMICS}"


def parameter_table(one: Effect) -> Table:
    """Its parameters with units and bounds."""
    rows = [
        (
            p.name, p.unit or "-", number(p.prior_scale), _bound(p.low), _bound(p.high), p.meaning,
        )
        for p in one.parameters
    ]  # fmt: skip
    rows += [(name, unit or "-", "-", "-", "-", "derived") for name, unit in one.extra.items()]
    columns = ("parameter", "unit", "plausible", "least", "most", "what it is")
    own = "Each configuration has its own size. " if one.by_configuration else ""
    note = f"{own}Its form may differ along: {', '.join(one.form_error_along) or 'nothing'}."
    return Table(title="Parameters", columns=columns, rows=tuple(rows), note=note)


def _bound(value: float) -> str:
    return number(value, 4) if math.isfinite(value) else "none"


def effect_as_dict(one: Effect) -> dict[str, Any]:
    """One effect for `--json`."""
    return {
        "name": one.name, "slot": one.location, "meaning": one.meaning, "form": one.form,
        "signature": one.signature, "isolates": one.isolates, "source": one.source,
        "parameters": [_parameter_as_dict(p) for p in one.parameters],
        "derived": dict(one.extra),
        "by_configuration": one.by_configuration,
        "explained_by_dynamics": one.explained_by_dynamics,
        "form_may_differ_along": list(one.form_error_along),
    }  # fmt: skip


def _parameter_as_dict(parameter: EffectParameter) -> dict[str, Any]:
    return {
        "name": parameter.name, "unit": parameter.unit, "meaning": parameter.meaning,
        "plausible": parameter.prior_scale, "low": parameter.low, "high": parameter.high,
        "neutral": parameter.neutral,
    }  # fmt: skip
