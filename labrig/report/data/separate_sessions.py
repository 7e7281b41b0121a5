"""Sessions in one fit, each with parameters of its own: other days, other materials.

A configuration of a session is a sheet of its own, named long@FILE. What the sheets share is how
much set-ups scatter, which is a property of the rig.
"""

from __future__ import annotations

import os
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path

from labrig.errors import BadArgumentError
from model.measurements import Measurements

AT = "@"


def labels(paths: Sequence[Path]) -> list[str]:
    """Return a short name of each file."""
    for short in (
        [path.stem for path in paths],
        [f"{Path(os.path.realpath(path)).parent.name}-{path.stem}" for path in paths],
    ):
        if len(set(short)) == len(short):
            return short
    return [str(path) for path in paths]


def apart(parts: Sequence[Measurements], names: Sequence[str]) -> Measurements:
    """All of them as one, their configurations named after their sessions."""
    renamed = [_renamed(one, name) for one, name in zip(parts, names, strict=True)]
    first = renamed[0]
    sheets = {name: sheet for one in renamed for name, sheet in one.sheets.items()}
    order = list(dict.fromkeys(base(name) for name in sheets))
    return replace(
        first,
        sheets=dict(sorted(sheets.items(), key=lambda item: order.index(base(item[0])))),
        conditions=tuple(c for one in renamed for c in one.conditions),
        series=tuple(s for one in renamed for s in one.series),
        source=", ".join(one.source for one in renamed),
        warnings=tuple(text for one in renamed for text in one.warnings),
    )


def base(configuration: str) -> str:
    """Return the configuration without its session's name."""
    return configuration.split(AT, 1)[0]


def only(measurements: Measurements, wanted: Sequence[str]) -> Measurements:
    """Those of some configurations; BadArgumentError where one was not measured.

    A name without a session's stands for that configuration of all sessions.
    """
    if not wanted:
        return measurements
    known = list(dict.fromkeys(c.configuration for c in measurements.conditions))
    for name in wanted:
        if not any(name in (one, base(one)) for one in known):
            raise BadArgumentError(
                f"configuration {name}: nothing was measured of it; measured were "
                f"{', '.join(known) or 'none'}.",
                "configuration",
            )
    kept = {one for one in known if one in wanted or base(one) in wanted}
    return replace(
        measurements,
        sheets={name: sheet for name, sheet in measurements.sheets.items() if name in kept},
        conditions=tuple(c for c in measurements.conditions if c.configuration in kept),
        series=tuple(s for s in measurements.series if s.configuration in kept),
    )


def _renamed(measurements: Measurements, label: str) -> Measurements:
    def name(configuration: str) -> str:
        return f"{configuration}{AT}{label}"

    return replace(
        measurements,
        sheets={
            name(old): replace(sheet, configuration=name(old))
            for old, sheet in measurements.sheets.items()
        },
        conditions=tuple(
            replace(c, configuration=name(c.configuration)) for c in measurements.conditions
        ),
        series=tuple(replace(s, configuration=name(s.configuration)) for s in measurements.series),
    )
