"""Processes that labrig has started end with it, whatever has ended it."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path

import pytest

from tests.end_to_end.real_rig import children
from tests.end_to_end.small_rig import small_rig

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="/proc tells of children"),
]
SERVING = """
import sys, time
from pathlib import Path
from labrig.experiment.rig.networked_rig import served_rig

with served_rig(Path(sys.argv[1]), "long"):
    print("ready", flush=True)
    time.sleep(600)
"""


def until(condition: Callable[[], bool], timeout_s: float = 60.0) -> None:
    """Wait for a condition, on the real clock."""
    end = time.monotonic() + timeout_s
    while not condition():
        assert time.monotonic() < end, "it did not come about in time"
        time.sleep(0.02)  # noqa: TID251 - other processes are being watched


def is_alive(pid: int) -> bool:
    """Whether a process runs; what has ended may still be listed, as a zombie."""
    try:
        state = Path(f"/proc/{pid}/stat").read_text().rpartition(")")[2].split()[0]
    except FileNotFoundError:
        return False
    return state != "Z"


def killed(process: subprocess.Popen[bytes], there: list[int]) -> None:
    """Kill a process; each of its children must end, and is ended if it does not."""
    try:
        process.kill()
        process.wait()
        until(lambda: not any(map(is_alive, there)))
    finally:
        for pid in filter(is_alive, there):
            os.kill(pid, signal.SIGKILL)


def test_the_workers_of_a_killed_analysis_end(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory
) -> None:
    session = tmp_path / "session.h5"
    shutil.copy(small_rig(tmp_path_factory) / "session.h5", session)
    script = (
        "from pathlib import Path\nfrom labrig.analysis import analyze, curves\n"
        "curves.WORTH_PROCESSES_S = 0.0\n"
        f"if __name__ == '__main__':\n    analyze(Path({str(session)!r}), workers=2)\n"
    )
    (tmp_path / "evaluate.py").write_text(script)
    process = subprocess.Popen([sys.executable, str(tmp_path / "evaluate.py")])
    # two workers and the tracker of what they share
    until(lambda: len(children(process.pid)) == 3 or process.poll() is not None)
    assert process.poll() is None
    killed(process, children(process.pid))


def test_the_simulator_of_a_killed_run_ends(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SERVING, str(tmp_path / "world.csv")], stdout=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    killed(process, children(process.pid))
    process.stdout.close()
