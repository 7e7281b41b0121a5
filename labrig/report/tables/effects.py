"""The catalogue of effects, for a person and as JSON."""

from __future__ import annotations

import math
import re
import textwrap
from collections.abc import Iterator, Mapping
from typing import Any

from labrig.report.parts.table import Table, number
from model.effects import Effect, EffectParameter

_WIDTH = 96


def catalogue_table(effects: Mapping[str, Effect]) -> Table:
    """All effects, by what they act on."""
    rows = tuple(
        (one.name, one.slot.replace("_", " "), ", ".join(_parameters(one)), _sentence(one.meaning))
        for one in effects.values()
    )
    columns = ("effect", "acts on", "parameters", "what it is")
    return Table(f"The catalogue: {len(rows)} effects", columns, rows)


def _sentence(text: str) -> str:
    """The beginning of a text, as much as a table has room for."""
    clause = re.split(r", because|[;:.](?: |$)", text, maxsplit=1)[0]
    return textwrap.shorten(clause, 90, placeholder=" ...")


def _parameters(one: Effect) -> list[str]:
    return [knob.name for knob in one.knobs] + list(one.extra)


def effect_lines(one: Effect) -> Iterator[str]:
    """Everything the catalogue says of an effect."""
    yield one.name
    for title, text in (
        ("meaning", one.meaning), ("form", one.form), ("acts on", one.slot.replace("_", " ")),
        ("signature", one.signature), ("isolated by", one.isolates), ("source", one.source),
    ):  # fmt: skip
        yield textwrap.fill(
            text, _WIDTH, initial_indent=f"  {title:12s}", subsequent_indent=" " * 14
        )


def knob_table(one: Effect) -> Table:
    """Its parameters with units and bounds."""
    rows = [
        (
            knob.name, knob.unit or "-", number(knob.plausible), _bound(knob.low),
            _bound(knob.high), knob.meaning,
        )
        for knob in one.knobs
    ]  # fmt: skip
    rows += [(name, unit or "-", "-", "-", "-", "derived") for name, unit in one.extra.items()]
    columns = ("parameter", "unit", "plausible", "least", "most", "what it is")
    own = "Each configuration has its own size. " if one.by_configuration else ""
    note = f"{own}Its form may differ along: {', '.join(one.tolerance) or 'nothing'}."
    return Table("Parameters", columns, tuple(rows), note)


def _bound(value: float) -> str:
    return number(value, 4) if math.isfinite(value) else "none"


def effect_as_dict(one: Effect) -> dict[str, Any]:
    """One effect for `--json`."""
    return {
        "name": one.name, "slot": one.slot, "meaning": one.meaning, "form": one.form,
        "signature": one.signature, "isolates": one.isolates, "source": one.source,
        "parameters": [_knob_as_dict(knob) for knob in one.knobs],
        "derived": dict(one.extra),
        "by_configuration": one.by_configuration,
        "form_may_differ_along": list(one.tolerance),
    }  # fmt: skip


def _knob_as_dict(knob: EffectParameter) -> dict[str, Any]:
    return {
        "name": knob.name, "unit": knob.unit, "meaning": knob.meaning,
        "plausible": knob.plausible, "low": knob.low, "high": knob.high, "neutral": knob.neutral,
    }  # fmt: skip
