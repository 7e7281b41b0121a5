"""Compiled code is kept from one start to the next, and never outlives a source it depends on."""

from __future__ import annotations

import gc
import importlib.util
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from numba.core import event

from labrig.vision.jit import jit

ROOT = Path(__file__).parents[1]
TOPS = ("labrig", "drivers", "protocols", "model", "sim_hardware")
MODULES = sorted(path for top in TOPS for path in (ROOT / top).rglob("jit.py"))
# The tests copy the file: of those with the same text one is enough.
DIFFERENT = list({path.read_bytes(): path for path in reversed(MODULES)}.values())

CALLED = "from {jit} import jit\n@jit\ndef part(x):\n    return x + 1.0\n"
CONSTANT = "OFFSET = 10.0\n"
TUPLES = """
from typing import NamedTuple
class Pair(NamedTuple):
    first: float
    second: float
"""
CALLER = """
from {jit} import jit
from {package}.called import part
from {package}.elsewhere.constant import OFFSET

@jit
def whole(x, pair):
    return part(x) + OFFSET + pair[1]
"""
RUN = """
from {package} import tuples
from {package}.inner.caller import whole
Pair = getattr(tuples, "Pair", None) or tuples.Renamed
found = whole(1.0, Pair(first=100.0, second=1000.0))
print(found, sum(whole.for_python().stats.cache_hits.values()))
"""


@pytest.fixture(params=DIFFERENT, ids=lambda path: path.parent.relative_to(ROOT).as_posix())
def package(request, tmp_path):
    """A small package that compiles with a copy of the real package's `jit`."""
    name = ".".join(request.param.parent.relative_to(ROOT).parts)
    folder = tmp_path.joinpath(*name.split("."))
    for inside in (folder, *folder.parents[: name.count(".")]):
        inside.mkdir(parents=True, exist_ok=True)
        (inside / "__init__.py").write_text("")
    (folder / "jit.py").write_bytes(request.param.read_bytes())
    files = {"called": CALLED, "elsewhere/constant": CONSTANT, "tuples": TUPLES}
    for where, text in {**files, "inner/caller": CALLER, "unrelated": "x = 1\n"}.items():
        path = folder / f"{where}.py"
        path.parent.mkdir(exist_ok=True)
        path.write_text(text.format(jit=f"{name}.jit", package=name))
    return Small(tmp_path, folder, name)


class Small:
    def __init__(self, root: Path, folder: Path, name: str) -> None:
        self.root, self.folder, self.name = root, folder, name

    def run(self) -> tuple[float, bool]:
        """What the compiled function returns in a new process, and whether it was kept."""
        environment = {**os.environ, "PYTHONPATH": str(self.root), "PYTHONDONTWRITEBYTECODE": "1"}
        environment.pop("NUMBA_CACHE_DIR", None)
        code = RUN.format(package=self.name)
        ran = subprocess.run(
            [sys.executable, "-c", code], env=environment, cwd=self.root,
            capture_output=True, text=True, check=True,
        )  # fmt: skip
        value, hits = ran.stdout.split()
        return float(value), int(hits) > 0

    def edit(self, where: str, old: str, new: str) -> None:
        path = self.folder / f"{where}.py"
        text = path.read_text()
        assert old in text
        path.write_text(text.replace(old, new))


@pytest.mark.thorough
@pytest.mark.slow
def test_a_change_in_another_file_and_a_renamed_class_are_compiled_in(package):
    assert package.run() == (1012.0, False)
    assert package.run() == (1012.0, True)  # from the disk
    package.edit("called", "x + 1.0", "x + 2.0")
    assert package.run() == (1013.0, False)
    package.edit("elsewhere/constant", "10.0", "20.0")
    assert package.run() == (1023.0, False)
    package.edit("tuples", "first: float\n    second: float", "second: float\n    first: float")
    assert package.run() == (123.0, False)
    # what is kept holds the class by its name, and could not be loaded any more
    package.edit("tuples", "class Pair", "class Renamed")
    assert package.run() == (123.0, False)
    package.edit("unrelated", "x = 1", "x = 2")
    assert package.run() == (123.0, True)


