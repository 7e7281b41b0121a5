"""Count what is tried on one image, so that a refusal costs no more than a stated amount."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.thresholds import OUTLINE_ROUNDS_MAX, OUTLINE_SEARCHES_MAX


class WorkDoneError(Exception):
    """As many rounds of fits as one image may take were done."""


@dataclass
class OutlineWork:
    """What was tried of one image: searches of one of its channels, and rounds of all fits."""

    searches: int = 0
    rounds: int = 0

    def next_channel(self) -> None:
        """Search anew: each channel may show the strip."""
        self.searches = 0

    def may_search(self) -> bool:
        """Return whether one more search may be done, and count it."""
        self.searches += 1
        return self.searches <= OUTLINE_SEARCHES_MAX

    def count_round(self) -> None:
        """Count one round of a fit; raise where there were enough."""
        if self.rounds >= OUTLINE_ROUNDS_MAX:
            raise WorkDoneError
        self.rounds += 1
