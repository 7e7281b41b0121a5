"""The confusion matrix, and how often an effect is found and named rightly against its d."""

from __future__ import annotations

from collections.abc import Sequence
from itertools import pairwise
from pathlib import Path

import numpy as np

from benchmarks.hidden_effects.records import Record
from benchmarks.hidden_effects.registry import CATALOGUE
from benchmarks.hidden_effects.score import SEEN, SINGLE, exactly, wilson

EDGES = np.array([2.0, 3.0, 4.0, 5.7, 8.0, 11.3, 16.0, 32.0, 64.0, 128.0, 1e4])
FAMILIES = ("own_form", "other_form")


def draw(records: Sequence[Record], folder: Path) -> list[Path]:
    """Pictures as files; those for which there are cases."""
    import matplotlib as mpl

    mpl.use("Agg")
    folder.mkdir(parents=True, exist_ok=True)
    good = [r for r in records if not r.error and r.truth]
    paths = []
    single = [r for r in good if r.family in SINGLE and r.d >= SEEN]
    if single:
        paths.append(_confusion(single, folder / "discrepancy-confusion.png"))
    measured = [r for r in good if r.family in FAMILIES]
    if measured:
        paths.append(_power(measured, folder / "discrepancy-power.png"))
    return paths


def answer(r: Record) -> str:
    """In one word."""
    if r.unknown is not None:
        return "unknown"
    if not r.said:
        return "nothing"
    return r.said[0] if len(r.said) == 1 else "several"


def matrix(records: Sequence[Record]) -> tuple[np.ndarray, list[str], list[str]]:
    """Counts (truth, answer), with their names."""
    rows = [n for n in CATALOGUE if any(r.names == (n,) for r in records)]
    columns = [*CATALOGUE, "several", "unknown", "nothing"]
    counts = np.zeros((len(rows), len(columns)), dtype=int)
    for r in records:
        counts[rows.index(r.names[0]), columns.index(answer(r))] += 1
    return counts, rows, columns


def _confusion(records: Sequence[Record], path: Path) -> Path:
    from matplotlib.figure import Figure

    counts, rows, columns = matrix(records)
    share = counts / counts.sum(axis=1, keepdims=True)
    figure = Figure(figsize=(10.5, 9.0), layout="constrained")
    axes = figure.subplots()
    axes.imshow(share, cmap="Blues", vmin=0.0, vmax=1.0, aspect="auto")
    for i, j in np.argwhere(counts):
        colour = "white" if share[i, j] > 0.5 else "black"
        axes.text(j, i, str(counts[i, j]), ha="center", va="center", color=colour, fontsize=8)
    axes.set_xticks(range(len(columns)), [c.replace("_", " ") for c in columns], rotation=60,
                    ha="right", rotation_mode="anchor", fontsize=8)  # fmt: skip
    axes.set_yticks(range(len(rows)), [r.replace("_", " ") for r in rows], fontsize=8)
    axes.axvline(len(CATALOGUE) - 0.5, color="grey", linewidth=0.8)
    axes.set_ylabel("hidden")
    axes.set_xlabel("named")
    axes.set_title(f"{counts.sum()} sessions with one effect of the catalogue, d from {SEEN:g}")
    figure.savefig(path, dpi=110)
    return path


def _power(records: Sequence[Record], path: Path) -> Path:
    from matplotlib.figure import Figure

    figure = Figure(figsize=(9.5, 4.0), layout="constrained")
    panels = figure.subplots(1, 2, sharey=True)
    for axes, family, title in zip(
        panels, FAMILIES, ("in the catalogue's form", "in another form"), strict=True
    ):
        own = [r for r in records if r.family == family]
        for what, colour, mark, right in (
            ("something found", "tab:orange", "s", lambda r: bool(r.said) or r.unknown is not None),
            ("exactly the true effect", "tab:blue", "o", exactly),
        ):
            at, share, low, high = _binned([(r.d, right(r)) for r in own])
            reach = np.maximum([share - low, high - share], 0.0)  # an end may be rounded
            axes.errorbar(at, share, reach, marker=mark, capsize=3, color=colour,
                          label=what, markersize=9 if mark == "s" else 5,
                          markerfacecolor="none" if mark == "s" else colour)  # fmt: skip
        axes.set_xscale("log")
        axes.set_xticks([2, 4, 8, 16, 32, 64, 128], ["2", "4", "8", "16", "32", "64", "128"])
        axes.minorticks_off()
        axes.set_ylim(-0.03, 1.03)
        axes.grid(alpha=0.3)
        axes.set_xlabel("d, standard deviations")
        axes.set_title(f"hidden {title}: {len(own)} sessions")
    panels[0].set_ylabel("share of sessions, with 90 % interval")
    panels[0].legend(loc="lower right")
    figure.savefig(path, dpi=110)
    return path


def _binned(told: Sequence[tuple[float, bool]]) -> tuple[np.ndarray, ...]:
    """Geometric middle, share and its interval for each part of d's range that has cases."""
    rows = []
    for low, high in pairwise(EDGES):
        inside = [(d, ok) for d, ok in told if low <= d < high]
        if inside:
            hits = sum(ok for _, ok in inside)
            middle = float(np.exp(np.mean(np.log([d for d, _ in inside]))))
            rows.append((middle, hits / len(inside), *wilson(hits, len(inside))))
    return tuple(np.array(rows).reshape(-1, 4).T)
