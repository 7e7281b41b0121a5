"""Sparse regression on all signatures (Brunton, Proctor and Kutz 2016, PNAS 113, 3932)."""

from __future__ import annotations

from benchmarks.hidden_effects.baselines import stlsq
from benchmarks.worlds.methods._contract import Answer
from benchmarks.worlds.methods._signatures import Started, taken_at_their_word
from model.measurements import Measurements


def answer(measurements: Measurements) -> Answer:
    """Return the names."""
    started = Started.of(measurements)
    return taken_at_their_word(stlsq(started.base, started.pool))
