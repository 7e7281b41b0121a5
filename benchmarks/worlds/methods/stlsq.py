"""Sparse regression on all signatures (Brunton, Proctor and Kutz 2016, PNAS 113, 3932)."""

from __future__ import annotations

from benchmarks.hidden_effects.baselines import stlsq
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._foretell import of_effects
from benchmarks.worlds.methods._signatures import Started, taken_at_their_word
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the names, and what the base model foretells with them."""
    started = Started.of(measurements)
    chosen = stlsq(started.base, started.pool)
    return taken_at_their_word(
        [c.name for c in chosen], of_effects(started.base, chosen, measurements)
    )
