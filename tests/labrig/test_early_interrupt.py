"""Ctrl-C while the program is still being imported: a sentence and the code, no traceback."""

from __future__ import annotations

import subprocess
import sys

import pytest

# Python calls weak references' callbacks amid an import, and ignores what is raised there.
START = """
import sys


class Callback:
    def __del__(self):
        raise KeyboardInterrupt


class Finder:
    def find_spec(self, name, path=None, target=None):
        if name == "labrig.cli.main":
            {interrupt}


sys.meta_path.insert(0, Finder())
from labrig.cli import main

main()
"""


@pytest.mark.parametrize("interrupt", ["raise KeyboardInterrupt", "Callback()"])
def test_an_interrupt_amid_the_imports_ends_the_program_in_words(interrupt: str) -> None:
    done = subprocess.run(
        [sys.executable, "-c", START.format(interrupt=interrupt), "--version"],
        capture_output=True,
        text=True,
        timeout=60,
        check=False,
    )
    assert (done.returncode, done.stderr, done.stdout) == (4, "labrig: stopped.\n", "")
