"""`python -m benchmarks [NAME ...]`: run the named benchmarks, or all; print and keep the tables.

A benchmark is a module of this folder with a function `measure() -> Report`, or one with a `main()`
that prints; of the latter the printed text is kept. Modules that begin with _ are parts of others.
"""

from __future__ import annotations

import importlib
import os
import re
import subprocess
import sys
from pathlib import Path

from benchmarks.report import Report, machine, save

_HERE = Path(__file__).parent
_MEASURES = re.compile(r"^def measure\(\) -> Report:", re.MULTILINE)
_PRINTS = re.compile(r"^def main\(", re.MULTILINE)


def names() -> list[str]:
    """All benchmarks, by name."""
    return [
        path.stem
        for path in sorted(_HERE.glob("[!_]*.py"))
        if _MEASURES.search(text := path.read_text(encoding="utf-8")) or _PRINTS.search(text)
    ]


def run(name: str) -> None:
    """Run one, print it, keep it."""
    print(f"\n## {name}\n", flush=True)
    where = machine()
    if _MEASURES.search((_HERE / f"{name}.py").read_text(encoding="utf-8")):
        report: Report = importlib.import_module(f"benchmarks.{name}").measure()
        print(report.text())
    else:
        report = _printed(name)
    print(f"\nkept as {save(name, where, report)}", flush=True)


def _printed(name: str) -> Report:
    """Run a benchmark that prints in a process of its own, showing what it prints as it comes."""
    process = subprocess.Popen(
        [sys.executable, "-m", f"benchmarks.{name}"],
        cwd=_HERE.parent,
        env=os.environ | {"PYTHONUNBUFFERED": "1"},
        stdout=subprocess.PIPE,
        text=True,
        encoding="utf-8",
    )
    lines: list[str] = []
    for line in process.stdout or ():
        print(line, end="", flush=True)
        lines.append(line.rstrip("\n"))
    if process.wait():
        raise SystemExit(f"benchmarks.{name} ended with code {process.returncode}")
    return Report(tables=(), figures={}, notes=tuple(lines))


def main(wanted: list[str]) -> None:
    """Run what is wanted, in the order given."""
    known = names()
    unknown = [name for name in wanted if name not in known]
    if unknown:
        raise SystemExit(f"no benchmark {', '.join(unknown)} among {', '.join(known)}")
    for name in wanted or known:
        run(name)


if __name__ == "__main__":
    main(sys.argv[1:])
