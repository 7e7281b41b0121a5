"""What labrig, Bluesky and PyMeasure add to a reading.

The same reading by labrig's scheduler, Bluesky's RunEngine and PyMeasure's Procedure: write a
voltage, wait until its pulse is over, take the filtered force around the sampling point. The device
is the same, has no hardware, and nothing has to be waited for on it. The time per reading is a
difference of two counts, so start-up does not count. Each framework runs in a process of its own,
the peers in an environment of their own.
"""

from __future__ import annotations

import json
import os
import statistics
import subprocess
import sys
import venv
from pathlib import Path

from benchmarks.report import Report, Table

FEW, MANY = 200, 1000
REPEATS = 5
_HERE = Path(__file__).parent
_VENV = _HERE.parent / ".venv-bench"
_PEERS = _HERE / "peers.txt"

# name -> (what is shown, what it does)
WAYS = {
    "plain": ("no framework", "a Python loop over the device"),
    "labrig": (
        "labrig, Scheduler",
        "3 channels taken every 25 ms while it waits, reading judged, 1 event a look and a reading",
    ),
    "labrig_one_look": ("labrig, 2 looks a pulse", "the same, samples taken every 0.3 s only"),
    "bluesky": (
        "Bluesky, RunEngine",
        "mv and trigger_and_read, documents made and dropped; nothing is done while it waits",
    ),
    "pymeasure_alone": (
        "PyMeasure, Procedure",
        "startup, execute, shutdown; emit drops the result; nothing is done while it waits",
    ),
    "pymeasure_worker": (
        "PyMeasure, Worker",
        "the same in its thread, results written as CSV by another",
    ),
}


def peers_python() -> Path:
    """The interpreter of the peers' environment, which is made when it is missing or outdated."""
    python = _VENV / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    wanted = _PEERS.read_text(encoding="utf-8")
    mark = _VENV / "peers.txt"
    if not mark.exists() or mark.read_text(encoding="utf-8") != wanted:
        venv.create(_VENV, with_pip=True, clear=True)
        pip = [str(python), "-m", "pip", "install", "--quiet", "--disable-pip-version-check"]
        subprocess.run([*pip, "-r", str(_PEERS)], check=True)
        mark.write_text(wanted, encoding="utf-8")
    return python


def per_reading_s(command: list[str]) -> dict[str, float]:
    """Time for one more reading, by name."""

    def seconds(count: int) -> dict[str, float]:
        done = subprocess.run(
            [*command, str(count)], capture_output=True, text=True, check=True, cwd=_HERE.parent
        )
        found: dict[str, float] = json.loads(done.stdout.splitlines()[-1])
        return found

    few, many = seconds(FEW), seconds(MANY)
    return {name: (many[name] - few[name]) / (MANY - FEW) for name in many}


def measure() -> Report:
    commands = (
        [str(peers_python()), str(_HERE / "_overhead_peers.py")],
        [sys.executable, "-m", "benchmarks._overhead_labrig"],
    )
    found: dict[str, list[float]] = {name: [] for name in WAYS}
    for _ in range(REPEATS):
        for command in commands:
            for name, taken_s in per_reading_s(command).items():
                found[name].append(taken_s)
    median_s = {name: statistics.median(values) for name, values in found.items()}
    rows = tuple(
        (shown, f"{median_s[name] * 1e6:.0f} us", _ratio(median_s, name), does)
        for name, (shown, does) in WAYS.items()
    )
    return Report(
        tables=(
            Table(
                "CPU time per reading without hardware, all threads",
                ("", "median", "share of Bluesky's", "what it does"),
                rows,
            ),
        ),
        figures={"median_s": median_s, "all_s": found},
        notes=(
            f"medians of {REPEATS}, each ({MANY} readings - {FEW} readings) / {MANY - FEW}",
            "the sheet's pulse lasts 0.6 s at a rig: all of this is spent while it lasts",
        ),
    )


def _ratio(median_s: dict[str, float], name: str) -> str:
    return f"{median_s[name] / median_s['bluesky']:.3f}"
