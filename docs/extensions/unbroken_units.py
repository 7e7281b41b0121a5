"""A number and its unit stay on one line: the space between them does not break."""

from __future__ import annotations

import re
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx

_UNIT = "%|(?:[kM]?Hz|[MG]B|[kM]?Pa|[kMµmn]?[mNVAWJs]|µN·m|rad|px|pixels|degrees|min|per m)(?!\\w)"
_SPACE = re.compile(f"(?<=\\d) (?={_UNIT})")
_AS_WRITTEN = (nodes.literal, nodes.literal_block, nodes.raw, nodes.title)  # a title is an address


def unbroken(text: str) -> str:
    """Return a text with a no-break space between each number and its unit."""
    return _SPACE.sub("\N{NO-BREAK SPACE}", text)


def _on_read(_app: Sphinx, doctree: nodes.document) -> None:
    for text in list(doctree.findall(nodes.Text)):
        kept = unbroken(str(text))
        if kept != text and not isinstance(text.parent, _AS_WRITTEN):
            text.parent.replace(text, nodes.Text(kept))


def setup(app: Sphinx) -> dict[str, Any]:
    """Change each page as it is read."""
    app.connect("doctree-read", _on_read)
    return {"version": "1", "parallel_read_safe": True, "parallel_write_safe": True}
