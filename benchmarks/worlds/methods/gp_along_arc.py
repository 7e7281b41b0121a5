"""A Gaussian process for what the base model leaves along the arc: it names nothing."""

from __future__ import annotations

from benchmarks.hidden_effects.baseline_gp import gaussian_process, likeliest
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._foretell import along_arc
from benchmarks.worlds.methods._signatures import Started
from model.discrepancy.verdict.prediction_error import refitted, variance
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the share of the left-out gap that it closes, by the noise that the fit states."""
    base = Started.of(measurements).base
    return Answer(
        closed=gaussian_process(base, variance(base)),
        foretell=along_arc(base, refitted(base), likeliest(base), measurements),
    )
