"""One run on the real clock: `python -m benchmarks._real_run punctual|fast FOLDER`.

A process of its own, as `labrig run` is: on a computer that is too busy the output's guard takes
this process for one that hangs, and ends it. FOLDER holds rig.toml and the other files; the session
is FOLDER/session.h5. `punctual` prints how late the loop that only sleeps was, as a JSON object.
"""

from __future__ import annotations

import json
import subprocess
import sys
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from drivers.boards.contract import CURRENT
from labrig.errors import LabrigError
from labrig.experiment.operator import NoOperator
from labrig.experiment.plan import load_plan
from labrig.experiment.rig.rig import Rig
from labrig.experiment.rig.wiring import sheet_drive, wire
from labrig.experiment.run import run_session
from protocols.execution.event_bus import EventBus
from protocols.execution.events import Event, RunStarted
from protocols.execution.stop import StopRequest

FAST_HZ = 100_000.0
_BARE_S = 60.0


class BareLoop:
    """Starts the loop that only sleeps when a run starts, with the same times."""

    def __init__(self) -> None:
        command = [sys.executable, "-m", "benchmarks._bare_loop"]
        pipes: dict[str, Any] = {"stdin": subprocess.PIPE, "stdout": subprocess.PIPE, "text": True}
        self._process = subprocess.Popen(command, **pipes)
        self._edges = self._times = np.empty(0)

    def follow(self, event: Event) -> None:
        """See `protocols.execution.event_bus`."""
        if isinstance(event, RunStarted) and self._process.stdin is not None:
            run = event.run
            self._edges = np.array([event.time_s + step.time_s for step in run.steps])
            samples = [event.time_s + run.time_of(reading) for reading in run.readings]
            self._times = np.sort(np.concatenate([self._edges, samples]))
            self._process.stdin.write(json.dumps(self._times.tolist()) + "\n")
            self._process.stdin.flush()

    def lateness_s(self) -> dict[str, list[float]]:
        """At the edges, and at the sampling points; waits until the loop is over."""
        answer, _ = self._process.communicate(timeout=_BARE_S)
        late = np.array(json.loads(answer))
        at_edge = np.isin(self._times, self._edges)
        return {"edges": late[at_edge].tolist(), "samples": late[~at_edge].tolist()}

    def end(self) -> None:
        """Whatever it is doing; may be called when it has ended."""
        self._process.kill()
        self._process.wait()


def record(folder: Path, bare: BareLoop | None, *, fast: bool) -> str:
    """Run the plan in a folder as `labrig run` does; why it did not come to its end, or nothing."""
    plan = load_plan(*(folder / f"{name}.toml" for name in ("rig", "protocol", "sheet")))
    event_bus = EventBus()
    if bare is not None:
        event_bus.add_best_effort("the bare loop", bare.follow)
    rig = wire(plan, NoOperator(lambda _text: None), event_bus.emit)
    if fast:
        rig = _with_two_fast_channels(rig)
    path = folder / "session.h5"
    result = run_session(rig, plan, path, StopRequest(), event_bus, check_first=not fast)
    return result.status.text if result.code else ""


def _with_two_fast_channels(rig: Rig) -> Rig:
    settings = rig.config.boards.settings()
    inputs = [each for each in rig.config.family.inputs(settings) if each.name != CURRENT]
    fast = replace(settings, sample_rate_hz=FAST_HZ)
    boards = rig.config.family.connect(fast, rig.clock, None)
    signals = boards.signal_input(inputs)
    return replace(rig, boards=boards, output=sheet_drive(rig.config, boards), signals=signals)


def main(mode: str, folder: Path) -> None:
    if mode == "fast":
        why = record(folder, None, fast=True)
    else:
        bare = BareLoop()
        try:
            why = record(folder, bare, fast=False)
            if not why:
                print(json.dumps(bare.lateness_s()))
        finally:
            bare.end()
    if why:
        raise SystemExit(why)


if __name__ == "__main__":
    try:
        main(sys.argv[1], Path(sys.argv[2]))
    except LabrigError as error:
        raise SystemExit(str(error)) from None
