"""Noise from the repeats alone, effects added while BIC falls."""

from __future__ import annotations

from benchmarks.hidden_effects.baselines import repeats_bic
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._signatures import Started, taken_at_their_word
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the names."""
    started = Started.of(measurements)
    return taken_at_their_word(repeats_bic(started.base, started.pool))
