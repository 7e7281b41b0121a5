"""A strip that was found roughly, and how much speaks for it."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

CLEARNESS_OF_NOTHING = 2.0  # of the largest changes that noise makes along any path
CLEARNESS_OF_ANY = 20.0  # on a plain ground every strip is clear
SCALE_SPREAD = 0.5  # of the logarithm of a path's width to that at which it was searched
ASIDE_USUAL_PX = 5.0  # from where the clamp is stated to the strip's begin


@dataclass(frozen=True, eq=False, kw_only=True)
class Located:
    """A strip found roughly; all in the image's pixels."""

    path_px: FloatArray  # (n, 2), from where it begins to its end
    thickness_px: float
    edge: float  # grey levels: what the two edges change by, in the mean
    leaves_image: bool
    sign: float  # +1: brighter than what lies beside it
    likeness: float = 1.0  # 0 to 1: how alike both sides of it are, against its edges
    clearness: float = 0.0  # its edges over what changes beside it
    scale_px: float = 0.0  # the width at which its path was searched; 0: it was not
    aside_px: float = 0.0  # from the stated place to where it begins

    @property
    def length_px(self) -> float:
        """Length of the path."""
        return path_length_px(self.path_px)

    @property
    def worth(self) -> float:
        """How much speaks for it: the longer and the clearer, the more.

        The same ground lies to both sides of a strip, and not of its rim or of half of it.
        """
        return self.edge * self._share_px

    @property
    def evidence(self) -> float:
        """The same over what noise and texture show: to compare channels with."""
        clear = min(self.clearness - CLEARNESS_OF_NOTHING, CLEARNESS_OF_ANY)
        return max(clear, 0.01) * self._share_px

    @property
    def _share_px(self) -> float:
        near = _nearness(self.aside_px)
        # a path that was searched at another width than it shows is a rough one
        apart = math.log(self.thickness_px / self.scale_px) if self.scale_px else 0.0
        fitting = math.exp(-0.5 * (apart / SCALE_SPREAD) ** 2)
        return self.length_px * self.likeness**2 * near * fitting


def path_length_px(path: FloatArray) -> float:
    """Return a path's length."""
    return float(np.hypot(*np.diff(path, axis=0).T).sum())


def aside_px(path: FloatArray, clamp: tuple[float, float]) -> float:
    """Return how far a path lies from a stated place."""
    return float(np.hypot(*(path - np.array(clamp)).T).min())


def evidence_max(path: FloatArray, clamp: tuple[float, float]) -> float:
    """Return the most that a path's evidence can be, before its edges are measured."""
    return CLEARNESS_OF_ANY * path_length_px(path) * _nearness(aside_px(path, clamp))


def _nearness(away_px: float) -> float:
    return math.exp(-0.5 * (away_px / ASIDE_USUAL_PX) ** 2)
