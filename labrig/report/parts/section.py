"""What a page is made of: sections of tables, figures and things to unfold."""

from __future__ import annotations

from dataclasses import dataclass, field

from labrig.report.figures.all_figures import Drawn
from labrig.report.parts.table import Table


@dataclass(frozen=True)
class Folded:
    """Something long that is shown when asked for."""

    title: str
    table: Table | None = None
    text: str = ""


@dataclass(frozen=True)
class Section:
    """A part of the page; its items are shown in order."""

    title: str
    items: tuple[Table | Drawn | Folded, ...] = ()
    sentences: tuple[str, ...] = field(default=())

    @property
    def is_folded(self) -> bool:
        """Whether nothing of it is seen before it is asked for."""
        return not self.sentences and all(isinstance(item, Folded) for item in self.items)

    @property
    def anchor(self) -> str:
        """For links within the page."""
        return self.title.lower().replace(" ", "-")
