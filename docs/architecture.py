"""Draw the architecture from the code's own imports: `python docs/architecture.py` writes the page.

The page has a table of the folders by layers for each package, and a Mermaid diagram where it can
be read: an arrow A --> B says that a module of A imports one of B. A test holds the page equal to
the code.
"""

from __future__ import annotations

import ast
import sys
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
PAGE = ROOT / "docs" / "reference" / "architecture.md"
PACKAGES = ("labrig", "protocols", "drivers", "model", "sim_hardware")
DRAWN_ARROWS = 15  # more of them nobody follows: the layers in the table say as much
HEAD = """# Architecture

The folders are the architecture. The tables and the arrows of this page are made from the code
(`python docs/architecture.py`).

## How data flow

```mermaid
flowchart LR
    protocol([protocol.toml]) --> planning[protocols: planning] --> execution[protocols: execution]
    execution <--> drivers[drivers, with their guard]
    drivers <--> rig[the rig, or sim_hardware at the wire]
    execution --> session([session.h5: labrig.session])
    session --> vision[labrig.vision: curves] --> analysis[labrig.analysis: measurements]
    analysis --> identification[model: identification, B and EIBM]
    identification --> discrepancy[model: discrepancy, what is not in the model]
    discrepancy --> file([model.toml]) --> sheet[model: sheet and dynamics, predictions]
    discrepancy --> report[labrig.report, labrig.panel]
```

## To change something

| to change | open |
|---|---|
| the voltages and readings of a protocol | `protocols/kinds`, one file each |
| how a run is carried out, and what ends it | `protocols/execution`, `labrig/experiment` |
| what writes 0 V, and when | `drivers/guard`, `labrig/experiment` |
| a device | `drivers/boards`, `cameras`, `positioners`, `force_sensors`, one file each |
| a key of a configuration file | `labrig/config` |
| the layout of the session file | `labrig/session` |
| how a curve is found in an image | `labrig/vision`; what refuses it: `checks/kinds` there |
| the mechanics of the sheet | `model/mechanics` at rest, `model/dynamics` in time |
| an effect | `model/effects`, one file each |
| the fit of B and EIBM | `model/identification` |
| what is named, and with which probability | `model/discrepancy`; its numbers: `thresholds.py` |
| a command | `labrig/cli/commands`, one file each |
| a page of the panel | `labrig/panel/pages`, one file each |
| a section of the report | `labrig/report/sections`, one file each |
| what the simulated rig does | `sim_hardware/world`; its devices beside it |

The contract of each kind of part: [extending labrig](../howto/extending.md).
"""


def main() -> int:
    """Write the page."""
    PAGE.write_text(page(), encoding="utf-8")
    sys.stdout.write(f"wrote {PAGE.relative_to(ROOT)}\n")
    return 0


def page() -> str:
    """Return the page's text."""
    known = modules()
    parts = [HEAD, "## Packages\n\nAn arrow: the one imports the other.\n"]
    parts.append(diagram(arrows(known, 1, "packages"), ""))
    for package in PACKAGES:
        pairs = arrows(known, 2, package)
        parts.append(f"## {package}\n\n{summary(ROOT / package)}\n")
        parts.append(table(package, layers(pairs)))
        if len(pairs) <= DRAWN_ARROWS:
            parts.append(diagram(pairs, f"{package}."))
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
    """Return a module's code: it is asked for again and again."""
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def import_lines(path: Path) -> list[ast.AST]:
    """Return what a module imports: each diagram asks for it anew."""
    return [
        node for node in ast.walk(parsed(path)) if isinstance(node, ast.Import | ast.ImportFrom)
    ]


def imports(name: str, known: dict[str, Path]) -> Iterator[str]:
    """Yield the modules of ours that a module imports."""
    for node in import_lines(known[name]):
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


def diagram(pairs: Sequence[tuple[str, str]], prefix: str) -> str:
    """Return a Mermaid diagram of the imports between folders, named without a prefix."""
    lines = [f"    {one} --> {two}" for one, two in pairs]
    text = "\n".join(["```mermaid", "flowchart TD", *lines, "```", ""])
    return text.replace(prefix, "") if prefix else text


def layers(pairs: Sequence[tuple[str, str]]) -> dict[str, int]:
    """Return the layer of each folder: 1 imports no other, each one some of the layer below it.

    Folders that import each other, perhaps by way of others, share a layer.
    """
    reached: dict[str, set[str]] = {name: set() for pair in pairs for name in pair}
    for one, two in pairs:
        reached[one].add(two)
    for _ in reached:
        for found in reached.values():
            found |= {further for name in found for further in reached[name]}

    def layer(name: str) -> int:
        below = [other for other in reached[name] if name not in reached[other]]
        return 1 + max(map(layer, below), default=0)

    return {name: layer(name) for name in reached}


def table(package: str, layer: dict[str, int]) -> str:
    """Return the table of a package's folders and modules with what each holds, from the top."""
    rows = []
    for path in sorted((ROOT / package).iterdir()):
        number = layer.get(f"{package}.{path.stem}", 1)
        if (path / "__init__.py").exists():
            rows.append((-number, f"| {number} | `{path.name}/` | {summary(path)} |"))
        elif path.suffix == ".py" and not path.name.startswith("__"):
            rows.append((-number, f"| {number} | `{path.stem}` | {first_line(path)} |"))
    said = "Each part imports from lower layers alone, or from its own where two import each other."
    head = [said, "", "| layer | part | holds |", "|---|---|---|"]
    return "\n".join([*head, *(text for _, text in sorted(rows)), ""])


def summary(folder: Path) -> str:
    """Return the first line of a package's docstring."""
    return first_line(folder / "__init__.py")


def first_line(path: Path) -> str:
    """Return the first line of a module's docstring."""
    text = ast.get_docstring(parsed(path)) or ""
    return text.split("\n", maxsplit=1)[0]


if __name__ == "__main__":
    sys.exit(main())
