"""Pages and drawings that are made from the code when the documentation is built.

Each module of this folder has `page()`, the text of reference/made/NAME.md, or `pages()`, the texts
of several such pages by their names. Each module of `drawings` has
`figure()`, the drawing images/made/NAME.svg. Neither is kept in git.
"""

from __future__ import annotations

import sys
from importlib import import_module
from pathlib import Path


def write_pages(docs: Path) -> None:
    """Write all pages and drawings; files that stay as they are are not touched."""
    for name in modules_of(docs / "made"):
        for page, text in pages_of(name).items():
            _write(docs / "reference" / "made" / f"{page}.md", text)
    for name in modules_of(docs / "drawings"):
        path = docs / "images" / "made" / f"{name}.svg"
        if not path.exists() or path.stat().st_mtime < _newest(docs / "drawings"):
            _draw(name, path)


def pages_of(name: str) -> dict[str, str]:
    """Return the pages of a module of this folder, by their names."""
    module = import_module(f"made.{name}")
    pages: dict[str, str] = module.pages() if hasattr(module, "pages") else {name: module.page()}
    return pages


def modules_of(folder: Path) -> list[str]:
    """Return the names of the modules of a folder."""
    return sorted(path.stem for path in folder.glob("[a-z]*.py"))


def _newest(folder: Path) -> float:
    return max(path.stat().st_mtime for path in folder.glob("*.py"))


def _write(path: Path, text: str) -> None:
    path.parent.mkdir(parents=True, exist_ok=True)
    if not path.exists() or path.read_text(encoding="utf-8") != text:
        path.write_text(text, encoding="utf-8")


def _draw(name: str, path: Path) -> None:
    import matplotlib as mpl

    mpl.use("svg")
    path.parent.mkdir(parents=True, exist_ok=True)
    drawing = import_module(f"drawings.{name}").figure()
    drawing.savefig(path, metadata={"Date": None})


if __name__ == "__main__":
    write_pages(Path(__file__).parents[1])
    sys.stdout.write("wrote the made pages\n")
