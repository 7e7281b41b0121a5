"""The panel's side of an analysis process: start it, hear it, slow it down, end it."""

from __future__ import annotations

import json
import queue
import shutil
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path
from typing import Any

from labrig.errors import LabrigError
from labrig.panel.analysis.order import AnalysisOrder
from labrig.panel.analysis.outputs import discard_unfinished
from labrig.panel.processes import (
    end_with_children,
    in_background,
    lower_priority,
    module_environment,
    step_back,
    step_forward,
)

Message = dict[str, Any]


class AnalysisProcess:
    """One process with one order. `hidden` is the panel's own folder in the data folder."""

    def __init__(self, order: AnalysisOrder, hidden: Path) -> None:
        """Start it. Raises LabrigError when the system does not."""
        self._session = Path(order.session)
        self._process, self._folder = _spawn(order, hidden)
        self._messages: queue.Queue[Message | None] = queue.Queue()
        self._code: int | None = None
        self._ending = threading.Lock()
        self.is_low = False
        threading.Thread(target=self._read, name="panel-analysis-reader", daemon=True).start()

    @property
    def pid(self) -> int:
        """The process, which is also its group."""
        return self._process.pid

    def message(self, timeout_s: float) -> Message | None:
        """Return the next message. Raises queue.Empty after `timeout_s`; None: it has ended."""
        return self._messages.get(timeout=timeout_s)

    def say(self, word: str) -> None:
        """Send one line to it."""
        assert self._process.stdin is not None  # noqa: S101 - for the type checker
        with suppress(OSError):  # it has ended; its reader reports that
            self._process.stdin.write(f"{word}\n".encode())
            self._process.stdin.flush()

    def lower(self) -> None:
        """Give it and its children the low priority, for good."""
        self.is_low = True
        lower_priority(self.pid)

    def step_back(self) -> None:
        """Let it compute only when nobody else does (Linux)."""
        step_back(self.pid)

    def step_forward(self) -> None:
        """Let it compute as any other again."""
        step_forward(self.pid)

    def end(self) -> int:
        """End it with all its children, remove what is unfinished, and return its exit code.

        May be called again, and by several threads.
        """
        with self._ending:
            if self._code is None:
                self._code = self._end()
            return self._code

    def _end(self) -> int:
        # Also when it has ended by itself: children of a process that crashed would stay.
        end_with_children(self.pid)
        code = self._process.wait()
        for stream in (self._process.stdin, self._process.stdout):
            if stream is not None:
                with suppress(OSError):
                    stream.close()
        discard_unfinished(self._session, self.pid)
        shutil.rmtree(self._folder, ignore_errors=True)
        return code

    def _read(self) -> None:
        assert self._process.stdout is not None  # noqa: S101 - for the type checker
        with suppress(OSError, ValueError):  # closed, or a line that is none of ours
            for line in self._process.stdout:
                self._messages.put(json.loads(line))
        self._messages.put(None)


def _spawn(order: AnalysisOrder, hidden: Path) -> tuple[subprocess.Popen[bytes], Path]:
    """Start the process in a session of its own, with a folder for what it writes in between."""
    folder = hidden / f"{order.kind}-files"
    try:
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir()
        places = {name: str(folder) for name in ("TMPDIR", "TEMP", "TMP")}
        with (hidden / _LOGS.get(order.kind, "analysis.log")).open("wb") as log:
            process = subprocess.Popen(
                [sys.executable, "-m", "labrig.panel.analysis"],
                stdin=subprocess.PIPE,
                stdout=subprocess.PIPE,
                stderr=log,
                env={**module_environment(), **places},
                **in_background(),
            )
        assert process.stdin is not None  # noqa: S101 - for the type checker
        with suppress(BrokenPipeError):  # it has ended already, which its reader reports
            process.stdin.write(order.to_json().encode("utf-8"))
            process.stdin.flush()
    except OSError as error:
        raise LabrigError(f"an analysis cannot be started ({error}).") from None
    return process, folder


_LOGS = {"live": "live_fit.log"}
