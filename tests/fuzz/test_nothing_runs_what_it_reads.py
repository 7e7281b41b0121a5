"""No file that labrig reads can bring code with it: nothing unpickles, evaluates or executes."""

from __future__ import annotations

import ast
from collections.abc import Iterator
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
PACKAGES = ("labrig", "drivers", "protocols", "model", "sim_hardware")
MODULES = {"pickle", "cPickle", "dill", "cloudpickle", "joblib", "shelve", "marshal", "yaml"}
# These unpickle what labrig's own processes wrote to one another, never what is read from a file.
BETWEEN_OWN_PROCESSES = {"labrig/batch/pool.py", "labrig/batch/conformance.py"}
CALLS = {"eval", "exec", "compile", "__import__"}


def faults(tree: ast.AST) -> Iterator[str]:
    """What of a module would run, or could run, what was read."""
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (a.name for a in node.names if a.name.split(".")[0] in MODULES)
        elif isinstance(node, ast.ImportFrom) and (node.module or "").split(".")[0] in MODULES:
            yield str(node.module)
        elif isinstance(node, ast.Call):
            if isinstance(node.func, ast.Name) and node.func.id in CALLS:
                yield node.func.id
            for word in node.keywords:
                allowed = isinstance(word.value, ast.Constant) and word.value.value is False
                if word.arg in ("allow_pickle", "shell") and not allowed:
                    yield str(word.arg)


def test_the_search_finds_what_it_looks_for() -> None:
    text = "import pickle\nfrom yaml import load\neval(x)\nnp.load(f, allow_pickle=True)\n"
    assert list(faults(ast.parse(text))) == ["pickle", "yaml", "eval", "allow_pickle"]


@pytest.mark.slow  # hundreds of files
@pytest.mark.parametrize("package", PACKAGES)
def test_no_module_of_a_package_runs_what_it_reads(package: str) -> None:
    sources = sorted((ROOT / package).rglob("*.py"))
    assert sources
    found = {
        path.relative_to(ROOT).as_posix(): bad
        for path in sources
        if (bad := list(faults(ast.parse(path.read_text(encoding="utf-8")))))
    }
    own = {name: ["pickle"] for name in BETWEEN_OWN_PROCESSES if name.startswith(f"{package}/")}
    assert found == own


def test_a_pickle_in_a_numpy_file_is_not_loaded_by_default() -> None:
    import io

    import numpy as np

    file = io.BytesIO()
    np.save(file, np.array([{"a": 1}], dtype=object), allow_pickle=True)
    file.seek(0)
    with pytest.raises(ValueError, match="allow_pickle"):
        np.load(file)
