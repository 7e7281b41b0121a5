"""The folder of a page's figures: each is written in some formats and returned for the page."""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence
from pathlib import Path
from typing import TYPE_CHECKING

from labrig.errors import LabrigError
from labrig.files import discard, not_written
from labrig.report.parts.section import Drawn
from labrig.report.parts.style import DEFAULT_FORMATS, FORMATS, save_all, svg_text
from labrig.report.parts.svg import inline

if TYPE_CHECKING:
    from matplotlib.figure import Figure


class FigureFolder:
    """Draws into one folder. Raises LabrigError when that cannot be written."""

    def __init__(self, folder: Path, formats: Sequence[str] = DEFAULT_FORMATS) -> None:
        try:
            folder.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise not_written(folder.parent, error) from None
        self._folder, self._formats = folder, tuple(formats)
        self._names: set[str] = set()
        self.allowed: Collection[str] | None = None  # what the section may draw; None: anything
        self.failure: LabrigError | None = None  # why a file could not be written

    def draw(
        self, name: str, title: str, caption: str, draw: Callable[[], Figure | None]
    ) -> tuple[Drawn, ...]:
        """Return the figure that `draw` makes, also written as files; none for None.

        Raises ValueError when another figure has this name or it is not one that may be drawn,
        LabrigError when it is not written.
        """
        if self.allowed is not None and name not in self.allowed:
            raise ValueError(f"the figure {name} is not among its figures")
        if name in self._names:
            raise ValueError(f"there are two figures called {name}")
        fig = draw()
        if fig is None:
            return ()
        self._names.add(name)
        svg = svg_text(fig)  # of the page and of the file: drawing it takes long
        try:
            save_all(fig, self._folder, name, self._formats, svg)
        except LabrigError as error:
            self.failure = error
            raise
        return (Drawn(name, title, caption, inline(svg, name, f"{title}. {caption}")),)

    def remove_others(self, known: Collection[str]) -> None:
        """Delete older files of known figures that were not written this time."""
        for name in known:
            for ending in FORMATS:
                if name not in self._names or ending not in self._formats:
                    discard(self._folder / f"{name}.{ending}")
