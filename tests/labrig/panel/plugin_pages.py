"""A distribution that adds pages to the panel, and a panel that finds it."""

from __future__ import annotations

import os
import re
import tomllib
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import pytest

from tests.labrig.panel.page import Server, panel

PLUGIN = """
import threading
from pathlib import Path
from fastapi import APIRouter, Request
from labrig.errors import BadInputError
from labrig.panel.core.requests import Here
from labrig.panel.pages.interface import PanelPage

router = APIRouter()

@router.post("/note")
def note(request: Request, panel: Here):
    who = panel.acting(request)
    panel.log(who, "wrote a note")
    return {"who": who}

@router.get("/refused")
def refused():
    raise BadInputError("there are no notes.")

def fail(panel):
    raise KeyError("ink")

def leave(panel):
    raise SystemExit(1)

def wait(panel):
    threading.Event().wait(15)

def table(panel):
    rows = [["data folder", panel.settings.data.name, 1], ["pages", 3, 2]]
    return {"sentences": ["All is noted."], "tables": [
        {"title": "Notes", "columns": ["what", "value", "line"], "rows": rows}]}

WEB = Path(__file__).parent / "labrig_notes_web"
NOTES = PanelPage(title="Notes", order=25, router=router, script=WEB / "page.js", data=table)
PLAIN = PanelPage(title="Plain notes", order=26, data=table)
FAILING = PanelPage(title="Failing", order=27, data=fail)
LEAVING = PanelPage(title="Leaving", order=29, data=leave)
BAD = PanelPage(title="Bad", order=28, script=WEB / "missing.js")
SLOW = PanelPage(title="Slow", order=32, data=wait)
ODD = PanelPage(title="Odd", order=30, data=lambda panel: [1])
HOLES = PanelPage(title="Holes", order=31, script=WEB / "page.js",
    data=lambda panel: {"rooms": [{"humidity": [41.0, float("nan")]}]})
"""
LIST = """
from dataclasses import replace
from pathlib import Path
from labrig_humidity import PAGE
PAGE = replace(PAGE, title="As a list", script=Path(__file__).parent / "humidity_web" / "page.js")
"""
PAGE_JS = """
import { h } from "/static/js/dom.js";
import { word } from "./word.js";
export function mount(place, app) {
  place.append(h("h1", {}, `Notes: ${word}, ${app.status.mode}`));
  return {};
}
"""
POINTS = """
notes = labrig_notes:NOTES
plain_notes = labrig_notes:PLAIN
failing = labrig_notes:FAILING
leaving = labrig_notes:LEAVING
bad = labrig_notes:BAD
odd = labrig_notes:ODD
holes = labrig_notes:HOLES
slow = labrig_notes:SLOW
list = labrig_list:PAGE
"""
DOCS = Path(__file__).parents[3] / "docs" / "howto" / "panel.md"


def documented(language: str) -> str:
    """The example of docs/howto/panel.md in this language, as it stands there."""
    (found,) = re.findall(rf"```{language}\n(.*?)```", DOCS.read_text("utf-8"), re.DOTALL)
    return str(found)


def documented_points() -> dict[str, str]:
    """The entry points of the docs' example."""
    points = tomllib.loads(documented("toml"))["project"]["entry-points"]
    return dict(points["labrig.page_panels"])


def install(where: Path) -> None:
    """`labrig-notes` 0.3, with the pages of the docs and eight more, of which one is faulty."""
    (where / "labrig_humidity.py").write_text(documented("python"))
    (where / "humidity_web").mkdir()
    (where / "humidity_web" / "page.js").write_text(documented("js"))
    (where / "humidity.csv").write_text("hour,percent\n8,41\n9,43\n")
    (where / "labrig_list.py").write_text(LIST)
    web = where / "labrig_notes_web"
    web.mkdir()
    (where / "labrig_notes.py").write_text(PLUGIN)
    (web / "page.js").write_text(PAGE_JS)
    (web / "word.js").write_text('export const word = "from another file";\n')
    (web / "secret.toml").write_text("key = 1\n")
    info = where / "labrig_notes-0.3.dist-info"
    info.mkdir()
    (info / "METADATA").write_text("Metadata-Version: 2.1\nName: labrig-notes\nVersion: 0.3\n")
    points = "".join(f"{name} = {point}\n" for name, point in documented_points().items())
    (info / "entry_points.txt").write_text("[labrig.page_panels]\n" + POINTS + points)


@contextmanager
def panel_with_plugins(where: Path) -> Iterator[Server]:
    """A panel of sessions in a process that finds the distribution."""
    install(where)
    with pytest.MonkeyPatch.context() as patch:
        path = os.pathsep.join(filter(None, [str(where), os.environ.get("PYTHONPATH", "")]))
        patch.setenv("PYTHONPATH", path)
        with panel(None, "--data", str(where)) as server:
            yield server
