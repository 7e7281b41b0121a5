"""The contract of a page of the operator's panel."""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any, Literal

from drivers.plugins import Part, PluginFolder
from labrig.left_out import same_title
from labrig.panel.pages.conformance import faults

if TYPE_CHECKING:
    from fastapi import APIRouter

    from labrig.panel.core.panel import Panel

Mode = Literal["rig", "sessions", "replay", "photographs"]  # what a panel was started with
# but for photographs: such a panel shows its own page and nothing else
EVERYWHERE: frozenset[Mode] = frozenset({"rig", "sessions", "replay"})
NOWHERE: frozenset[Mode] = frozenset()
STATIC = Path(__file__).parents[1] / "static"
OWN_SCRIPTS = STATIC / "js" / "pages"
_ADDRESS = re.compile(r"[a-z0-9][a-z0-9_-]*")
GENERIC_SCRIPT = "/static/js/data_page.js"


@dataclass(frozen=True, kw_only=True)
class PanelPage:
    """A page of the panel; its name, and with it its address, is that of its file or entry point.

    Without `script` the page shows what `data` returns: `{"sentences": [...], "tables": [{"title",
    "columns", "rows"}]}`, both optional. With one, that is for the script alone.
    """

    title: str  # in the menu, unlike any other page's there
    order: float  # pages stand in ascending order; fractions leave room between two
    modes: frozenset[Mode] = EVERYWHERE  # panels whose menu has it; NOWHERE: reached by links
    opens: frozenset[Mode] = NOWHERE  # panels that begin with it
    # JavaScript module with `mount(place, app, asked)`; other files of its folder are served too.
    script: Path | None = None
    # Routes of its own. Those of another distribution stand below /api/pages/NAME. A function that
    # is not `async` runs in a thread and may block; LabrigError is answered as its sentence.
    router: APIRouter | None = None
    # Answers GET /api/pages/NAME with JSON. Called for each request, in a thread: it may block.
    data: Callable[[Panel], Any] | None = None


PAGES: PluginFolder[PanelPage] = PluginFolder(
    what="page of the panel",
    package="labrig.panel.pages",
    constant="PAGE",
    group="labrig.page_panels",
    faults=faults,
)


def own_script(name: str) -> Path:
    """Return the module of one of our own pages."""
    return OWN_SCRIPTS / f"{name}.js"


def address_of(name: str) -> str:
    """Return a page's address: its name with hyphens."""
    return name.replace("_", "-")


def ordered() -> dict[str, Part[PanelPage]]:
    """Return all pages by address, in the order of the menu.

    Of one address, and of one title in one menu, the first stays; our own come first.
    """
    found: dict[str, Part[PanelPage]] = {}
    for name, part in PAGES.parts().items():
        if not _why_left_out(name, part.part, found):
            found[address_of(name)] = part
    return dict(sorted(found.items(), key=lambda item: (item[1].part.order, item[0])))


def left_out() -> list[str]:
    """Return a sentence for each page that cannot stand beside the others."""
    pages = ordered()
    return [
        f"the page of the panel '{name}' of {part.distribution} is left out: "
        f"{_why_left_out(name, part.part, pages)}."
        for name, part in PAGES.parts().items()
        if pages.get(address_of(name)) is not part
    ]


def _why_left_out(name: str, page: PanelPage, known: Mapping[str, Part[PanelPage]]) -> str:
    """Return what keeps a page from standing beside those that are known; empty: nothing."""
    if not _ADDRESS.fullmatch(name) or address_of(name) in known:
        return (
            "its name must be small letters, digits, hyphens and underscores, and no other page's"
        )
    for other in known.values():
        if same_title(other.part.title, page.title) and other.part.modes & page.modes:
            return (
                f"there is a page with the title '{other.part.title}' already "
                f"('{other.name}' of {other.distribution})"
            )
    return ""


def script_address(address: str, page: PanelPage) -> str:
    """Return where a page's module is served."""
    if page.script is None:
        return GENERIC_SCRIPT
    if page.script.is_relative_to(STATIC):
        return f"/static/{page.script.relative_to(STATIC).as_posix()}"
    return f"/plugins/{address}/{page.script.name}"


def listing(mode: Mode) -> dict[str, Any]:
    """Return the menu, all pages, and the one to begin with, for `GET /api/status`."""
    pages = {address: part.part for address, part in ordered().items()}
    first = [address for address, page in pages.items() if mode in page.opens]
    return {
        "pages": [
            {
                "name": address,
                "title": page.title,
                "menu": mode in page.modes,
                "script": script_address(address, page),
            }
            for address, page in pages.items()
        ],
        "first": first[0] if first else None,
    }
