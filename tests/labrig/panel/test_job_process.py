"""The process that waits for the next order: ready, without devices, and never left behind."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from labrig.config.templates import write_templates
from labrig.panel.job import Order
from labrig.panel.job.process import LOG, JobProcesses
from labrig.panel.job.registry import read_address
from tests.processes import ended

pytestmark = pytest.mark.slow


@pytest.fixture
def folder(tmp_path):
    write_templates(tmp_path, simulated=True)
    return tmp_path


@pytest.fixture
def processes(folder):
    found = JobProcesses(folder, folder / "rig.toml")
    yield found
    found.close()


def order(folder):
    """A preflight of the shipped simulated rig."""
    files = {name: str(folder / f"{name}.toml") for name in ("rig", "protocol", "sheet")}
    return Order(id="one", kind="preflight", by="Ann", wall="", data=str(folder), **files)


def test_the_process_that_waits_carries_out_the_next_order(processes, folder):
    processes.prepare()
    waiting = processes._waiting
    begun = processes.begin(order(folder))
    assert begun is waiting
    assert begun.wait(60) == 0
    assert read_address(folder).state == "ended"
    assert (folder / ".labrig" / LOG).exists()


@pytest.mark.thorough
def test_a_waiting_process_that_has_died_is_replaced(processes, folder):
    processes.prepare()
    processes._waiting.kill()
    processes._waiting.wait(20)
    begun = processes.begin(order(folder))
    assert begun.wait(60) == 0
    assert read_address(folder).state == "ended"


@pytest.mark.thorough
@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets a process step forward again")
def test_a_process_that_gets_ready_beside_a_run_computes_after_all_others(processes, folder):
    processes.prepare(beside_a_job=True)
    pid = processes._waiting.pid
    threads = [int(one.name) for one in Path(f"/proc/{pid}/task").iterdir()]
    assert {os.sched_getscheduler(one) for one in threads} == {os.SCHED_IDLE}
    begun = processes.begin(order(folder))
    assert begun.pid == pid
    assert os.sched_getscheduler(pid) == os.SCHED_OTHER
    assert begun.wait(60) == 0


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux lets a process step forward again")
def test_a_process_that_got_ready_beside_a_run_hurries_when_the_run_is_over(processes):
    processes.prepare(beside_a_job=True)
    processes.prepare()
    assert os.sched_getscheduler(processes._waiting.pid) == os.SCHED_OTHER


@pytest.mark.thorough
def test_a_rig_that_cannot_be_read_is_reported_by_the_job_and_not_by_the_one_that_waits(folder):
    (folder / "rig.toml").write_text("nonsense = 1\n")
    processes = JobProcesses(folder, folder / "rig.toml")
    processes.prepare()
    assert processes.begin(order(folder)).wait(60) == 2
    assert "nonsense" in read_address(folder).text


def test_nothing_waits_after_the_end(processes):
    processes.prepare()
    waiting = processes._waiting
    processes.close()
    assert waiting.poll() is not None
    processes.prepare()
    assert processes._waiting is None


@pytest.mark.skipif(os.name != "posix", reason="kills by a signal")
def test_the_process_that_waits_ends_with_a_panel_that_is_killed(folder):
    code = (
        "import sys, time\n"
        "from pathlib import Path\n"
        "from labrig.panel.job.process import JobProcesses\n"
        "folder = Path(sys.argv[1])\n"
        "found = JobProcesses(folder, folder / 'rig.toml')\n"
        "found.prepare()\n"
        "print(found._waiting.pid, flush=True)\n"
        "time.sleep(600)\n"
    )
    panel = subprocess.Popen(
        [sys.executable, "-c", code, str(folder)], stdout=subprocess.PIPE, text=True
    )
    pid = int(panel.stdout.readline())
    panel.send_signal(signal.SIGKILL)
    ended(panel)
    panel.stdout.close()
    end_s = time.monotonic() + 60
    while _lives(pid):
        assert time.monotonic() < end_s
        time.sleep(0.1)  # noqa: TID251 - another process is watched


def _lives(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    try:
        with open(f"/proc/{pid}/stat") as file:  # ended, and nobody has asked for its code
            return file.read().rpartition(")")[2].split()[0] != "Z"
    except OSError:
        return True
