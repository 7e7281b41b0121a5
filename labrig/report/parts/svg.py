"""A figure's SVG made fit to stand inside a page: names of its own, the page's ink, no metadata."""

from __future__ import annotations

import re

from labrig.report.parts.style import INK

_PX_PER_PT = 1.5  # a little larger than life
_WIDTH = re.compile(r'<svg\b[^>]*?\bwidth="([\d.]+)pt"')
_ID = re.compile(r'(\bid="|url\(#|href="#)([^")]+)')
_HEAD = re.compile(r"^.*?(?=<svg)", re.DOTALL)
_METADATA = re.compile(r"\s*<metadata>.*?</metadata>", re.DOTALL)


def inline(svg: str, name: str, described: str) -> str:
    """Return the <svg> element; neutral lines and text take the colour of the text around it."""
    text = _METADATA.sub("", _HEAD.sub("", svg, count=1))
    text = _ID.sub(rf"\g<1>{name}-\g<2>", text)
    width = _WIDTH.search(text)
    for side in ("width", "height"):
        text = re.sub(rf'(<svg\b[^>]*?)\s+{side}="[^"]*"', r"\1", text, count=1)
    label = described.replace("&", "&amp;").replace('"', "&quot;").replace("<", "&lt;")
    wide = f' style="max-width: {float(width[1]) * _PX_PER_PT:.0f}px"' if width else ""
    text = text.replace("<svg", f'<svg role="img" aria-label="{label}"{wide}', 1)
    return text.replace(INK, "currentColor")
