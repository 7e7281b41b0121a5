"""What a page is made of: sections of tables, figures and details to unfold."""

from __future__ import annotations

from dataclasses import dataclass

from labrig.report.parts.table import Table


@dataclass(frozen=True)
class Drawn:
    """A figure of the page."""

    name: str  # of its files
    title: str
    caption: str
    svg: str


@dataclass(frozen=True)
class Folded:
    """A long table or text that is shown when its title is clicked."""

    title: str
    table: Table | None = None
    text: str = ""


Item = Table | Drawn | Folded


@dataclass(frozen=True)
class Section:
    """A part of the page: its sentences, then its items in order."""

    items: tuple[Item, ...] = ()
    sentences: tuple[str, ...] = ()
    title: str = ""  # a report sets it from the section's plug-in

    @property
    def is_empty(self) -> bool:
        """Whether there is nothing to show."""
        return not self.items and not self.sentences

    @property
    def is_folded(self) -> bool:
        """Whether all of it is hidden until it is unfolded."""
        return not self.sentences and all(isinstance(item, Folded) for item in self.items)

    @property
    def anchor(self) -> str:
        """For links within the page."""
        return self.title.lower().replace(" ", "-")
