"""What happens when STOP is pressed.

The run is asked; who does not obey is ended; who is gone is looked after. Every voltage is written
by the run, by the guard or by `labrig safe`, none here.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import threading
import time
from collections.abc import Callable
from contextlib import suppress
from dataclasses import dataclass
from pathlib import Path

from labrig.panel.job.connection import JobConnection
from labrig.panel.job.registry import GOING, JobAddress, read_address
from labrig.panel.live.packing import BrokenConnectionError, Header
from labrig.panel.processes import module_environment

OBEY_S = 1.0  # as long as the guard gives a run that hangs
DIE_S = 2.0
SAFE_S = 12.0  # `labrig safe`, with all its patience
_POLL_S = 0.2
_TICK_S = 0.005
_UNKNOWN_CODE = 6  # `labrig.errors.ExitCode.OUTPUT_UNKNOWN`
ENERGISED = "energised"
NO_RUN = "no run of this panel is going on"


@dataclass(frozen=True)
class Pressed:
    """What became of it."""

    output: str  # safe | armed | energised | unknown; empty: it was not read
    took_s: float
    told: str

    def as_dict(self) -> Header:
        """For JSON."""
        return {"output": self.output, "took_s": round(self.took_s, 4), "told": self.told}


class StopConnection:
    """A connection to the present job, opened before it is needed.

    `rig` is the panel's rig.toml: where no job of the panel is going on, another program may have
    put a voltage on its output.
    """

    def __init__(self, data: Path, rig: str | None = None) -> None:
        self._data = data
        self._rig = rig
        self._lock = threading.Lock()
        self._connection: JobConnection | None = None
        self._address: JobAddress | None = None
        self._output = "unknown"
        self._changed = threading.Condition()

    def watch(self, ended: threading.Event) -> None:
        """Keep the connection open until `ended`."""
        while not ended.wait(_POLL_S):
            with suppress(OSError):
                self.hold()

    @property
    def going(self) -> bool:
        """Whether there is a job that could be stopped."""
        return self._connection is not None and self._connection.alive

    def hold(self) -> JobAddress | None:
        """Link to the present job if there is one. Raises OSError when it should be but is not."""
        with self._lock:
            if self.going:
                return self._address
            found = read_address(self._data)
            if found is None or found.state != GOING:
                self._address = None
                return None
            self._address, self._output = (
                found,
                "armed",
            )  # a job begins at 0 V, and publishes each change
            self._connection = JobConnection(
                found.port, found.key, "stop", self._on_message, self._on_end
            )
            return found

    def press(self, who: str, why: str) -> Pressed:
        """STOP. Returns when the voltage has gone, or when nothing more can be done about it."""
        began_s = time.monotonic()
        try:
            address = self.hold()
        except OSError:
            return self._read_safe_state(began_s, "the run's process is gone")
        connection = self._connection
        if address is None or connection is None:
            last = read_address(self._data)
            if last is not None and last.code == _UNKNOWN_CODE:
                return self._read_safe_state(began_s, "the last run left its output unknown")
            if self._rig is None:
                return Pressed("", 0.0, f"{NO_RUN}, and it has no rig: nothing was read")
            return self._read_safe_state(began_s, NO_RUN, self._rig)
        asked, refused = threading.Event(), list[str]()
        ask = (connection, who, why, asked, refused)
        threading.Thread(target=_ask, args=ask, daemon=True).start()

        def obeyed() -> bool:
            return (asked.is_set() or not connection.alive) and self._output != ENERGISED

        if self._wait_for(obeyed, OBEY_S):
            return self._pressed(began_s, refused[0] if refused else "the run was stopped")
        if self._output != ENERGISED:
            return self._pressed(began_s, "the run does not answer; its output was not energised")
        if connection.alive:
            with suppress(OSError):  # it has just ended by itself
                os.kill(address.pid, getattr(signal, "SIGKILL", signal.SIGTERM))
            self._wait_for(lambda: not connection.alive, DIE_S)
        return self._read_safe_state(began_s, "the run did not obey and was ended")

    # ------------------------------------------------------------------------------------- helpers

    def _pressed(self, began_s: float, text: str) -> Pressed:
        return Pressed(self._output, time.monotonic() - began_s, text)

    def _read_safe_state(self, began_s: float, text: str, rig: str | None = None) -> Pressed:
        """Free the boards, write 0 V and read it back by `labrig safe`; by default the job's."""
        address = self._address or read_address(self._data)
        self._output = "unknown"
        rig = rig or (address and address.rig) or self._rig
        if rig is None:
            return self._pressed(began_s, f"{text}; switch the amplifier off by hand")
        command = [sys.executable, "-m", "labrig", "safe", rig]
        try:
            done = subprocess.run(
                command,
                capture_output=True,
                timeout=SAFE_S,
                check=False,
                text=True,
                stdin=subprocess.DEVNULL,
                env=module_environment(),
            )
        except (OSError, subprocess.TimeoutExpired) as error:
            failed = f"{text}; labrig safe failed ({error}): switch the amplifier off by hand"
            return self._pressed(began_s, failed)
        self._output = "safe" if done.returncode == 0 else "unknown"
        said = " ".join((done.stdout + done.stderr).split())
        return self._pressed(began_s, f"{text}; labrig safe: {said}")

    def _wait_for(self, condition: Callable[[], bool], limit_s: float) -> bool:
        with self._changed:
            end_s = time.monotonic() + limit_s
            while not condition():
                left_s = end_s - time.monotonic()
                if left_s <= 0:
                    return False
                self._changed.wait(min(left_s, _TICK_S))
            return True

    def _on_message(self, header: Header, _payload: memoryview) -> None:
        messages = header["messages"] if header.get("type") == "story" else [header]
        with self._changed:
            for message in messages:
                if message.get("type") == "output":
                    self._output = str(message["state"])
            self._changed.notify_all()

    def _on_end(self) -> None:
        with self._changed:
            self._changed.notify_all()


def _ask(
    connection: JobConnection, who: str, why: str, asked: threading.Event, refused: list[str]
) -> None:
    with suppress(BrokenConnectionError):
        answer = connection.ask({"do": "stop", "who": who, "why": why})
        refused += [str(answer["error"])] if answer.get("error") else []
        asked.set()
