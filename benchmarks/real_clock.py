"""What labrig does on the real clock over TCP, beside a loop that only sleeps.

Two runs of a minute each, against `python -m sim_hardware serve` on the same computer: pulses every
0.2 s, each with a reading; then 2 channels at 100 kS/s and all frames, recorded.
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from benchmarks._served import plan_for, served
from benchmarks.report import Report, Table
from drivers.ni_input import InputChannel, NiSignalInput
from labrig.experiment.people import NobodyAsked
from labrig.experiment.plan import Plan
from labrig.experiment.rig import Rig
from labrig.experiment.run import run_session
from labrig.experiment.wiring import wire
from labrig.session import Session, open_session
from protocols.events import Event, RunStarted
from protocols.hub import EventHub
from protocols.stop import StopRequest

PULSES = 290
FAST_HZ = 100_000.0
SLOW_PULSES = 48

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


class BareLoop:
    """Starts the loop that only sleeps when a run starts, with the same times."""

    def __init__(self) -> None:
        command = [sys.executable, "-m", "benchmarks._bare_loop"]
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._process = subprocess.Popen(command, **pipes)
        self._edges = self._times = np.empty(0)

    def follow(self, event: Event) -> None:
        """See `protocols.hub`."""
        if isinstance(event, RunStarted) and self._process.stdin is not None:
            run = event.run
            self._edges = np.array([event.time_s + step.time_s for step in run.steps])
            samples = [event.time_s + run.time_of(reading) for reading in run.readings]
            self._times = np.sort(np.concatenate([self._edges, samples]))
            self._process.stdin.write(json.dumps(self._times.tolist()) + "\n")
            self._process.stdin.flush()

    def lateness_s(self) -> tuple[np.ndarray, np.ndarray]:
        """At the edges, and at the sampling points."""
        answer, _ = self._process.communicate(timeout=30.0)
        late = np.array(json.loads(answer))
        at_edge = np.isin(self._times, self._edges)
        return late[at_edge], late[~at_edge]


def record(plan: Plan, path: Path, bare: BareLoop | None, *, fast: bool = False) -> None:
    """Run a plan as `labrig run` does, the guard process and all."""
    hub = EventHub()
    if bare is not None:
        hub.add_watcher("the bare loop", bare.follow)
    rig = wire(plan, NobodyAsked(lambda _text: None), hub.emit)
    if fast:
        rig = _with_two_fast_channels(rig)
    result = run_session(rig, plan, path, StopRequest(), hub, look_first=not fast)
    if result.code:
        raise SystemExit(f"the session did not come to its end: {result.status.text}")


def _with_two_fast_channels(rig: Rig) -> Rig:
    ni = rig.config.ni
    wired = (
        ("force", ni.force, ni.ranges_V.force),
        ("drive", ni.drive_readback, ni.ranges_V.drive),
    )
    channels = [InputChannel(name, where, volts, "differential") for name, where, volts in wired]
    signals = NiSignalInput(rig.connection, rig.clock, channels, FAST_HZ, ni.task_names.input)
    return replace(rig, signals=signals)


def punctuality(folder: Path) -> tuple[Table, dict[str, Any], list[str]]:
    """Lateness of edges and sampling points, and of the loop that only sleeps."""
    protocol = PROTOCOL.format(each=PULSES // 2, pulse_s=0.2, sample_at_s=0.15, every_frame="false")
    with served("--configuration", "long") as addresses:
        plan = plan_for(folder, addresses, protocol)
        bare = BareLoop()
        record(plan, folder / "punctual.h5", bare)
        bare_edges_s, bare_samples_s = bare.lateness_s()
    with open_session(folder / "punctual.h5") as session:
        run = session.runs[0]
        writes, readings = run.writes, run.readings
        invalid = [str(row["why"]) for row in readings if not row["valid"]]
    late = {
        "edge, request sent": writes["before_s"] - writes["due_s"],
        "edge, confirmed by the board": writes["after_s"] - writes["due_s"],
        "sampling point": readings["time_s"] - readings["planned_s"],
        "bare loop, at the edges": bare_edges_s,
        "bare loop, at the sampling points": bare_samples_s,
    }
    rows = [(name, *_row(values)) for name, values in late.items()]
    figures = {name: _figures(values) for name, values in late.items()}
    title = f"lateness over {run.planned.duration_s:.0f} s, {len(writes)} edges, TCP, real clock"
    columns = ("", "median", "99th percentile", "largest", "median over bare loop's")
    base = float(np.median(bare_edges_s)), float(np.median(bare_samples_s))
    bases = (base[0], base[0], base[1], base[0], base[1])
    ratios = [
        f"{float(np.median(values)) / over:.1f}"
        for values, over in zip(late.values(), bases, strict=True)
    ]
    table = Table(title, columns, tuple((*r, q) for r, q in zip(rows, ratios, strict=True)))
    figures["readings"] = len(readings)
    figures["invalid"] = invalid
    return table, figures, [f"{len(invalid)} of {len(readings)} readings invalid", *set(invalid)]


def throughput(folder: Path) -> tuple[Table, dict[str, Any], list[str]]:
    """Samples and frames of a minute at the board's full rate, and whether any is missing."""
    protocol = PROTOCOL.format(each=SLOW_PULSES, pulse_s=0.6, sample_at_s=0.5, every_frame="true")
    boards = ["--device", "PCI6703=PCI-6703", "--device", "PCI6034E=PCI-6034E"]
    with served("--configuration", "long", *boards) as addresses:
        plan = plan_for(folder, addresses, protocol)
        try:
            record(plan, folder / "fast.h5", None, fast=True)
            ended = ""
        except SystemExit as error:
            ended = str(error)
    with open_session(folder / "fast.h5") as session:
        found = _found(session)
    found["megabytes"] = (folder / "fast.h5").stat().st_size / 1e6
    nothing_lost = not (
        ended or found["nan_samples"] or found["lost_samples"] or found["frames_dropped"]
        or found["frames_recorded"] < found["frames_grabbed"]
    )  # fmt: skip
    rows = (
        ("samples of each channel", f"{found['samples']}"),
        ("samples per second, both channels", f"{2 * found['rate_hz'] / 1e3:.0f} kS/s"),
        ("samples lost", f"{found['lost_samples'] + found['nan_samples']}"),
        ("frames grabbed, recorded, dropped", "{frames_grabbed}, {frames_recorded}, "
         "{frames_dropped}".format(**found)),
        ("frames per second recorded", f"{found['frames_hz']:.1f}"),
        ("session file", f"{found['megabytes']:.0f} MB"),
    )  # fmt: skip
    title = f"2 channels x 100 kS/s and every frame of 640 x 480, {found['seconds']:.0f} s, TCP"
    note = ended or f"nothing lost: {'yes' if nothing_lost else 'NO'}"
    return Table(title, ("", ""), rows), found | {"nothing_lost": nothing_lost}, [note]


