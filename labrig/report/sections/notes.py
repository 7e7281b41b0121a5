"""Notes and photographs that were added to the session."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from typing import TYPE_CHECKING

from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.interface import ReportSection
from labrig.report.tables.about import notes_table, text_of
from labrig.session import Note, RecordedSession

if TYPE_CHECKING:
    from matplotlib.figure import Figure

_SHOWN_MAX = 12
_IN_A_ROW = 3
_WIDTH_PX = 640


def make(findings: Findings, figures: FigureFolder) -> Section | str:
    """Return the notes as a table and the first photographs as a figure."""
    notes = findings.session.notes
    taken = [note for note in notes if note.has_photograph]
    shown = taken[:_SHOWN_MAX]
    rest = f" {len(taken) - len(shown)} more are in the session." if len(taken) > len(shown) else ""
    drawn = figures.draw(
        "photographs",
        "Photographs",
        f"As they were added to the session, in order.{rest}",
        lambda: _sheet(findings.session, shown) if shown else None,
    )
    return Section((replace(notes_table(notes), title=""), *drawn))


def _sheet(session: RecordedSession, notes: Sequence[Note]) -> Figure:
    from matplotlib.figure import Figure

    from labrig.session.notes.photograph import pixels_of, thumbnail

    rows = -(-len(notes) // _IN_A_ROW)
    figure = Figure(figsize=(7.0, 2.0 * rows), layout="constrained")
    for place, axes in enumerate(figure.subplots(rows, _IN_A_ROW, squeeze=False).flat):
        axes.axis("off")
        if place < len(notes):
            content = session.photograph(notes[place].identifier)
            axes.imshow(pixels_of(thumbnail(content, _WIDTH_PX)))
            axes.set_title(_caption(place, notes[place]), fontsize=7)
    return figure


def _caption(place: int, note: Note) -> str:
    text = text_of(note).replace("$", r"\$").replace("\n", " ")
    return f"{place + 1}. {text[:60]}{'...' if len(text) > 60 else ''}"


SECTION = ReportSection(
    title="Notes",
    order=65,
    applies=lambda findings: bool(findings.session.notes),
    make=make,
    figures=("photographs",),
)
