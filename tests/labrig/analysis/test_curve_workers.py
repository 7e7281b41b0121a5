"""Processes that share the search for curves."""

from __future__ import annotations

import subprocess
import sys
from types import SimpleNamespace

import pytest

from labrig.analysis import curves

SCRIPT = """
from pathlib import Path
from labrig.analysis.curves import by_processes

list(by_processes(Path("day1.h5"), [None] * 4, workers=2))
"""


@pytest.mark.thorough
@pytest.mark.slow
def test_a_script_that_its_own_workers_begin_anew_is_told_so_in_one_sentence(tmp_path):
    script = tmp_path / "evaluate.py"
    script.write_text(SCRIPT, encoding="utf-8")
    ended = subprocess.run(
        [sys.executable, str(script)], capture_output=True, text=True, timeout=60, check=False
    )
    assert ended.returncode == 1
    assert "BrokenProcessPool" not in ended.stderr
    assert ended.stderr.count("Traceback") == 1  # that of the script itself
    said = ended.stderr.strip().splitlines()[-1]
    assert said.startswith("labrig.errors.BadInputError: day1.h5: ")
    assert 'if __name__ == "__main__":' in said


def test_work_that_is_quickly_done_starts_no_processes(monkeypatch):
    monkeypatch.setattr(curves, "curves_of", lambda job, session: job)
    monkeypatch.setattr(curves, "by_processes", lambda path, jobs, workers: (-job for job in jobs))
    session, jobs = SimpleNamespace(path=None), [1, 2, 3, 4]
    assert list(curves.shared_out(session, jobs, workers=2)) == jobs
    monkeypatch.setattr(curves, "WORTH_PROCESSES_S", -1.0)
    assert list(curves.shared_out(session, jobs, workers=2)) == [1, 2, -3, -4]
    assert list(curves.shared_out(session, jobs, workers=1)) == jobs