def _found(session: Session) -> dict[str, Any]:
    run = session.runs[0]
    time_s = run.frame_column("time")
    counts = run.counts
    return {
        "rate_hz": run.sample_clock.rate_hz,
        "seconds": run.samples / run.sample_clock.rate_hz,
        "samples": run.samples,
        "nan_samples": int(sum(np.isnan(run.signal_V(name)).sum() for name in run.channels)),
        "lost_samples": counts.lost_samples,
        "frames_grabbed": counts.frames_grabbed,
        "frames_recorded": run.frame_count,
        "frames_dropped": counts.frames_dropped,
        "frames_hz": float((len(time_s) - 1) / np.ptp(time_s)) if len(time_s) > 1 else 0.0,
    }


def _row(values: np.ndarray) -> tuple[str, ...]:
    found = _figures(values)
    return tuple(f"{found[key] * 1e3:.3f} ms" for key in ("median_s", "p99_s", "largest_s"))


def _figures(values: np.ndarray) -> dict[str, float]:
    return {
        "median_s": float(np.median(values)),
        "p99_s": float(np.percentile(values, 99)),
        "largest_s": float(np.max(values)),
    }


def measure() -> Report:
    with tempfile.TemporaryDirectory() as name:
        lateness, late, notes = punctuality(Path(name))
    with tempfile.TemporaryDirectory() as name:
        speed, fast, more = throughput(Path(name))
    figures: dict[str, Any] = {"lateness": late, "throughput": fast}
    return Report((lateness, speed), figures, (*notes, *more))
