"""What labrig does on the real clock over TCP, beside a loop that only sleeps.

Against `python -m sim_hardware serve` on the same computer, guard process and all: three runs of
20 s with a pulse every 0.2 s, each with a reading; then one of a minute in which 2 channels at
100 kS/s and all frames are recorded. The peer is a process that does nothing but sleep until the
same times, in the same run.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._served import served, write_files
from benchmarks.report import Report, Table, busy
from labrig.errors import BadInputError
from labrig.session import RecordedSession, open_session, recover

REPEATS = 3
PULSES = 98
SLOW_PULSES = 96  # a minute
FRAMES_HZ = 25.0

BARE_EDGES, BARE_SAMPLES = "bare loop, at the edges", "bare loop, at the sampling points"

PROTOCOL = """
moisten = false
[pulse_train]
voltages_V = [2.0, -2.0]
zero_readings = 3
pulses_discarded = 0
readings_per_voltage = {each}
pulse_s = {pulse_s}
sample_at_s = {sample_at_s}
half_window_s = 0.04
[[places]]
configuration = "long"
positions_mm = [10]
[camera]
frame_rate_hz = 25.0
keep_all_frames = {every_frame}
[extras]
mode = "paper"
"""


def run(mode: str, folder: Path) -> str:
    """One run in a process of its own; what it prints. SystemExit says why it was broken off."""
    command = [sys.executable, "-m", "benchmarks._real_run", mode, str(folder)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    if done.returncode:
        said = done.stderr.strip().splitlines()
        raise SystemExit(said[-1] if said else f"ended with code {done.returncode}")
    return done.stdout


def punctuality(folder: Path) -> dict[str, np.ndarray]:
    """How late edges and sampling points were, and the loop that only sleeps, s.

    Raises SystemExit when the session did not come to its end.
    """
    protocol = PROTOCOL.format(each=PULSES // 2, pulse_s=0.2, sample_at_s=0.15, every_frame="false")
    with served("--configuration", "long") as addresses:
        write_files(folder, addresses, protocol)
        bare = json.loads(run("punctual", folder).splitlines()[-1])
    with open_session(folder / "session.h5") as session:
        writes, readings = session.runs[0].writes, session.runs[0].readings
    return {
        "edge, request sent": writes["before_s"] - writes["due_s"],
        "edge, confirmed by the board": writes["after_s"] - writes["due_s"],
        "sampling point": readings["time_s"] - readings["planned_s"],
        BARE_EDGES: np.array(bare["edges"]),
        BARE_SAMPLES: np.array(bare["samples"]),
        "valid": readings["valid"],
    }


def lateness() -> tuple[Table, dict[str, Any], list[str]]:
    """Medians of several runs."""
    found: list[dict[str, np.ndarray]] = []
    broken: list[str] = []
    for _ in range(REPEATS):
        with tempfile.TemporaryDirectory() as name:
            try:
                found.append(punctuality(Path(name)))
            except SystemExit as error:
                broken.append(str(error))
    if not found:
        raise SystemExit(f"no run came to its end: {broken}")
    invalid, taken = (
        sum(int(n) for n in counts) for counts in zip(*map(_counts, found), strict=True)
    )
    each = [{k: _figures(v) for k, v in run.items() if k != "valid"} for run in found]
    medians = {
        name: {key: float(np.median([run[name][key] for run in each])) for key in each[0][name]}
        for name in each[0]
    }
    rows = tuple(
        (
            name,
            *(f"{values[key] * 1e3:.3f} ms" for key in ("median_s", "p99_s", "largest_s")),
            f"{values['p99_s'] / medians[_peer(name)]['p99_s']:.1f}",
        )
        for name, values in medians.items()
    )
    title = f"lateness over TCP, {PULSES} edges in 20 s, medians of {len(found)} run(s)"
    columns = ("", "median", "99th percentile", "largest", "99th percentile over bare loop's")
    figures = {"median_of_runs": medians, "runs": each, "invalid": invalid, "readings": taken}
    notes = [f"{invalid} of {taken} readings invalid", *(f"broken off: {why}" for why in broken)]
    return Table(title, columns, rows), figures | {"broken_off": broken}, notes


def _counts(run: dict[str, np.ndarray]) -> tuple[int, int]:
    return int((~run["valid"]).sum()), len(run["valid"])


def _peer(name: str) -> str:
    return BARE_SAMPLES if name in {"sampling point", BARE_SAMPLES} else BARE_EDGES


def throughput(folder: Path) -> tuple[Table, dict[str, Any], list[str]]:
    """Samples and frames of a minute at the board's full rate, and whether any is missing."""
    protocol = PROTOCOL.format(
        each=SLOW_PULSES // 2, pulse_s=0.6, sample_at_s=0.5, every_frame="true"
    )
    boards = ["--device", "PCI6703=PCI-6703", "--device", "PCI6034E=PCI-6034E"]
    with served("--configuration", "long", *boards) as addresses:
        write_files(folder, addresses, protocol)
        try:
            run("fast", folder)
            ended = ""
        except SystemExit as error:
            ended = f"broken off: {error}"
    path = folder / "session.h5"
    if ended and not _is_whole(path):
        recover(path, in_place=True)
    with open_session(path) as session:
        found = _found(session)
    found["megabytes"] = path.stat().st_size / 1e6
    lost = found["nan_samples"] + found["lost_samples"]
    frames_lost = found["frames_dropped"] + found["frames_missing"]
    nothing_lost = not (ended or lost or frames_lost)
    both_kHz = 2 * found["rate_hz"] / 1e3
    rows = (
        ("samples of each channel", f"{found['samples']}"),
        ("samples per second, both channels", f"{both_kHz:.0f} kS/s"),
        ("samples lost", f"{lost}"),
        ("frames recorded", f"{found['frames_recorded']}, {found['frames_hz']:.1f} per second"),
        ("frames lost", f"{frames_lost}"),
        ("session file", f"{found['megabytes']:.0f} MB"),
    )
    title = f"2 channels x 100 kS/s and every frame of 640 x 480, {found['seconds']:.0f} s, TCP"
    note = ended or f"nothing lost: {'yes' if nothing_lost else 'NO'}"
    return Table(title, ("", ""), rows), found | {"nothing_lost": nothing_lost}, [note]


