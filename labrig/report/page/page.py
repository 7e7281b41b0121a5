"""The report's page: one HTML file with everything in it, that asks no other host for anything."""

from __future__ import annotations

import re
from pathlib import Path

from labrig.errors import BadInputError
from labrig.files import write_text
from labrig.report.data.findings import Findings
from labrig.report.page.sections import ReportContent
from labrig.report.page.summary import cards, remarks
from labrig.report.parts.section import Drawn
from labrig.report.parts.table import Table
from labrig.report.sections.interface import SECTIONS
from labrig.version import version

FILES = "figures/ as PNG and SVG"
PAGE = "index.html"
_HEAD = 2000  # characters, in which a page states what made it
_MADE_BY_LABRIG = '<meta name="generator" content="labrig '
_OF_SESSION = '<meta name="labrig-session-state" '


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


def check_page_is_free(folder: Path, *, of_session: bool) -> None:
    """Raise BadInputError where the folder's page is not one of the same kind: it would be lost.

    of_session: the page to come is the report of a session, and not a diagnosis alone.
    """
    page = folder / PAGE
    if not page.is_file():
        return
    with page.open(encoding="utf-8", errors="replace") as file:
        head = file.read(_HEAD)
    if _MADE_BY_LABRIG not in head:
        raise BadInputError(f"{page}: this is no page of labrig's; give another folder.")
    if (_OF_SESSION in head) != of_session:
        found = "a diagnosis (labrig diagnose)" if of_session else "a session's (labrig report)"
        raise BadInputError(f"{page}: this page is {found}; give another folder.")


def write_page(text: str, path: Path) -> None:
    """Write the page under a temporary name and rename it."""
    write_text(path, text)
