"""The routes that the pages bring: their own, their data, and the files of other distributions."""

from __future__ import annotations

import warnings
from collections.abc import Callable, Coroutine
from pathlib import Path
from typing import Any

from anyio import CapacityLimiter, to_thread
from fastapi import FastAPI
from fastapi.responses import FileResponse, JSONResponse

from drivers.plugins import OWN, Part, PluginWarning
from labrig.errors import LabrigError
from labrig.panel.core.panel import Panel
from labrig.panel.core.requests import Here
from labrig.panel.errors import MissingError
from labrig.panel.pages.conformance import content_faults, json_faults
from labrig.panel.pages.interface import STATIC, PanelPage, left_out, ordered

# by ending: what a page may consist of; all else of its folder is not served
MEDIA_TYPES = {
    ".js": "text/javascript",
    ".css": "text/css",
    ".json": "application/json",
    ".svg": "image/svg+xml",
    ".png": "image/png",
}

_MOST_ANSWERS = 8  # of one page, at a time


def add_page_routes(app: FastAPI) -> None:
    """Add the routes of all pages. Called once, when the server starts."""
    folders: dict[str, Path] = {}
    for sentence in left_out():
        warnings.warn(sentence, PluginWarning, stacklevel=2)
    for address, part in ordered().items():
        page = part.part
        if page.router is not None:
            prefix = "" if part.distribution == OWN else f"/api/pages/{address}"
            app.include_router(page.router, prefix=prefix)
        if page.data is not None:
            app.get(f"/api/pages/{address}")(_data_route(part))
        if page.script is not None and not page.script.is_relative_to(STATIC):
            folders[address] = page.script.parent.resolve()

    @app.get("/plugins/{address}/{path:path}")
    def plugin_file(address: str, path: str) -> FileResponse:
        file = _file(folders, address, path)
        return FileResponse(file, media_type=MEDIA_TYPES[file.suffix])


def _file(folders: dict[str, Path], address: str, path: str) -> Path:
    """Return a file of a page's folder. Raises MissingError for any other."""
    folder = folders.get(address)
    file = None if folder is None or "\0" in path else (folder / path).resolve()
    if (
        file is None
        or folder is None
        or file.suffix not in MEDIA_TYPES
        or not file.is_relative_to(folder)
        or not file.is_file()
    ):
        raise MissingError("there is no such file.")
    return file


def _data_route(part: Part[PanelPage]) -> Callable[[Here], Coroutine[Any, Any, Any]]:
    """Return what answers a request for a page's data, in threads of that page.

    A page that never answers would else take those of all others.
    """
    ask = part.part.data
    origin = "" if part.distribution == OWN else f" of {part.distribution} {part.version}"
    name, has_script = f"the page '{part.name}'{origin}", part.part.script is not None
    assert ask is not None  # noqa: S101 - checked by the caller

    def answer(panel: Panel) -> Any:
        try:
            content = ask(panel)
            faults = list(json_faults(content)) if has_script else content_faults(content)
            if faults:
                return JSONResponse({"error": f"{name} has nothing to show: {faults[0]}."}, 500)
            return JSONResponse(content)
        except LabrigError:
            raise
        except (Exception, SystemExit) as error:  # noqa: BLE001 - other people's code may raise anything
            why = " ".join(f"{type(error).__name__}: {error}".split()).rstrip(".")
            return JSONResponse({"error": f"{name} has no data: {why}."}, 500)

    threads = CapacityLimiter(_MOST_ANSWERS)

    async def data(panel: Here) -> Any:
        return await to_thread.run_sync(answer, panel, limiter=threads)

    return data
