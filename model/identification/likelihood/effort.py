"""How much a search has done: a count of solutions of the whole model, not a time.

The count is the same on every computer, so that an answer does not depend on how fast it is.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np


@dataclass
class Effort:
    """Solutions of all conditions, each with its derivatives."""

    most: float = np.inf  # after which nothing more is tried
    solutions: int = 0
    cut_short: bool = False  # whether something was not tried

    def spent(self) -> bool:
        """Return whether nothing more is to be tried; whoever asks leaves it out then."""
        self.cut_short |= self.solutions >= self.most
        return self.cut_short
