"""Which rows a strip chart has: those of the session's channels, in the units people read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np

from drivers.interfaces import FloatArray
from protocols.execution.channels import DRIVE, FORCE, Channel

_READ_IN = {"N": ("mN", 1e3), "A": ("mA", 1e3)}  # what people read, and its factor


@dataclass(frozen=True, kw_only=True)
class StripRow:
    """One channel as it is drawn."""

    key: str  # force_mN, temperature_degC
    name: str  # of the channel
    quantity: str
    unit: str
    column: str  # of the channel in the `values` of a reading: force_N ...
    factor: float  # ... and what makes the unit of it


def strip_rows(channels: Sequence[Channel]) -> tuple[StripRow, ...]:
    """Return a row for each channel: the drive first, then the force, then the others in order."""
    first = {DRIVE: 0, FORCE: 1}
    return tuple(_row(each) for each in sorted(channels, key=lambda one: first.get(one.name, 2)))


def _row(channel: Channel) -> StripRow:
    unit, factor = _READ_IN.get(channel.unit, (channel.unit, 1.0))
    return StripRow(
        key=f"{channel.name}_{unit}",
        name=channel.name,
        quantity=channel.quantity,
        unit=unit,
        column=channel.column,
        factor=factor,
    )


def rows_message(rows: Sequence[StripRow]) -> list[dict[str, Any]]:
    """Return the rows as a page is told of them."""
    return [asdict(row) for row in rows]


def strip_samples(
    rows: Sequence[StripRow], run_s: FloatArray, values: Mapping[str, FloatArray]
) -> FloatArray:
    """Return (1 + rows, n): the times, and each row's values; `values` are by channel, in SI."""
    return np.stack([run_s, *(row.factor * values[row.name] for row in rows)])
