"""What one search costs, to count what an image took in: a drawn sheet, everything stated."""

from __future__ import annotations

import math
import time
from contextlib import suppress

import numpy as np

from benchmarks.vision_extraction import parts
from benchmarks.vision_scenes import Recipe, Scene, make_scene, mixed
from labrig.vision import neutral_curve

MIXED_FIRST, MIXED_COUNT = 77_440_001, 9
EASY_SEED, EASY_REPEATS = 3, 3
THICKNESS_MM, THINNEST_PX = 0.2, 2.0


class ColdSearches:
    """Processor time of searches in the same run, so that other load slows both."""

    def __init__(self) -> None:
        self._mixed: list[float] = []
        self._easy: dict[float, float] = {}
        self._scenes: list[Scene] = []
        seed = MIXED_FIRST
        while len(self._scenes) < MIXED_COUNT:
            with suppress(RuntimeError):  # no curve fits into that picture
                self._scenes.append(make_scene(mixed(seed)))
            seed += 1
        self.search_mixed()
        self._mixed.clear()  # what is compiled or loaded once costs no search

    def search_mixed(self) -> None:
        """Search all mixed scenes once more."""
        self._mixed += [_seconds(scene) for scene in self._scenes]

    @property
    def mixed_s(self) -> float:
        """Median on mixed scenes, of 640 x 480 pixels."""
        return float(np.median(self._mixed))

    def easy_s(self, rows: int, columns: int) -> float:
        """Return the median on a plain sheet in a picture of about that size."""
        by = max(0.2, round(math.sqrt(rows * columns / (640 * 480)), 1))
        if by not in self._easy:
            px_per_mm = 8.9 * by
            scene = make_scene(
                Recipe(
                    seed=EASY_SEED,
                    physical=True,
                    size=(round(640 * by), round(480 * by)),
                    px_per_mm=px_per_mm,
                    thickness_mm=max(THICKNESS_MM, THINNEST_PX / px_per_mm),
                )
            )
            _seconds(scene)
            self._easy[by] = float(np.median([_seconds(scene) for _ in range(EASY_REPEATS)]))
        return self._easy[by]


def _seconds(scene: Scene) -> float:
    known = parts(scene)
    begin = time.process_time()
    neutral_curve(scene.image, *known)
    return time.process_time() - begin


def summary(searches: ColdSearches, spent: list[tuple[float, float, bool]]) -> str:
    """Return a line on (seconds, seconds of an easy search of that size, refused) of each image."""
    seconds, easy, refused = (np.array(each) for each in zip(*spent, strict=True))
    texts = []
    for name, many in (("on mixed scenes", seconds / searches.mixed_s), ("easy", seconds / easy)):
        text = f"{name}: {np.median(many):.1f} in the median, at most {many.max():.1f}"
        if refused.any():
            text += f"; refused {np.median(many[refused]):.1f}, {many[refused].max():.1f}"
        texts.append(text)
    cold = f"a cold search on mixed scenes: {searches.mixed_s * 1e3:.0f} ms of processor time"
    return f"cold searches, {'; '.join(texts)}; {cold}; the longest {seconds.max():.2f} s"
