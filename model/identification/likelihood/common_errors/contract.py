"""What an error that is common to all data is asked for."""

from __future__ import annotations

from typing import Protocol

from model.identification.likelihood.forward_model import ForwardModel
from model.identification.likelihood.model_state import ModelState
from model.measurements import FloatArray


class CommonErrors(Protocol):
    """Errors that act alike in many rows, as base parameters; zero is what was stated."""

    @property
    def first(self) -> int:
        """Place of the first one among all base parameters."""
        ...

    @property
    def sigma(self) -> list[float]:
        """Their standard uncertainties; empty: none is stated."""
        ...

    def rows(self, forward: ForwardModel, c: int, state: ModelState) -> FloatArray:
        """Return the rows of one configuration by each of them, (N, q)."""
        ...


def places(one: CommonErrors) -> range:
    """Return their places among all base parameters."""
    return range(one.first, one.first + len(one.sigma))
