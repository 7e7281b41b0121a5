"""The report's page: one HTML file with everything in it, that asks no other host for anything."""

from __future__ import annotations

import re
from pathlib import Path

from labrig.files import write_text
from labrig.report.data.findings import Findings
from labrig.report.page.sections import ReportContent
from labrig.report.page.summary import cards, remarks
from labrig.report.parts.section import Drawn
from labrig.report.parts.table import Table
from labrig.report.sections.interface import SECTIONS
from labrig.version import version

FILES = "figures/ as PNG and SVG"


def render(findings: Findings, content: ReportContent, files: str = FILES) -> str:
    """Return the page's text; `files` says where its figures are and in which formats."""
    return render_page(
        "session.html.j2",
        title=findings.session.about.title or findings.session.path.name,
        session=findings.session,
        names=findings.names,
        cards=cards(findings),
        remarks=[*content.left_out, *remarks(findings)],
        sections=content.sections,
        origins=SECTIONS.origins(),
        files=files,
    )


def render_page(template: str, **values: object) -> str:
    """Return a page: title, cards, remarks, sections, and what its template needs."""
    from jinja2 import Environment, PackageLoader, StrictUndefined

    environment = Environment(
        loader=PackageLoader("labrig.report", "."),
        autoescape=True,
        undefined=StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    environment.tests["table"] = lambda item: isinstance(item, Table)
    environment.tests["drawn"] = lambda item: isinstance(item, Drawn)
    environment.filters["minus"] = lambda text: _with_true_minus(str(text))
    return environment.get_template(template).render(version=version(), **values)


def _with_true_minus(text: str) -> str:
    return re.sub(r"(?<![\w.])-(?=\d)|(?<= )-(?= )", "\N{MINUS SIGN}", text)


def write_page(text: str, path: Path) -> None:
    """Write the page under a temporary name and rename it."""
    write_text(path, text)
