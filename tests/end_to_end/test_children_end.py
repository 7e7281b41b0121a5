"""Processes that labrig has started end with it, whatever has ended it."""

from __future__ import annotations

import os
import shutil
import signal
import subprocess
import sys
import time
import uuid
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

import pytest

from labrig.config.templates import write_templates
from labrig.panel.processes import step_forward
from sim_hardware.serve import LINGER_S
from tests.cases import few
from tests.end_to_end.real_rig import PROTOCOL, children
from tests.end_to_end.small_rig import small_rig
from tests.labrig.panel.page import Page, Server, jobs_of, start
from tests.processes import ended

pytestmark = [
    pytest.mark.slow,
    pytest.mark.skipif(sys.platform != "linux", reason="/proc tells of children"),
]
GONE_S = 60.0  # beyond that: what still loads is slow while other tests compute
FAMILY = "LABRIG_TEST_FAMILY"  # in the environment of all that descend from a process
RUNNING = """
import sys
from pathlib import Path
from labrig.cli.main import run
from sim_hardware.serve import LINGER_S
from tests.end_to_end.real_rig import serving

with serving(Path(sys.argv[1])) as rig:
    files = [str(rig.folder / "rig" / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    raise SystemExit(run(["run", *files, "-o", str(rig.folder / "session.h5"), "--yes"]))
"""
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
        ended(process)
        until(lambda: not any(map(is_alive, there)))
    finally:
        for pid in filter(is_alive, there):
            os.kill(pid, signal.SIGKILL)


ENDS = [  # what happens to a program with workers, one after the other
    "program is killed",
    "everybody is interrupted",  # Ctrl-C at a terminal
    *(
        pytest.param(order, marks=pytest.mark.thorough)
        for order in (
            "program is interrupted",
            "program is terminated",
            "worker is killed, program is killed",
            "worker hangs, program is killed",
            "program hangs, program is killed",
        )
    ),
]
SIGNALS = {
    "killed": signal.SIGKILL, "terminated": signal.SIGTERM, "interrupted": signal.SIGINT,
    "hangs": signal.SIGSTOP,
}  # fmt: skip


def nothing_left_after(order: str, command: list[str], folder: Path) -> str:
    """Start a program with two workers as a shell does, end it; what it said on its errors."""
    name = uuid.uuid4().hex
    with (folder / "said.txt").open("wb") as said:
        process = subprocess.Popen(
            [sys.executable, *command], cwd=Path(__file__).parents[2], stderr=said,
            env={**os.environ, FAMILY: name, "PYTHONPATH": "."}, process_group=0,
        )  # fmt: skip
        try:
            until(lambda: len(workers_in(name)) == 2 or process.poll() is not None)
            assert process.poll() is None
            for step in order.split(", "):
                who, what = step.split()[0], SIGNALS[step.split()[-1]]
                if who == "everybody":
                    os.killpg(process.pid, what)
                else:
                    os.kill(process.pid if who == "program" else workers_in(name)[0], what)
            process.wait(60)
            all_gone(name)
        finally:
            for pid in family(name):
                os.kill(pid, signal.SIGKILL)
            ended(process)
    return (folder / "said.txt").read_text()


def workers_in(name: str) -> list[int]:
    return [pid for pid, line in family(name).items() if "spawn_main" in line]


@pytest.mark.thorough
@pytest.mark.parametrize("order", [pytest.param(ENDS[0], marks=pytest.mark.thorough), *ENDS[1:]])
def test_nothing_is_left_of_a_diagnosis_however_it_ends(
    tmp_path: Path, tmp_path_factory: pytest.TempPathFactory, order: str
) -> None:
    """It analyses a session first, and processes of its own look for the curves."""
    session = tmp_path / "session.h5"
    shutil.copy(small_rig(tmp_path_factory) / "session.h5", session)
    script = (
        "from labrig.analysis import curves\nfrom labrig.cli.main import run\n"
        "from labrig.report.data import findings\n"
        "curves.WORTH_PROCESSES_S, findings.workers = 0.0, lambda: 2\n"
        f"if __name__ == '__main__':\n    raise SystemExit(run(['diagnose', {str(session)!r}]))\n"
    )
    (tmp_path / "diagnose.py").write_text(script)
    said = nothing_left_after(order, [str(tmp_path / "diagnose.py")], tmp_path)
    assert tracebacks(said, order) == 0


