"""The search of labrig, every effect as the catalogue writes it."""

from __future__ import annotations

from benchmarks.hidden_effects.baselines import fixed_forms
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._foretell import of_model
from benchmarks.worlds.methods._signatures import Started, taken_at_their_word
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the names, and what the model with them foretells."""
    started = Started.of(measurements)
    named, final = fixed_forms(started.ready, started.effects)
    return taken_at_their_word(named, of_model(final, measurements))
