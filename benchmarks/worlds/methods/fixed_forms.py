"""The search of labrig, every effect as the catalogue writes it."""

from __future__ import annotations

from benchmarks.hidden_effects.baselines import fixed_forms
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._signatures import Started, taken_at_their_word
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the names."""
    started = Started.of(measurements)
    return taken_at_their_word(fixed_forms(started.ready, started.effects))
