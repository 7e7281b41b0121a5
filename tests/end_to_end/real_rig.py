"""A simulated rig served over sockets and serial lines, and `labrig run` as a process on it."""

from __future__ import annotations

import csv
import os
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

from labrig.config.templates import write_templates
from labrig.experiment.rig.networked_rig import SERVED_BOARDS, served_rig
from tests.labrig.panel.page import TOO_BUSY, TRIES

PROTOCOL = """
moisten = false
[pulse_train]
zero_readings = 1
readings_per_voltage = 6
[[places]]
configuration = "long"
positions_mm = [10]
[extras]
mode = "paper"
"""
# For what need not be energised for long: each second takes a second of the processor.
SHORT = PROTOCOL.replace("readings_per_voltage = 6", "readings_per_voltage = 1")
Row = dict[str, str]


class ServedRig:
    """Its folder, its files, and the world's own record of what happened. Serves many runs."""

    def __init__(self, folder: Path, addresses: dict[str, str], board: str = "ni") -> None:
        self.folder = folder
        self.addresses = addresses
        write_templates(folder / "rig", simulated=True, board=board)
        text = (folder / "rig" / "rig.toml").read_text()
        boards = addresses[SERVED_BOARDS.get(board, board)]
        text = text.replace('address = "simulated"', f'address = "{boards}"')
        text = text.replace('source = "simulated"', f'source = "{addresses["camera"]}"')
        text = text.replace('"manual"', f'"zaber"\nport = "{addresses["stage"]}"')
        (folder / "rig" / "rig.toml").write_text(text.split("[simulated]")[0])
        (folder / "rig" / "protocol.toml").write_text(PROTOCOL)
        self.session = folder / "rig" / "session.h5"  # of the last run
        self._record = folder / "world.csv"
        self._began = 0  # where the last run begins in the record
        self._started: list[subprocess.Popen[bytes]] = []
        self.options: list[str] = []  # more of the command's

    def be_short(self, protocol: str = SHORT) -> None:
        """Of the runs from now on."""
        (self.folder / "rig" / "protocol.toml").write_text(protocol)

    def start(self) -> subprocess.Popen[bytes]:
        """`labrig run`, in a process group of its own; what it says goes into `said`."""
        self.forget()
        self.session = self.folder / "rig" / f"session-{len(self._started)}.h5"
        names = ("rig.toml", "protocol.toml", "sheet.toml")
        files = [str(self.folder / "rig" / name) for name in names]
        command = [sys.executable, "-m", "labrig", "run", *files, "-o", str(self.session), "--yes"]
        command += self.options
        with (self.folder / "said.txt").open("wb") as said:
            process = subprocess.Popen(
                command, stdout=said, stderr=said, start_new_session=os.name == "posix"
            )
        self._started.append(process)
        return process

    def forget(self) -> None:
        """Of the world's record, what has been written until now."""
        self._began = self._record.read_bytes().rfind(b"\n") + 1

    def energised(self) -> subprocess.Popen[bytes]:
        """`labrig run`, once there is a voltage on the sheet; started again where it was refused
        because a busy computer's camera cannot keep up."""
        for _ in range(TRIES):
            process = self.start()
            self.until(lambda: process.poll() is not None or self._has_voltage())  # noqa: B023
            if process.poll() is None:
                return process
            assert TOO_BUSY in self.said(), self.said()
        raise AssertionError(self.said())

    def completed(self) -> Path:
        """The session of a run that was completed, started again for the same reason."""
        for _ in range(TRIES):
            if self.start().wait(60) == 0:
                return self.session
            assert TOO_BUSY in self.said(), self.said()
        raise AssertionError(self.said())

    def end(self) -> None:
        """Leave none of them to the tests that follow, whatever a test has found."""
        for process in self._started:
            if process.poll() is None:
                process.kill()
                process.wait(10)

    def said(self) -> str:
        """What `labrig run` has printed."""
        return (self.folder / "said.txt").read_text()

    def rows(self) -> list[Row]:
        """The world's record since `forget`; a line that is being written is left out."""
        with self._record.open("rb") as file:
            header = file.readline()
            file.seek(max(self._began, len(header)))
            new = file.read()
        whole = (header + new[: new.rfind(b"\n") + 1]).decode()
        return list(csv.DictReader(whole.splitlines()))

    def drive_V(self) -> float:
        """The sheet's voltage as the world has it."""
        self.until(lambda: bool(self.rows()))
        return float(self.rows()[-1]["drive_V"])

    def until(self, condition: Callable[[], bool], timeout_s: float = 60.0) -> None:
        """Wait for a condition, on the real clock."""
        end = time.monotonic() + timeout_s
        while not condition():
            assert time.monotonic() < end, "it did not come about in time"
            time.sleep(0.01)  # noqa: TID251 - another process is being watched

    def _has_voltage(self) -> bool:
        rows = self.rows()
        return bool(rows) and abs(float(rows[-1]["drive_V"])) > 1.0

    def is_energised(self) -> bool:
        """Whether there is a voltage on the sheet."""
        return abs(self.drive_V()) > 1.0


@contextmanager
def serving(
    folder: Path, *options: str, world: str = "", more: str = "", board: str = "ni"
) -> Iterator[ServedRig]:
    """Serve a rig until the block ends; `more` is added to its rig.toml."""
    if world:
        (folder / "faulty.toml").write_text(world)
        options = (*options, "--world", str(folder / "faulty.toml"))
    options = (*options, "--boards", board)
    with served_rig(folder / "world.csv", "long", options) as addresses:
        rig = ServedRig(folder, addresses, board)
        with (folder / "rig" / "rig.toml").open("a") as file:
            file.write(more)
        try:
            yield rig
        except BaseException:
            rig.end()  # else a test may go on with them when nobody serves any more
            raise


def children(pid: int) -> list[int]:
    """Processes that a process has started (Linux)."""
    return [int(text) for text in Path(f"/proc/{pid}/task/{pid}/children").read_text().split()]
