"""The folder of a page's figures: each is written as PNG and SVG and returned for the page."""

from __future__ import annotations

from collections.abc import Callable, Collection
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import LabrigError
from labrig.files import discard, not_written
from labrig.report.parts.section import Drawn
from labrig.report.parts.style import save_pair
from labrig.report.parts.svg import inline

if TYPE_CHECKING:
    from matplotlib.figure import Figure

ENDINGS = ("png", "svg")


class FigureFolder:
    """Draws into one folder. Raises LabrigError when that cannot be written."""

    def __init__(self, folder: Path) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise not_written(folder.parent, error) from None
        self._folder = folder
        self._names: set[str] = set()
        self.failure: LabrigError | None = None  # why a file could not be written

    def draw(
        self, name: str, title: str, caption: str, draw: Callable[[], Figure | None]
    ) -> tuple[Drawn, ...]:
        """Return the figure that `draw` makes, written as NAME.png and NAME.svg; none for None.

        Raises ValueError when another figure has this name, LabrigError when it is not written.
        """
        if name in self._names:
            raise ValueError(f"there are two figures called {name}")
        fig = draw()
        if fig is None:
            return ()
        self._names.add(name)
        try:
            save_pair(fig, self._folder, name)
        except LabrigError as error:
            self.failure = error
            raise
        svg = (self._folder / f"{name}.svg").read_text(encoding="utf-8")
        return (Drawn(name, title, caption, inline(svg, name, f"{title}. {caption}")),)

    def remove_others(self, known: Collection[str]) -> None:
        """Delete the files of those known figures that were not drawn this time."""
        for name in set(known) - self._names:
            for ending in ENDINGS:
                discard(self._folder / f"{name}.{ending}")
