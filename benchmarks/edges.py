"""Where the edges of a run lie among its samples, when the board's clock is off the computer's.

Sessions of the paper's pulses at one position, recorded through the drivers on simulated boards,
in virtual time. Each edge has the index that the session records for it; the read-back shows at
which sample the voltage really changed. One sample of that is the simulated amplifier's lag.

Run: python -m benchmarks.edges
"""

from __future__ import annotations

import tempfile
from pathlib import Path

import numpy as np

from benchmarks.report import Report, Table
from labrig.cli.main import run
from labrig.config.templates import write_templates
from labrig.session import open_session

PROTOCOL = """
moisten = false
[pulse_train]
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
WORLD = """
board_clock_ppm = {ppm}
[boards]
Dev1 = "{model}"
[wiring]
drive = "Dev1/ao0"
force = "Dev1/ai0"
current = "Dev1/ai1"
readback = "Dev1/ai2"
"""
CASES = (
    ("PCIe-6363", 100.0, True),
    ("PCIe-6363", -100.0, True),
    ("USB-6211", 100.0, True),
    ("PCIe-6363", 100.0, False),
)


def session_of(folder: Path, model: str, ppm: float, *, timed: bool) -> Path:
    """Record one session without a camera."""
    write_templates(folder, simulated=True)
    (folder / "world.toml").write_text(WORLD.format(ppm=ppm, model=model))
    (folder / "protocol.toml").write_text(PROTOCOL)
    rig = (folder / "rig.toml").read_text()
    rig = rig.replace("PCI6703/", "Dev1/").replace("PCI6034E/", "Dev1/")
    camera = rig.index("[camera]")
    rig = rig[:camera] + rig[rig.index("\n[", camera) + 1 :]
    rig = rig.replace("[ni]", f"[ni]\ntimed_output = {str(timed).lower()}", 1)
    (folder / "rig.toml").write_text(rig)
    files = [str(folder / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    if run(["run", *files, "-o", str(folder / "session.h5")]):
        raise SystemExit("the session was not completed")
    return folder / "session.h5"


def off(path: Path) -> tuple[np.ndarray, np.ndarray]:
    """Samples from schedule to recorded index, and from there to the change that is seen."""
    from_schedule, seen = [], []
    with open_session(path) as session:
        (recorded,) = session.runs
        drive_V, rows = recorded.signal_V("drive"), recorded.writes
        rate_hz, before_V = 1000.0, 0.0
        first = float(rows["sample_index"][0]) - float(rows["planned_s"][0]) * rate_hz
        for row in rows:
            sheet_V, index = float(row["sheet_V"]), float(row["sample_index"])
            from_schedule.append(index - first - float(row["planned_s"]) * rate_hz)
            if sheet_V != before_V:
                start = int(index) - 50
                beyond = drive_V[start : start + 100] - (sheet_V + before_V) / 2
                there = np.sign(beyond) == np.sign(sheet_V - before_V)
                seen.append(start + int(np.flatnonzero(there)[0]) - index)
            before_V = sheet_V
    return np.array(from_schedule), np.array(seen)


def measure() -> Report:
    """Record the sessions and compare."""
    rows, figures = [], {}
    for model, ppm, timed in CASES:
        with tempfile.TemporaryDirectory() as folder:
            scheduled, seen = off(session_of(Path(folder) / "rig", model, ppm, timed=timed))
        by = "the board" if timed else "the computer"
        rows.append(
            (
                f"{model}, {ppm:+g} ppm, {by}",
                str(len(seen)),
                f"{np.abs(scheduled).max():.3f}",
                f"{seen.min():.2f} to {seen.max():.2f}",
            )
        )
        figures[rows[-1][0]] = {"edges": len(seen), "seen": [seen.min(), seen.max()]}
    table = Table(
        "Edges of a run of 19.2 s at 1000 samples/s",
        (
            "board, its clock against the computer's, edges by",
            "edges",
            "recorded index less schedule, samples, at most",
            "seen after the recorded index, samples",
        ),
        tuple(rows),
    )
    return Report(tables=(table,), figures=figures)


if __name__ == "__main__":
    print(measure().text())
