"""The person at the rig, and what moves the load cell."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Protocol, runtime_checkable


@dataclass(frozen=True, kw_only=True)
class Prompt:
    """Something the operator is asked to do before the run goes on."""

    # move | moisten | mount | free | touch | remount | dead_weight | turn_over | confirm | repeat
    kind: str
    text: str  # one sentence, ready to show
    configuration: str | None = None
    position_m: float | None = None
    load_N: float | None = None
    # After so long without an answer it goes on as if that were yes; None: it waits
    expires_s: float | None = None


class Operator(Protocol):
    """The person at the rig, or what answers in their place.

    What answers for a person who is not there has an attribute `is_present` that is False: the
    session then records that nobody was asked.
    """

    def ask(self, prompt: Prompt) -> bool:
        """Show the prompt and wait for the answer: True, it is done; False, stop the session.

        To `repeat`, True is to go on, and False is to measure the run of the prompt again.
        """


@runtime_checkable
class Positioner(Protocol):
    """Moves the load cell along the arc; by a motor, or by asking the operator."""

    def open(self) -> None:
        """Take the stage; may move it to its reference. Raises DeviceNotFoundError, DeviceError."""

    def move_to(self, position_m: float) -> bool:
        """Move to a position along the arc, at 0 V, and block until it is reached.

        False when the operator declined. A motor takes 300 s at most; a person as long as they
        need. Raises LimitError (it was not moved) outside its range or for NaN,
        DeviceTimeoutError, DeviceError.
        """

    def position(self) -> float | None:
        """Return the position along the arc in m that the stage reports; None: it has no sensor."""

    def close(self) -> None:
        """Let go of the stage. May be called twice."""


@runtime_checkable
class LimitedTravel(Protocol):
    """A `Positioner` that knows its travel; a session beyond it is refused before it begins."""

    def travel_m(self) -> tuple[float, float]:
        """Return both ends of its travel along the arc in m, the lower first; open only."""
