"""The end of a test run says which tests ran that need a package of the system."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from tests.cases import few

ROOT = Path(__file__).parents[1]
TESTS = """
import pytest

@pytest.mark.system_package("Chromium")
@pytest.mark.parametrize("number", [1, 2])
def test_of_a_page(number):
    pass

@pytest.mark.system_package("Aravis")
def test_of_a_camera():
    pytest.skip("no library libaravis")

def test_of_nothing():
    pass
"""


@pytest.mark.slow
@pytest.mark.parametrize("workers", few([0, 1], 1))
def test_it_says_what_ran_and_why_the_others_did_not(tmp_path: Path, workers: int) -> None:
    (tmp_path / "test_some.py").write_text(TESTS)
    options = ["-q", "-c", str(ROOT / "pyproject.toml"), "--rootdir", str(ROOT), "-p"]
    command = [sys.executable, "-m", "pytest", *options, "tests.conftest", "-n", str(workers)]
    done = subprocess.run(
        [*command, str(tmp_path)], cwd=ROOT, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stdout + done.stderr
    assert "tests that need Chromium: 2 ran\n" in done.stdout
    assert "tests that need Aravis: 1 did not (no library libaravis)\n" in done.stdout
