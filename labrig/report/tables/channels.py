"""The channels of a session: what each measures, and between which values its readings lie."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from labrig.report.parts.table import Table
from labrig.session import RecordedSession

_COLUMNS = ("channel", "quantity", "unit", "input range", "smallest reading", "largest reading")


@dataclass(frozen=True, kw_only=True)
class ChannelSummary:
    """One channel, and its values over all readings."""

    name: str
    quantity: str
    unit: str
    input_range: float  # either sign, in `input_unit`
    input_unit: str  # V, or N of a force that a meter reads
    least: float | None  # None: no reading has a value
    most: float | None


def channel_table(session: RecordedSession) -> tuple[ChannelSummary, ...]:
    """Return a summary of each channel from the readings as recorded."""
    values: dict[str, list[float]] = {}
    for run in session.runs:
        for row in run.readings:
            for name, value in run.values(row).items():
                values.setdefault(name, []).append(value)
    return tuple(
        ChannelSummary(
            name=channel.name,
            quantity=channel.quantity,
            unit=channel.unit,
            input_range=channel.range_V,
            input_unit=channel.raw_unit,
            **_extremes(values.get(channel.column, [])),
        )
        for channel in session.signals
    )


def _extremes(values: list[float]) -> dict[str, float | None]:
    finite = np.array(values)[np.isfinite(values)] if values else np.empty(0)
    if not finite.size:
        return {"least": None, "most": None}
    return {"least": float(finite.min()), "most": float(finite.max())}


def channels_as_table(channels: tuple[ChannelSummary, ...]) -> Table:
    """Return the same as a table for people."""
    rows = tuple(
        (
            channel.name,
            channel.quantity,
            channel.unit,
            f"±{channel.input_range:g} {channel.input_unit}",
            "-" if channel.least is None else f"{channel.least:.4g}",
            "-" if channel.most is None else f"{channel.most:.4g}",
        )
        for channel in channels
    )
    return Table(title="Channels", columns=_COLUMNS, rows=rows)
