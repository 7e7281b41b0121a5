"""The contract of a report's section."""

from __future__ import annotations

import sys
import warnings
from collections.abc import Callable
from dataclasses import dataclass
from functools import lru_cache

from drivers.plugins import Part, PluginFolder, PluginWarning
from labrig.left_out import same_title
from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.conformance import faults


@dataclass(frozen=True, kw_only=True)
class ReportSection:
    """A section of every report to which it applies; its name is that of its file or entry point.

    Both functions are called once for each report, in one thread, and may take as long as drawing
    takes. They only read: the session is open for reading and is closed after the last section.
    What either raises leaves this section out of the page with a sentence; the others are written.
    """

    title: str  # its heading, unlike any other section's
    order: float  # sections stand in ascending order; fractions leave room between two
    applies: Callable[[Findings], bool]  # whether it has something to show of these findings
    # Return the section, without a title, or one sentence that says why nothing can be shown.
    make: Callable[[Findings, FigureFolder], Section | str]
    figures: tuple[str, ...] = ()  # names it may draw; files of those not drawn are removed


SECTIONS: PluginFolder[ReportSection] = PluginFolder(
    what="report section",
    package="labrig.report.sections",
    constant="SECTION",
    group="labrig.report_sections",
    faults=faults,
)


def ordered() -> dict[str, ReportSection]:
    """Return all sections by name, in the order in which a report shows them.

    Of one title, or of one figure's name, the first stays; our own come first.
    """
    found = _of_different_names(tuple(sys.path))
    return dict(sorted(found.items(), key=lambda item: (item[1].order, item[0])))


@lru_cache(maxsize=8)  # so that a process tells of each that is left out once
def _of_different_names(path: tuple[str, ...]) -> dict[str, ReportSection]:
    del path
    found: dict[str, Part[ReportSection]] = {}
    for name, part in SECTIONS.parts().items():
        shared = next(filter(None, (_shared(part.part, one) for one in found.values())), "")
        if not shared:
            found[name] = part
            continue
        warnings.warn(
            f"the report section '{name}' of {part.distribution} is left out: there is a section "
            f"with {shared}.",
            PluginWarning,
            stacklevel=3,
        )
    return {name: part.part for name, part in found.items()}


def _shared(section: ReportSection, other: Part[ReportSection]) -> str:
    """Return what no two sections may share, and whose it is already; empty: nothing."""
    whose = f"already ('{other.name}' of {other.distribution})"
    if same_title(other.part.title, section.title):
        return f"the title '{other.part.title}' {whose}"
    figures = sorted({*section.figures} & {*other.part.figures})
    return f"the figure '{figures[0]}' {whose}" if figures else ""
