"""A served rig with `labrig watch` beside its boards, and a network to both that can be cut."""

from __future__ import annotations

import os
import re
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import IO

from labrig.experiment.rig.networked_rig import SERVED_BOARDS
from tests.end_to_end.real_rig import ServedRig, children, serving
from tests.end_to_end.relay import Relay

_ANY_PORT = ("--listen", "127.0.0.1:0")


class WatchedRig:
    """`rig` is the operator's side; its boards and its watch are behind a network."""

    def __init__(self, rig: ServedRig, board: str) -> None:
        self.rig = rig
        file = rig.folder / "rig" / "rig.toml"
        at_boards = rig.folder / "at_boards"
        at_boards.mkdir()
        (at_boards / "rig.toml").write_text(file.read_text())
        boards = rig.addresses[SERVED_BOARDS.get(board, board)]
        self.watch = subprocess.Popen(
            [sys.executable, "-m", "labrig", "watch", str(at_boards / "rig.toml"), *_ANY_PORT],
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            text=True,
        )
        self.said: list[str] = []
        port = int(self.hear(r"listening on 127\.0\.0\.1:(\d+)"))
        self.networks = [Relay(int(boards.rpartition(":")[2])), Relay(port)]
        self.token = at_boards / "watch.token"
        text = file.read_text().replace(boards, f"127.0.0.1:{self.networks[0].port}")
        address = f"127.0.0.1:{self.networks[1].port}"
        file.write_text(f'{text}[watch]\naddress = "{address}"\ntoken = "{self.token}"\n')

    def hear(self, pattern: str) -> str:
        """The next thing that the watch says of this kind."""
        out: IO[str] | None = self.watch.stdout
        assert out is not None
        for line in out:
            self.said.append(line)
            found = re.search(pattern, line)
            if found:
                return found[1] if found.groups() else found[0]
        raise AssertionError("".join(self.said))

    def cut(self) -> None:
        """Pull the cable of the operator's computer."""
        for network in self.networks:
            network.cut()

    def mend(self) -> None:
        """Plug in a new cable: what was connected stays dead."""
        for network in self.networks:
            network.mend()

    def zeroed_after(self, what: str, before: Callable[[], object] = lambda: None) -> float:
        """Energise, let that happen to the operator's computer; seconds until 0 V.

        `before` is called right before it happens.
        """
        rig = self.rig
        process = rig.energised()
        rig.until(rig.is_energised)
        everything = (*children(process.pid), process.pid)
        before()
        begin_s = float(rig.rows()[-1]["time_s"])
        if what == "network gone":
            self.cut()
        else:
            number = signal.SIGKILL if what == "killed" else signal.SIGSTOP
            for pid in everything:
                os.kill(pid, number)
        rig.until(lambda: not rig.is_energised(), 5.0)
        zero_s = float(rig.rows()[-1]["time_s"])
        for pid in everything:
            with_kill(pid)
        process.wait(10)
        return zero_s - begin_s

    def end(self) -> None:
        """End what was started."""
        self.watch.terminate()
        self.watch.wait(10)
        if self.watch.stdout is not None:
            self.watch.stdout.close()
        for network in self.networks:
            network.stop()


def with_kill(pid: int) -> None:
    """End a process that may have ended."""
    try:
        os.kill(pid, signal.SIGKILL)
    except ProcessLookupError:
        return


@contextmanager
def watched(folder: Path, *options: str, board: str = "ni", more: str = "") -> Iterator[WatchedRig]:
    """Serve a rig, with a watch beside its boards."""
    with serving(folder, *options, board=board, more=more) as rig:
        made = WatchedRig(rig, board)
        try:
            yield made
        finally:
            made.end()
