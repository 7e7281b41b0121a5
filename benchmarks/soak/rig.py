"""A served rig, `labrig run` on it, and which processes a run has left behind."""

from __future__ import annotations

import os
import subprocess
import sys
import time
import uuid
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from benchmarks.soak.record import WorldRecord
from labrig.config.templates import template_text, write_templates
from labrig.experiment.rig.networked_rig import served_rig

# Two runs of three seconds: one reading at 0 V, four of pulses, then the stage moves.
_PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 1
pulses_discarded = 2
readings_per_voltage = 1
[[places]]
configuration = "long"
positions_mm = [5, 10]
[extras]
mode = "paper"
"""
LIMIT_V = 2.5
_MARK = "LABRIG_SOAK_RUN"  # an environment variable that only one run's processes have
_LOOK_S = 0.005


class Bench:
    """A simulated rig behind sockets."""

    def __init__(self, folder: Path, addresses: dict[str, str]) -> None:
        self.folder = folder
        self.boards = addresses["grpc"]
        self._addresses = addresses
        write_templates(folder, simulated=True)
        (folder / "protocol.toml").write_text(_PROTOCOL)
        self.rig_file = self._write_rig("rig.toml", self.boards)

    def watch(self) -> WorldRecord:
        """The world's record from now on."""
        return WorldRecord(self.folder / "world.csv")

    def start(self, name: str, boards: str | None = None) -> LabrigRun:
        """`labrig run`, in a process group of its own; `boards`: by this address instead."""
        rig = self.rig_file if boards is None else self._write_rig(f"{name}.toml", boards)
        return LabrigRun(self.folder, rig, name)

    def _write_rig(self, name: str, boards: str) -> Path:
        text = template_text("rig_simulated.toml").split("[simulated]")[0]
        text = text.replace('address = "simulated"', f'address = "{boards}"')
        text = text.replace('source = "simulated"', f'source = "{self._addresses["camera"]}"')
        stage = f'kind = "zaber"\nport = "{self._addresses["stage"]}"'
        path = self.folder / name
        path.write_text(text.replace('kind = "manual"', stage))
        return path


@contextmanager
def serving(folder: Path) -> Iterator[Bench]:
    """Serve a rig from `folder` until the block ends."""
    folder.mkdir()
    with served_rig(folder / "world.csv", "long") as addresses:
        yield Bench(folder, addresses)


class LabrigRun:
    """One `labrig run`, and all processes that come of it."""

    def __init__(self, folder: Path, rig: Path, name: str) -> None:
        self.session = folder / f"{name}.h5"
        self._said = folder / f"{name}.txt"
        self._mark = uuid.uuid4().hex
        files = [str(rig), str(folder / "protocol.toml"), str(folder / "sheet.toml")]
        command = [sys.executable, "-m", "labrig", "run", *files, "-o", str(self.session), "--yes"]
        root = str(Path(__file__).resolve().parents[2])
        with self._said.open("wb") as said:
            self.process = subprocess.Popen(
                command,
                cwd=root,
                stdout=said,
                stderr=said,
                env={**os.environ, _MARK: self._mark},
                start_new_session=True,
            )

    @property
    def said(self) -> str:
        """What it and its guard have printed."""
        return self._said.read_text(errors="replace")

    @property
    def has_ended(self) -> bool:
        """Whether the program is over."""
        return self.process.poll() is not None

    def left_behind(self) -> list[int]:
        """Numbers of the processes of this run that still live, other than the program."""
        mark = f"{_MARK}={self._mark}".encode()
        found = []
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit() or int(entry.name) == self.process.pid:
                continue
            try:
                if mark in (entry / "environ").read_bytes().split(b"\0"):
                    found.append(int(entry.name))
            except OSError:  # it has just ended, or is another user's
                continue
        return found


def until(condition: Callable[[], bool], patience_s: float) -> bool:
    """Wait, on the real clock, for a condition; whether it came about."""
    end_s = time.perf_counter() + patience_s
    while not condition():
        if time.perf_counter() > end_s:
            return False
        time.sleep(_LOOK_S)  # noqa: TID251 - another process is being watched
    return True
