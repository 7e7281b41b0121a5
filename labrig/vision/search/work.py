"""Count what is tried on one image, so that a refusal costs no more than a stated amount."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.vision.thresholds import (
    OUTLINE_BROAD_MAX,
    OUTLINE_ROUGH_MAX,
    OUTLINE_ROUNDS_MAX,
)


class WorkDoneError(Exception):
    """As many rounds of fits as one image may take were done."""


@dataclass
class OutlineWork:
    """What was tried of one image: searches of few and of many states, and rounds of all fits."""

    rough: int = 0  # in one of its channels
    broad: int = 0
    rounds: int = 0

    def next_channel(self) -> None:
        """Search anew: each channel may show the strip."""
        self.rough = 0

    def may_search_roughly(self) -> bool:
        """Return whether one more search of few states may be done, and count it."""
        self.rough += 1
        return self.rough <= OUTLINE_ROUGH_MAX

    def may_search_broadly(self) -> bool:
        """Return whether one more search of many states may be done, and count it."""
        self.broad += 1
        return self.broad <= OUTLINE_BROAD_MAX

    def count_round(self) -> None:
        """Count one round of a fit; raise where there were enough."""
        if self.rounds >= OUTLINE_ROUNDS_MAX:
            raise WorkDoneError
        self.rounds += 1
