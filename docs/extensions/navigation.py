"""The tree of all pages beside each page, without copying the headings within them.

Sphinx copies the headings of every page for every page, and then drops all but the titles. That is
a quarter of the time of a build without its commands. Here they are dropped once.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from typing import Any

from docutils import nodes
from sphinx import addnodes
from sphinx.application import Sphinx

BEFORE_THE_THEME = 400  # priority; the theme's own is the default, 500


def _page_context(
    app: Sphinx, _pagename: str, _template: str, context: dict[str, Any], _doctree: Any
) -> None:
    if "toctree" in context:
        context["toctree"] = _with_titles(app, context["toctree"])


def _with_titles(app: Sphinx, toctree: Callable[..., str]) -> Callable[..., str]:
    """Return a template's `toctree`, quicker where only titles are asked for."""

    def quicker(**options: Any) -> str:
        if not options.get("titles_only"):
            return toctree(**options)
        whole = app.env.tocs
        app.env.tocs = _titles(app)
        try:
            return toctree(**options)
        finally:
            app.env.tocs = whole

    return quicker


@cache
def _titles(app: Sphinx) -> dict[str, nodes.bullet_list]:
    return {page: _title(toc) for page, toc in app.env.tocs.items()}


def _title(toc: nodes.bullet_list) -> nodes.bullet_list:
    """Return a page's headings without those below its titles, but with its trees of pages."""
    kept = toc.deepcopy()
    for title in kept.children:
        if isinstance(title, nodes.Element) and len(title) > 1:
            below = title[1]
            trees = list(title.findall(addnodes.toctree))
            title.remove(below)
            if trees:
                empty = below.copy()
                empty += trees
                title += empty
    return kept


def setup(app: Sphinx) -> dict[str, Any]:
    """Put it before the theme's own."""
    app.connect("html-page-context", _page_context, priority=BEFORE_THE_THEME)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
