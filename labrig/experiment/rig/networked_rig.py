"""A simulated rig behind real sockets and serial lines, on the real clock."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from itertools import dropwhile
from pathlib import Path
from typing import Any

from labrig.config import RigConfig
from labrig.errors import NotReadyError
from protocols import Schedule
from protocols.planning.schedule import Purpose

_START_S = 60.0
_END_S = 5.0


# The name under which boards are served; of a family that is not here, its own.
SERVED_BOARDS = {"ni": "grpc"}
# The simulated serial device that answers as a kind of part does. Of a kind that is not here, the
# device has the same name.
SERIAL_DEVICES = {"zaber": "stage", "dpm3": "meter"}
_MOTOR = "zaber"  # moves the load cell where nobody can be asked to


def at_addresses(rig: RigConfig, served: Mapping[str, str]) -> RigConfig:
    """Return the simulated rig with the addresses that `serve` has printed."""
    boards = served[SERVED_BOARDS.get(rig.boards_kind, rig.boards_kind)]
    tables: dict[str, dict[str, Any]] = {rig.boards_kind: {"address": boards}}
    if rig.camera is not None:
        tables["camera"] = {"source": served["camera"]}
    stage = rig.stage.kind if hasattr(rig.stage, "port") else _MOTOR
    for table, kind in (("stage", stage), ("force_sensor", rig.force_sensor.kind)):
        port = served.get(SERIAL_DEVICES.get(kind, kind))
        if port is not None:
            tables[table] = {"kind": kind, "port": port}
    return rig.changed(**tables)


def why_not_served(schedule: Schedule) -> str:
    """Return why a simulated rig cannot run a schedule on the real clock; empty when it can.

    What a simulated operator does by hand nobody does there: the sheet is in another process. It
    begins with the load cell away, so that free shapes and releases come first.
    """
    runs = schedule.runs
    held = list(dropwhile(lambda run: run.purpose is Purpose.FREE_SHAPE, runs))
    by_hand = any(run.purpose is not Purpose.MEASUREMENT or run.mounting for run in held)
    if by_hand or len({run.configuration for run in runs}) > 1:
        return (
            "On the real clock nobody works at a simulated rig, so it measures one configuration "
            "as it is mounted; choose such a protocol (one [[places]], under [extras] no remounts, "
            "dead weights or no_touch_zero), or the virtual clock."
        )
    return ""


@contextmanager
def served_rig(
    record: Path, configuration: str, options: Sequence[str] = ()
) -> Iterator[dict[str, str]]:
    """Start `python -m sim_hardware serve`; yields the addresses that it prints.

    `record` is where the world writes down what happens to it; `options` are further ones of serve.
    """
    command = [sys.executable, "-m", "sim_hardware", "serve", "--port", "0"]
    command += ["--end-with-input"]  # also where this process is killed: a pipe ends with it
    command += ["--configuration", configuration, "--record", str(record)]
    command += options
    process = subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
    try:
        yield _addresses(process)
    finally:
        process.terminate()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
        for pipe in (process.stdin, process.stdout):
            if pipe is not None:
                pipe.close()


def _addresses(process: subprocess.Popen[str]) -> dict[str, str]:
    alarm = threading.Timer(_START_S, process.kill)
    alarm.start()
    found: dict[str, str] = {}
    try:
        for line in process.stdout or ():
            if line.strip() == "ready":
                return found
            name, _, where = line.strip().partition("=")
            found[name] = where
    finally:
        alarm.cancel()
    raise NotReadyError(
        "the simulated rig did not start; run python -m sim_hardware serve to see why."
    )
