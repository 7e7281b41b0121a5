"""Figures of a batch: distributions, how often each thing was said, trends over time."""

from __future__ import annotations

from collections import defaultdict
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from drivers.interfaces import FloatArray
from labrig.batch.summary.numbers import BatchSummary, Distribution
from labrig.report.parts.style import DEFAULT_FORMATS, figure, panels_width_in, save_all

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

_COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9", "#767676")
_MOST_GROUPS = len(_COLOURS)  # in one panel
_MOST_BARS = 25
_MOST_BINS = 40


def draw_summary(summary: BatchSummary, folder: Path) -> list[Path]:
    """Draw what there is to draw; returns the files. Raises LabrigError."""
    by_measure: dict[str, list[Distribution]] = defaultdict(list)
    for one in summary.distributions:
        by_measure[one.measure.column].append(one)
    panels = [group[:_MOST_GROUPS] for group in by_measure.values()]
    paths = []
    if panels:
        with figure(panels_width_in(len(panels)), 3.2) as fig:
            _in_panels(fig, panels, _histogram)
            paths += save_all(fig, folder, "distributions", DEFAULT_FORMATS)
    dated = [[one for one in group if np.isfinite(one.days).any()] for group in panels]
    dated = [group for group in dated if group]
    if dated:
        with figure(panels_width_in(len(dated)), 3.2) as fig:
            _in_panels(fig, dated, _over_time)
            paths += save_all(fig, folder, "trends", DEFAULT_FORMATS)
    if summary.counts:
        paths += _draw_counts(summary, folder)
    return paths


def _in_panels(fig: Figure, panels: list[list[Distribution]], draw: Any) -> None:
    axes = fig.subplots(1, len(panels), squeeze=False)[0]
    for one, group in zip(axes, panels, strict=True):
        draw(one, group)
        if len(group) > 1 or group[0].group:
            one.legend(fontsize="small")


def _histogram(axes: Axes, group: list[Distribution]) -> None:
    every = np.concatenate([one.values for one in group])
    bins = min(_MOST_BINS, max(5, int(np.sqrt(len(every)))))
    low, high = np.percentile(every, (0.5, 99.5))  # one value far off must not hide the others
    edges = np.linspace(low, high if high > low else low + 1.0, bins + 1)
    for one, colour in zip(group, _COLOURS, strict=False):
        axes.hist(
            np.clip(one.values, edges[0], edges[-1]),
            bins=list(edges), histtype="stepfilled", alpha=0.35, color=colour,
            label=_label(one),
        )  # fmt: skip
    measure = group[0].measure
    axes.set_xlabel(f"{measure.title}, {measure.unit}")
    axes.set_ylabel("rows")


def _over_time(axes: Axes, group: list[Distribution]) -> None:
    for one, colour in zip(group, _COLOURS, strict=False):
        known = np.isfinite(one.days)
        axes.plot(
            _dates(one.days[known]), one.values[known], ".", ms=3, color=colour, label=_label(one)
        )
        trend = one.trend
        if trend is not None:
            ends = np.array([one.days[known].min(), one.days[known].max()])
            line = np.mean(one.values[known]) + trend.per_day * (ends - np.mean(one.days[known]))
            axes.plot(_dates(ends), line, color=colour)
    axes.tick_params(axis="x", labelrotation=30)
    measure = group[0].measure
    axes.set_ylabel(f"{measure.title}, {measure.unit}")


def _dates(days: FloatArray) -> Any:
    return (days * 86400.0).astype("datetime64[s]")


def _label(one: Distribution) -> str:
    return f"{one.group} ({len(one.values)})"


def _draw_counts(summary: BatchSummary, folder: Path) -> list[Path]:
    bars = [
        (f"{column}: {text}", count)
        for column, texts in summary.counts.items()
        for text, count in list(texts.items())[:_MOST_BARS]
    ][:_MOST_BARS]
    names, counts = zip(*reversed(bars), strict=True)
    with figure(6.0, 0.9 + 0.24 * len(bars)) as fig:
        axes = fig.subplots()
        axes.barh(range(len(bars)), counts, color=_COLOURS[0])
        axes.set_yticks(range(len(bars)), names)
        axes.set_xlabel("rows")
        return save_all(fig, folder, "counts", DEFAULT_FORMATS)
