"""The sections of one report: each is asked in turn, and one that fails costs itself alone."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

from labrig.foreign_code import foreign_place
from labrig.progress import Progress, silent
from labrig.report.data.findings import Findings
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.section import Section
from labrig.report.sections.conformance import content_faults
from labrig.report.sections.interface import SECTIONS, ReportSection


@dataclass(frozen=True)
class ReportContent:
    """What the page shows, and a sentence for each section that could not be made."""

    sections: tuple[Section, ...]
    left_out: tuple[str, ...]


def report_content(
    findings: Findings,
    figures: FigureFolder,
    known: Mapping[str, ReportSection],
    progress: Progress = silent,
) -> ReportContent:
    """Return the known sections that apply. Raises LabrigError when figures are not written."""
    sections: dict[str, Section] = {}
    left_out = []
    for done, (name, part) in enumerate(known.items()):
        progress(done / len(known), part.title)
        failing = "its `applies`"
        try:
            applies = part.applies(findings)
            failing = "its `make`"
            made = _made(part, findings, figures) if applies else None
            if made is not None and made.anchor in sections:
                raise ValueError(f"there is a section called {part.title} already")
        except (Exception, SystemExit) as error:
            if error is figures.failure:
                raise
            left_out.append(_why(name, part, failing, error))
            continue
        if made is not None:
            sections[made.anchor] = made
    figures.remove_others([figure for part in known.values() for figure in part.figures])
    return ReportContent(tuple(sections.values()), tuple(left_out))


def _made(part: ReportSection, findings: Findings, figures: FigureFolder) -> Section | None:
    figures.allowed = part.figures  # a name may lead to another folder, or be another section's
    made = part.make(findings, figures)
    faults = content_faults(made, part.figures)
    if faults:
        raise ValueError("; ".join(faults))
    section = Section(sentences=(made,)) if isinstance(made, str) else made
    return None if section.is_empty else replace(section, title=part.title)


def _why(name: str, part: ReportSection, failing: str, error: BaseException) -> str:
    text = " ".join(str(error).split()).rstrip(".")
    origin = SECTIONS.origins().get(name, "")
    place = foreign_place(error)
    where = "" if place is None else f", in {place}"
    return (
        f"The section '{part.title}' ({name}{origin and ' of '}{origin}) is left out: "
        f"{failing} failed with {type(error).__name__}: {text}{where}."
    )
