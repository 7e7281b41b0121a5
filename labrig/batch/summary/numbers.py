"""Counts, distributions and trends over the rows of a batch."""

from __future__ import annotations

import datetime as dt
import re
from collections import Counter, defaultdict
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from drivers.interfaces import FloatArray
from labrig.batch.contract import BatchTask, Measure
from labrig.batch.rows import PieceOutcome, Row

Z90 = 1.6449
_FEWEST_OF_A_TREND = 4
_DAY_S = 86400.0
_GROUP = re.compile(r"(?P<column>[^\[\]]+)\[(?P<group>.+)\]")
NOTHING = "none"  # is said of a row whose list is empty


@dataclass(frozen=True, kw_only=True)
class Trend:
    """A straight line through values over time."""

    per_day: float
    sigma: float  # standard uncertainty of the slope, from the scatter about the line
    values: int

    def to_json(self) -> dict[str, Any]:
        """For summary.json."""
        return {"per_day": self.per_day, "sigma": self.sigma, "values": self.values}


@dataclass(frozen=True, kw_only=True)
class Distribution:
    """The values of one quantity for one group, in the measure's unit."""

    measure: Measure
    group: str
    values: FloatArray
    days: FloatArray  # since 1970, NaN where a row has no date
    samples: tuple[str, ...]

    @property
    def trend(self) -> Trend | None:
        """Return the trend over time; None where there are too few dates."""
        return _trend(self.days, self.values)

    def to_json(self) -> dict[str, Any]:
        """For summary.json."""
        quarters = np.percentile(self.values, (5, 25, 50, 75, 95))
        names = ("p05", "p25", "median", "p75", "p95")
        trend = self.trend
        return {
            "unit": self.measure.unit,
            "values": len(self.values),
            "mean": float(np.mean(self.values)),
            "deviation": float(np.std(self.values, ddof=1)) if len(self.values) > 1 else None,
            **{name: float(value) for name, value in zip(names, quarters, strict=True)},
            "trend": None if trend is None else trend.to_json(),
            "by_sample": {
                name: {"values": int(own.sum()), "mean": float(np.mean(self.values[own]))}
                for name in sorted(set(self.samples))
                if name and (own := np.array([one == name for one in self.samples])).any()
            },
        }


@dataclass(frozen=True, kw_only=True)
class BatchSummary:
    """All that is said of a batch."""

    outcomes: Mapping[str, int]
    counts: Mapping[str, Mapping[str, int]]  # by column: how often each text
    counted_rows: Mapping[str, int]  # by column: rows that have it
    distributions: tuple[Distribution, ...]
    cpu_s: float
    faults: tuple[tuple[str, int], ...] = field(default=())  # most frequent sentences

    def to_json(self) -> dict[str, Any]:
        """For summary.json."""
        return {
            "outcomes": dict(self.outcomes),
            "cpu_s": self.cpu_s,
            "counts": {
                column: {
                    text: {
                        "rows": count,
                        "of": self.counted_rows[column],
                        "share": count / self.counted_rows[column],
                        "interval90": list(wilson(count, self.counted_rows[column])),
                    }
                    for text, count in texts.items()
                }
                for column, texts in self.counts.items()
            },
            "distributions": {
                f"{one.measure.column}[{one.group}]": one.to_json() for one in self.distributions
            },
            "faults": [{"sentence": text, "rows": count} for text, count in self.faults],
        }


def summary_of(task: BatchTask, rows: Iterable[Row], most_faults: int = 20) -> BatchSummary:
    """Go through the rows once; of each only its numbers are kept."""
    outcomes, faults = Counter[str](), Counter[str]()
    counts: dict[str, Counter[str]] = defaultdict(Counter)
    counted_rows = Counter[str]()
    found: dict[tuple[str, str], list[tuple[float, float, str]]] = defaultdict(list)
    measures = {one.column: one for one in task.measures}
    cpu_s = 0.0
    for row in rows:
        outcomes[row.outcome.value] += 1
        cpu_s += row.cpu_s
        if row.outcome is not PieceOutcome.DONE:
            faults[_without_name(row)] += 1
            continue
        day, sample = _day(row.columns.get("started")), str(row.columns.get("sample") or "")
        for column, group, value in _grouped(row.columns):
            if column in measures and isinstance(value, int | float):
                scale = measures[column].scale
                found[column, group].append((scale * float(value), day, sample))
            if column in task.counted:
                name = f"{column}[{group}]" if group else column
                counted_rows[name] += 1
                counts[name].update(_texts(value))
    return BatchSummary(
        outcomes=dict(outcomes),
        counts={name: dict(each.most_common()) for name, each in counts.items()},
        counted_rows=dict(counted_rows),
        distributions=tuple(_distributions(found, measures)),
        cpu_s=cpu_s,
        faults=tuple(faults.most_common(most_faults)),
    )


def _distributions(
    found: Mapping[tuple[str, str], list[tuple[float, float, str]]], measures: Mapping[str, Measure]
) -> Iterator[Distribution]:
    order = list(measures)
    for column, group in sorted(found, key=lambda key: (order.index(key[0]), key[1])):
        values, days, samples = zip(*found[column, group], strict=True)
        yield Distribution(
            measure=measures[column],
            group=group,
            values=np.array(values),
            days=np.array(days),
            samples=samples,
        )


def _grouped(columns: Mapping[str, Any]) -> Iterator[tuple[str, str, Any]]:
    for name, value in columns.items():
        split = _GROUP.fullmatch(name)
        if split is None:
            yield name, "", value
        else:
            yield split["column"], split["group"], value


def _texts(value: Any) -> list[str]:
    if isinstance(value, bool):
        return ["yes" if value else "no"]
    if isinstance(value, list):
        return [str(one) for one in value] or [NOTHING]
    return [NOTHING if value is None else str(value)]


def _without_name(row: Row) -> str:
    """Return a fault's sentence as it is the same for other files."""
    path = row.name.split(" ")[0]
    start = row.sentence.find(path)
    return row.sentence if start < 0 or not path else row.sentence[start + len(path) :].lstrip(": ")


def _day(started: Any) -> float:
    if not isinstance(started, str):
        return float("nan")
    try:
        when = dt.datetime.fromisoformat(started)
    except ValueError:
        return float("nan")
    return (when if when.tzinfo else when.replace(tzinfo=dt.UTC)).timestamp() / _DAY_S


def _trend(days: FloatArray, values: FloatArray) -> Trend | None:
    known = np.isfinite(days)
    x, y = days[known], values[known]
    if len(x) < _FEWEST_OF_A_TREND or np.ptp(x) == 0.0:
        return None
    x = x - np.mean(x)
    slope = float(x @ (y - np.mean(y)) / (x @ x))
    rest = y - np.mean(y) - slope * x
    sigma = float(np.sqrt(rest @ rest / (len(x) - 2) / (x @ x)))
    return Trend(per_day=slope, sigma=sigma, values=len(x))


def wilson(hits: int, count: int) -> tuple[float, float]:
    """Return the 90 % interval of a share (Wilson 1927)."""
    if not count:
        return 0.0, 1.0
    share, square = hits / count, Z90**2
    centre = (share + square / (2 * count)) / (1 + square / count)
    half = (
        Z90
        / (1 + square / count)
        * float(np.sqrt(share * (1 - share) / count + square / (4 * count**2)))
    )
    return max(0.0, centre - half), min(1.0, centre + half)
