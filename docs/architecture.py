"""Draw the architecture from the code's own imports: `python docs/architecture.py` writes the page.

The page has a table of the folders and a Mermaid diagram for each package: an arrow A --> B says
that a module of A imports one of B. A test holds the page equal to the code.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "architecture.md"
PACKAGES = ("labrig", "protocols", "drivers", "model", "sim_hardware")
HEAD = """# Architecture

The folders are the architecture. This page is made from the code (`python docs/architecture.py`).
An arrow says that something in one folder imports something in the other.
"""


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE.relative_to(ROOT)}\n")
    return 0


def page() -> str:
    """Return the page's text."""
    known = modules()
    parts = [HEAD, "## Packages\n", diagram("packages", known, 1)]
    for package in PACKAGES:
        parts.append(f"## {package}\n\n{summary(ROOT / package)}\n")
        parts.append(table(package))
        parts.append(diagram(package, known, 2))
    return "\n".join(parts)


def modules() -> dict[str, Path]:
    """Return all modules by their dotted names."""
    return {
        ".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__init__"): path
        for package in PACKAGES
        for path in sorted((ROOT / package).rglob("*.py"))
    }


@cache
def parsed(path: Path) -> ast.Module:
    """Return a module's code: each diagram asks for it anew."""
    return ast.parse(path.read_text(encoding="utf-8"))


def imports(name: str, known: dict[str, Path]) -> Iterator[str]:
    """Yield the modules of ours that a module imports."""
    for node in ast.walk(parsed(known[name])):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names if alias.name in known)
        elif isinstance(node, ast.ImportFrom) and node.module:
            inner = (f"{node.module}.{alias.name}" for alias in node.names)
            yield from (dotted if dotted in known else node.module for dotted in inner)


def arrows(known: dict[str, Path], depth: int, within: str) -> list[tuple[str, str]]:
    """Return the pairs of folders, cut at `depth`, of which the first imports the second."""
    pairs = set()
    for name in (name for name in known if is_in(name, within)):
        for other in imports(name, known):
            one, two = (".".join(dotted.split(".")[:depth]) for dotted in (name, other))
            if one != two and other in known and is_in(one, within) and is_in(two, within):
                pairs.add((one, two))
    return sorted(pairs)


def is_in(folder: str, within: str) -> bool:
    """Return whether a folder belongs into a diagram."""
    return within == "packages" or folder.startswith(f"{within}.")


def diagram(within: str, known: dict[str, Path], depth: int) -> str:
    """Return a Mermaid diagram of the imports between folders."""
    lines = [f"    {one} --> {two}" for one, two in arrows(known, depth, within)]
    prefix = f"{within}."
    return "\n".join(["```mermaid", "flowchart TD", *lines, "```", ""]).replace(prefix, "")


def table(package: str) -> str:
    """Return the table of a package's folders and modules with what each holds."""
    rows = ["| part | holds |", "|---|---|"]
    for path in sorted((ROOT / package).iterdir()):
        if (path / "__init__.py").exists():
            rows.append(f"| `{path.name}/` | {summary(path)} |")
        elif path.suffix == ".py" and not path.name.startswith("__"):
            rows.append(f"| `{path.stem}` | {first_line(path)} |")
    return "\n".join([*rows, ""])


def summary(folder: Path) -> str:
    """Return the first line of a package's docstring."""
    return first_line(folder / "__init__.py")


def first_line(path: Path) -> str:
    """Return the first line of a module's docstring."""
    text = ast.get_docstring(parsed(path)) or ""
    return text.split("\n", maxsplit=1)[0]


if __name__ == "__main__":
    sys.exit(main())
