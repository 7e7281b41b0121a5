"""How fast a whole session runs on the virtual clock, against the time it would take at a rig.

It is the session of the shipped files, 2 configurations x 7 positions. Each repetition is `labrig
run` in a process of its own, from its start to its end: with imports, preflight, pictures, session
file, journal and checksums.
"""

from __future__ import annotations

import json
import statistics
import subprocess
import sys
import tempfile
import time
from dataclasses import asdict, dataclass
from pathlib import Path

from benchmarks.report import Report, Table, busy
from labrig.config.templates import write_templates
from labrig.experiment.plan import load_plan
from labrig.session import open_session

REPEATS = 3
LEAST_RATIO = 10.0
MOST_BYTES = 1e9


@dataclass(frozen=True)
class Cost:
    """Of one session."""

    wall_s: float
    cpu_s: float  # of all threads
    peak_bytes: int | None
    checksum: str  # of all that was recorded


def one_session(folder: Path, number: int) -> Cost:
    """Run the session of the shipped files."""
    output = folder / f"session{number}.h5"
    files = [str(folder / name) for name in ("rig.toml", "protocol.toml", "sheet.toml")]
    command = [sys.executable, "-m", "benchmarks._session", "run", *files, "-o", str(output)]
    began = time.perf_counter()
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    wall_s = time.perf_counter() - began
    cost = json.loads(done.stdout.splitlines()[-1])
    if cost["code"]:
        raise SystemExit(f"the session ended with code {cost['code']}: {done.stderr}")
    with open_session(output) as session:
        checksum = session.checksum
    output.unlink()
    return Cost(wall_s, cost["cpu_s"], cost["peak_bytes"], checksum)


def measure() -> Report:
    others = busy()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        write_templates(folder, simulated=True)
        plan = load_plan(*(folder / f"{file}.toml" for file in ("rig", "protocol", "sheet")))
        runs = plan.schedule.runs
        real_s = sum(run.duration_s for run in runs)
        first, *costs = (one_session(folder, number) for number in range(1 + REPEATS))
    wall_s = statistics.median(cost.wall_s for cost in costs)
    cpu_s = statistics.median(cost.cpu_s for cost in costs)
    peaks = [cost.peak_bytes for cost in costs if cost.peak_bytes is not None]
    same = len({cost.checksum for cost in (first, *costs)}) == 1
    rows = (
        ("at a rig, moves and moistening not counted", f"{real_s:.1f} s", "1"),
        ("labrig run, wall", f"{wall_s:.1f} s", f"{real_s / wall_s:.1f}"),
        ("labrig run, CPU of all threads", f"{cpu_s:.1f} s", f"{real_s / cpu_s:.1f}"),
    )
    memory = f"{max(peaks) / 1e6:.0f} MB" if peaks else "not told by this system"
    reached = "reached" if real_s / wall_s >= LEAST_RATIO else "MISSED"
    walls = ", ".join(f"{cost.wall_s:.1f}" for cost in costs)
    return Report(
        tables=(Table(f"{len(runs)} runs", ("", "time", "times faster than real"), rows),),
        figures={
            "real_s": real_s,
            "wall_ratio": real_s / wall_s,
            "cpu_ratio": real_s / cpu_s,
            "at_least": LEAST_RATIO,
            "peak_bytes": max(peaks, default=None),
            "at_most_bytes": MOST_BYTES,
            "bit_identical": same,
            "first": asdict(first),
            "repetitions": [asdict(cost) for cost in costs],
        },
        notes=(
            f"medians of {REPEATS} (wall {walls} s), after a first one of {first.wall_s:.1f} s",
            f"peak memory {memory}; wanted below {MOST_BYTES / 1e6:.0f} MB",
            f"wanted at least {LEAST_RATIO:g} times faster: {reached}",
            others,
            f"all sessions bit-identical: {'yes' if same else 'NO'}",
        ),
    )