def _is_whole(path: Path) -> bool:
    try:
        open_session(path).close()
    except BadInputError:
        return False
    return True


def _found(session: RecordedSession) -> dict[str, Any]:
    run = session.runs[0]
    time_s = run.frame_column("time")
    counts = run.counts
    span_s = float(np.ptp(time_s)) if len(time_s) > 1 else 0.0
    expected = max(counts.frames_grabbed, 1 + round(span_s * FRAMES_HZ))
    return {
        "rate_hz": run.sample_clock.rate_hz,
        "seconds": run.samples / run.sample_clock.rate_hz,
        "samples": run.samples,
        "nan_samples": int(sum(np.isnan(run.signal_V(name)).sum() for name in run.channels)),
        "lost_samples": counts.lost_samples,
        "frames_grabbed": counts.frames_grabbed,
        "frames_recorded": run.frame_count,
        "frames_dropped": counts.frames_dropped,
        "frames_missing": expected - counts.frames_dropped - run.frame_count,
        "frames_hz": (len(time_s) - 1) / span_s if span_s else 0.0,
    }


def _figures(values: np.ndarray) -> dict[str, float]:
    return {
        "median_s": float(np.median(values)),
        "p99_s": float(np.percentile(values, 99)),
        "largest_s": float(np.max(values)),
    }


def measure() -> Report:
    others = busy()
    late, late_figures, notes = lateness()
    with tempfile.TemporaryDirectory() as name:
        fast, fast_figures, more = throughput(Path(name))
    figures: dict[str, Any] = {"lateness": late_figures, "throughput": fast_figures}
    return Report((late, fast), figures, (*notes, *more, others))