@pytest.mark.parametrize("order", few(ENDS))
def test_nothing_is_left_of_a_batch_however_it_ends(tmp_path: Path, order: str) -> None:
    for session in ("a.h5", "b.h5"):
        (tmp_path / session).write_bytes(session.encode())  # the task does not look into them
    said = nothing_left_after(
        order, ["-m", "tests.labrig.batch.a_batch", str(tmp_path), "10000"], tmp_path
    )
    assert tracebacks(said, order) <= ("interrupted" in order)  # a_batch is no command


def tracebacks(said: str, order: str) -> int:
    """How many there are, without Python's own: of a worker that starts as its parent is killed."""
    own = said.count("reduction.pickle.load(from_parent)") if "program is killed" in order else 0
    return said.count("Traceback") - own


@pytest.mark.thorough
def test_the_simulator_of_a_killed_run_ends(tmp_path: Path) -> None:
    process = subprocess.Popen(
        [sys.executable, "-c", SERVING, str(tmp_path / "world.csv")], stdout=subprocess.PIPE
    )
    assert process.stdout is not None
    assert process.stdout.readline() == b"ready\n"
    killed(process, children(process.pid))
    process.stdout.close()


def family(name: str) -> dict[int, str]:
    """Processes that run with a name in their environment, with what they were started as."""
    found = {}
    for folder in Path("/proc").iterdir():
        with suppress(OSError):
            if folder.name.isdigit() and name.encode() in (folder / "environ").read_bytes():
                found[int(folder.name)] = (folder / "cmdline").read_bytes().decode()
    return {pid: line for pid, line in found.items() if is_alive(pid)}


def all_gone(name: str) -> None:
    """Wait until no process has a name in its environment any more; say which one stays.

    What waits for a job loads only when nobody else computes, and other tests do.
    """
    for pid in family(name):
        step_forward(pid)
    with suppress(AssertionError):
        until(lambda: not family(name), LINGER_S + GONE_S)
    assert family(name) == {}


def is_energised(record: Path) -> bool:
    """Whether the world has written down a voltage."""
    rows = record.read_text().splitlines() if record.exists() else []
    if len(rows) < 3:
        return False
    row = dict(zip(rows[0].split(","), rows[-2].split(","), strict=True))
    return abs(float(row["drive_V"])) > 1.0


@pytest.mark.parametrize(
    "order",
    [
        "program",
        *(pytest.param(one, marks=pytest.mark.thorough)
          for one in ("guard", "hanging program", "guard, program")),
    ],
)  # fmt: skip
def test_nothing_is_left_of_a_run_with_its_simulator_whoever_is_killed(
    tmp_path: Path, order: str
) -> None:
    name = uuid.uuid4().hex
    process = subprocess.Popen(
        [sys.executable, "-c", RUNNING, str(tmp_path)], cwd=Path(__file__).parents[2],
        env={**os.environ, FAMILY: name},
    )  # fmt: skip
    try:
        until(lambda: is_energised(tmp_path / "world.csv") or process.poll() is not None)
        assert process.poll() is None
        there = family(name)
        (guard,) = (pid for pid, line in there.items() if "drivers.guard" in line)
        assert any("sim_hardware" in line for line in there.values())
        if order == "hanging program":
            os.kill(process.pid, signal.SIGSTOP)  # the guard acts, and ends
            until(lambda: not is_alive(guard))
        if order.startswith("guard"):
            os.kill(guard, signal.SIGKILL)
        if order.endswith("program"):
            process.kill()
        process.wait(60)
        all_gone(name)
    finally:
        for pid in family(name):
            os.kill(pid, signal.SIGKILL)
        ended(process)


@pytest.mark.parametrize(
    "job_first",
    [True, pytest.param(False, marks=pytest.mark.thorough)],
    ids=["job first", "panel first"],
)
def test_nothing_is_left_of_a_panel_that_is_killed_with_its_run(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, *, job_first: bool
) -> None:
    name = uuid.uuid4().hex
    monkeypatch.setenv(FAMILY, name)
    write_templates(tmp_path / "rig", simulated=True)
    (tmp_path / "rig" / "one.toml").write_text(
        PROTOCOL.replace("moisten = false", "moisten = true")
    )
    served = Server(tmp_path / "rig" / "rig.toml")
    try:
        page = Page(served)
        page.take_control()
        start(page, "killed.h5", "one.toml")
        page.until("reading")
        (job,) = jobs_of(tmp_path / "rig")
        there = family(name)
        assert any("drivers.guard" in line for line in there.values())
        for pid in (job, served.process.pid) if job_first else (served.process.pid, job):
            os.kill(pid, signal.SIGKILL)
        served.end()
        all_gone(name)
    finally:
        for pid in family(name):
            os.kill(pid, signal.SIGKILL)
        served.end()
