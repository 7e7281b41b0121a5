"""Writes a session's report: figures as PNG and SVG, and one page that holds everything."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from labrig.errors import BadInputError
from labrig.report.data.findings import Progress, gather
from labrig.report.page.page import render, write_page
from labrig.report.page.sections import report_content
from labrig.report.parts.figures import FigureFolder
from labrig.report.sections.interface import ordered


def _quiet(_fraction: float, _text: str) -> None:
    pass


def write_report(
    session: Path,
    folder: Path | None = None,
    *,
    progress: Progress = _quiet,
    tell: Callable[[str], None] = lambda _text: None,
) -> Path:
    """Write the report of a session and return the page's path.

    `folder` is by default NAME-report in the folder of the session. A session that was not
    analysed yet is analysed first; the page says what cannot be measured or fitted. Raises
    BadInputError when the session cannot be read or the folder not be written.
    """
    session = Path(session)
    folder = session.with_name(f"{session.stem}-report") if folder is None else Path(folder)
    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    found = gather(session, progress, tell)
    with found.session:
        content = report_content(found, FigureFolder(folder / "figures"), ordered(), progress)
        for text in content.left_out:
            tell(text)
        write_page(render(found, content), folder / "index.html")
    return folder / "index.html"
