"""What can be held of Windows on another system: no module needs what only POSIX has."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
PACKAGES = ("labrig", "drivers", "protocols", "model", "sim_hardware")
POSIX_MODULES = {
    "crypt", "curses", "fcntl", "grp", "nis", "pty", "pwd", "readline", "resource", "spwd",
    "syslog", "termios", "tty",
}  # fmt: skip
POSIX_NAMES = {
    "chown", "fchmod", "fork", "forkpty", "geteuid", "getpgid", "getpriority", "getuid", "killpg",
    "mkfifo", "nice", "openpty", "sched_setscheduler", "setpriority", "setsid", "ttyname", "uname",
    "wait4",
    "SIGALRM", "SIGHUP", "SIGKILL", "SIGPIPE", "SIGQUIT", "SIGUSR1", "SIGUSR2", "pthread_kill",
    "setitimer", "sigwait",
}  # fmt: skip
_GUARD = re.compile(r"sys\.platform|os\.name|hasattr\(|getattr\(")

AS_ON_WINDOWS = f"""
import importlib, importlib.abc, os, pkgutil, signal, sys

class Hidden(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name in {POSIX_MODULES!r}:
            raise ModuleNotFoundError(f"No module named {{name!r}}", name=name)

# what labrig's own modules ask for, once the packages that they use are there
import numba, numpy, scipy.optimize, h5py, cv2, matplotlib.figure, nidaqmx, grpc, fastapi, uvicorn
import typer, rich.progress, pydantic, serial, jinja2, tomlkit, multiprocessing.connection
for name in {POSIX_MODULES!r}:
    sys.modules.pop(name, None)
sys.meta_path.insert(0, Hidden())
for name in {POSIX_NAMES!r}:
    for module in (os, signal):
        if hasattr(module, name):
            delattr(module, name)
imported = 0
for package in {PACKAGES!r}:
    for found in pkgutil.walk_packages([package], package + "."):
        if not found.name.endswith("__main__"):
            importlib.import_module(found.name)
            imported += 1
print(imported)
"""


@pytest.mark.slow
def test_every_module_is_imported_without_what_only_posix_has():
    found = subprocess.run(
        [sys.executable, "-c", AS_ON_WINDOWS], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert found.returncode == 0, found.stderr[-2000:]
    assert int(found.stdout) > 700


def modules() -> list[Path]:
    return [path for package in PACKAGES for path in (ROOT / package).rglob("*.py")]


@pytest.mark.slow
def test_what_only_posix_has_is_used_where_the_system_was_asked_for():
    found = [place for path in modules() for place in _unguarded(path)]
    assert found == []


def _unguarded(path: Path) -> list[str]:
    """Places that use what only POSIX has in no function, class body or condition that asks."""
    text = path.read_text(encoding="utf-8")
    if not any(name in text for name in POSIX_MODULES | POSIX_NAMES):
        return []
    tree = ast.parse(text)
    parents = {child: node for node in ast.walk(tree) for child in ast.iter_child_nodes(node)}
    return [
        f"{path.relative_to(ROOT).as_posix()}:{node.lineno}"
        for node in ast.walk(tree)
        if _is_posix(node) and not _asks(node, parents, text)
    ]


def _is_posix(node: ast.AST) -> bool:
    if isinstance(node, ast.Import):
        return any(alias.name.split(".")[0] in POSIX_MODULES for alias in node.names)
    if isinstance(node, ast.ImportFrom):
        return node.level == 0 and (node.module or "").split(".")[0] in POSIX_MODULES
    owner = node.value if isinstance(node, ast.Attribute) else None
    return isinstance(owner, ast.Name) and owner.id in {"os", "signal"} and node.attr in POSIX_NAMES


def _asks(node: ast.AST, parents: dict[ast.AST, ast.AST], text: str) -> bool:
    """Whether a condition above it, or its function before it, asks for the system."""
    while node in parents:
        node = parents[node]
        if isinstance(node, ast.If | ast.IfExp) and _GUARD.search(ast.unparse(node.test)):
            return True
        if isinstance(node, ast.FunctionDef) and _GUARD.search(
            ast.get_source_segment(text, node) or ""
        ):
            return True
    return False


def test_the_workflow_runs_the_pythons_that_the_package_names():
    workflow = (ROOT / ".github/workflows/ci.yml").read_text(encoding="utf-8")
    project = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    named = re.findall(r'"Programming Language :: Python :: (3\.\d+)"', project)
    assert named == re.findall(r'"(3\.\d+)"', re.search(r"python: \[(.*)\]", workflow)[1])
    assert "os: [ubuntu-latest, windows-latest]" in workflow