@pytest.mark.thorough
@pytest.mark.slow
def test_python_and_compiled_functions_call_the_same_function(package):
    code = (
        f"from {package.name}.called import part\n"
        f"from {package.name}.inner.caller import whole\n"
        f"from {package.name}.tuples import Pair\n"
        "print(whole(1.0, Pair(100.0, 1000.0)), part(x=1.0))"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(package.root)},
        cwd=package.root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ran.stdout.split() == ["1012.0", "2.0"]


LATER = """
import numpy as np
from {package}.jit import jit
from {package}.called import part

@jit
def later(x):
    return np.sum(np.ones(3)) * part(x)
"""


@pytest.mark.slow
def test_what_is_kept_is_loaded_without_what_only_compiling_needs_which_works_afterwards(package):
    assert package.run() == (1012.0, False)
    (package.folder / "later.py").write_text(LATER.format(package=package.name))
    code = (
        "import sys\n"
        f"{RUN.format(package=package.name)}"
        "print('numba.np.arraymath' in sys.modules)\n"
        f"from {package.name}.later import later\n"
        "print(later(1.0), 'numba.np.arraymath' in sys.modules)"
    )
    ran = subprocess.run(
        [sys.executable, "-c", code], env={**os.environ, "PYTHONPATH": str(package.root)},
        cwd=package.root, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert ran.stdout.split() == ["1012.0", "1", "False", "6.0", "True"]


def test_packages_that_compile_have_equal_modules():
    texts = {path.read_text(encoding="utf-8") for path in MODULES}
    assert len(texts) == 1, [str(path.relative_to(ROOT)) for path in MODULES]


def test_model_compiles_through_its_module_alone():
    users = [
        path.relative_to(ROOT).as_posix()
        for path in sorted((ROOT / "model").rglob("*.py"))
        if re.search(r"^\s*(import|from) numba\b", path.read_text(encoding="utf-8"), re.MULTILINE)
    ]
    assert users == ["model/jit.py"]


@pytest.mark.slow
def test_compiling_leaves_the_search_for_garbage_as_it_was(tmp_path):
    import labrig.vision.jit  # noqa: F401 - a second package that listens

    before, called = gc.get_threshold(), []
    # a new file: what is kept of an old one would not be compiled
    source = tmp_path / "doubling.py"
    source.write_text("from model.jit import jit\n@jit\ndef doubled(x):\n    return 2.0 * x\n")
    spec = importlib.util.spec_from_file_location("doubling", source)
    doubling = importlib.util.module_from_spec(spec)
    sys.modules["doubling"] = doubling
    spec.loader.exec_module(doubling)
    with event.install_listener("numba:compile", Noting(called)):
        assert doubling.doubled(1.5) == 3.0
    del sys.modules["doubling"]
    assert called == [400_000]
    assert gc.get_threshold() == before


class Noting(event.Listener):
    def __init__(self, into: list[int]) -> None:
        self.into = into

    def on_start(self, event):
        self.into.append(gc.get_threshold()[0])

    def on_end(self, event):
        pass


@pytest.mark.parametrize(
    ("behind", "raised"), [(KeyboardInterrupt(), KeyboardInterrupt), (None, SystemError)]
)
def test_ctrl_c_in_compiled_code_is_no_fault_of_it(behind, raised):
    unpickling = SystemError("_numba_unpickle returned a result with an exception set")
    unpickling.__cause__ = behind
    fault = SystemError("CPUDispatcher(half) returned a result with an exception set")
    fault.__cause__ = unpickling

    def stopped(number):
        raise fault

    compiled = jit(half)
    compiled.for_python = lambda: stopped
    with pytest.raises(raised):
        compiled(1.0)


def half(number):
    return number / 2
