"""Writes a session's report: one page that holds everything, and its figures as files."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from pathlib import Path

from labrig.errors import BadInputError
from labrig.files import new_folder
from labrig.progress import Progress, silent
from labrig.report.data.findings import Findings, gather
from labrig.report.page.page import PAGE, check_page_is_free, render, write_page
from labrig.report.page.sections import report_content
from labrig.report.parts.figures import FigureFolder
from labrig.report.parts.style import DEFAULT_FORMATS
from labrig.report.sections.interface import ordered
from labrig.session import open_session


def _named(figures: Path, folder: Path) -> str:
    """Return the name of the figures' folder, as seen from the page."""
    inside = figures.is_relative_to(folder)
    return f"{figures.relative_to(folder) if inside else figures}/"


def write_report(
    session: Path,
    folder: Path | None = None,
    *,
    figures: Path | None = None,
    formats: Sequence[str] = DEFAULT_FORMATS,
    figures_named: str = "",
    progress: Progress = silent,
    tell: Callable[[str], None] = lambda _text: None,
    processes: int = 1,
) -> Path:
    """Write the report of a session and return the page's path.

    `folder` is by default NAME-report in the folder of the session; the figures go to `figures` in
    it, or to the folder of that name. `figures_named`: where the page says that they are, for a
    caller who puts them elsewhere. A session that was not analysed yet is analysed first, by so
    many `processes`; the page says what cannot be measured or fitted. Raises BadInputError when the
    session cannot be read, a folder not be written, or its page is not labrig's.
    """
    session = Path(session)
    folder = session.with_name(f"{session.stem}-report") if folder is None else Path(folder)
    figures = folder / "figures" if figures is None else Path(figures)
    for one in (folder, figures):
        if one.exists() and not one.is_dir():
            raise BadInputError(f"{one}: this is a file, a folder is needed.")
    check_page_is_free(folder, of_session=True)
    open_session(session).close()  # what is no session leaves no folder
    with new_folder(folder):  # at once: what goes into it may take minutes
        found = gather(session, progress, tell, processes=processes)
        _write(found, folder, figures, formats, figures_named, progress, tell)
    return folder / PAGE


def _write(
    found: Findings,
    folder: Path,
    figures: Path,
    formats: Sequence[str],
    figures_named: str,
    progress: Progress,
    tell: Callable[[str], None],
) -> None:
    with found.session:
        content = report_content(found, FigureFolder(figures, formats), ordered(), progress)
        for text in content.left_out:
            tell(text)
        named = figures_named or _named(figures, folder)
        files = f"{named} as {' and '.join(one.upper() for one in formats)}"
        write_page(render(found, content, files), folder / PAGE)
