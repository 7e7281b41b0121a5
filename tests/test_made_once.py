"""A folder that several workers need is made by one of them."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest

from tests.cases import few
from tests.made_once import made_once

ROOT = Path(__file__).parents[1]
TESTS = """
import pytest
from tests.made_once import made_once

@pytest.fixture(scope="session")
def folder(tmp_path_factory):
    def make(folder):
        folder.mkdir()
        with open(folder.parent / "log.txt", "a") as log:
            log.write("made\\n")
        (folder / "text.txt").write_text("whole")
    return made_once(tmp_path_factory, "shared", make)

@pytest.mark.parametrize("number", range(8))
def test_it_is_whole(folder, number):
    assert (folder / "text.txt").read_text() == "whole"
"""


@pytest.mark.slow
@pytest.mark.parametrize("workers", few([0, 2], 2))
def test_it_is_made_once_and_whole_in_each_worker(tmp_path: Path, workers: int) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    options = ["-q", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(ROOT), "-n", str(workers)]
    options += ["--dist", "load", "--basetemp", str(tmp_path / "temp")]
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_XDIST")}
    done = subprocess.run(
        [sys.executable, "-m", "pytest", *options, str(tmp_path / "test_some.py")],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert "8 passed" in done.stdout, done.stdout + done.stderr
    assert (tmp_path / "temp" / "log.txt").read_text() == "made\n"


@pytest.mark.slow
@pytest.mark.skipif(os.name != "posix", reason="whether a process is there is asked as in POSIX")
def test_a_worker_that_died_while_making_it_holds_nobody_back(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    dies = (
        "import os, sys\nfrom pathlib import Path\nfrom types import SimpleNamespace\n"
        "from tests.made_once import made_once\n"
        "factory = SimpleNamespace(getbasetemp=lambda: Path(sys.argv[1]))\n"
        "made_once(factory, 'half', lambda folder: (folder.mkdir(), os._exit(7)))\n"
    )
    base = tmp_path_factory.getbasetemp()
    base = base.parent if "PYTEST_XDIST_WORKER" in os.environ else base
    environment = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST_XDIST")}
    command = [sys.executable, "-c", dies, str(base)]
    assert subprocess.run(command, cwd=ROOT, env=environment, check=False).returncode == 7
    folder = made_once(tmp_path_factory, "half", lambda path: path.mkdir())
    assert folder.is_dir()


def test_where_making_it_failed_the_next_one_tries(
    tmp_path_factory: pytest.TempPathFactory,
) -> None:
    def fail(folder: Path) -> None:
        folder.mkdir()
        raise RuntimeError("no rig")

    with pytest.raises(RuntimeError, match="no rig"):
        made_once(tmp_path_factory, "unmade", fail)
    folder = made_once(tmp_path_factory, "unmade", lambda path: path.mkdir())
    assert folder.is_dir()
