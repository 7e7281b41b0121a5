"""The process of a job: started ahead, so that it begins as soon as there is an order.

A process that waits has imported what a job needs and holds no device. It ends with its input.
"""

from __future__ import annotations

import json
import os
import subprocess
import sys
import threading
from contextlib import suppress
from pathlib import Path

from labrig.errors import LabrigError
from labrig.panel.job.order import Order
from labrig.panel.job.registry import hidden_folder
from labrig.panel.processes import (
    CAN_STEP_BACK,
    detached,
    module_environment,
    step_back,
    step_forward,
)

LOG = "job.log"  # what the last job printed
WARM_UP_LOG = "job.waiting.log"  # what the process that waits printed
_END_S = 5.0


class JobProcesses:
    """Starts jobs' processes, where possible one that waits already. Any thread may call."""

    def __init__(self, data: Path, rig: Path | None) -> None:
        self._data = data
        self._rig = rig
        self._lock = threading.Lock()
        self._waiting: subprocess.Popen[bytes] | None = None
        self._steps_back = False
        self._closed = False

    def prepare(self, *, beside_a_job: bool = False) -> None:
        """Have a process wait for the next order. Where none can be started `begin` reports it.

        `beside_a_job`: it gets ready when nobody else computes, until it is prepared without that.
        """
        with self._lock, suppress(LabrigError):
            if self._closed or self._rig is None:
                return
            if self._waiting is None or self._waiting.poll() is not None:
                if beside_a_job and not CAN_STEP_BACK:
                    return
                self._waiting, self._steps_back = _started(self._data, self._rig), False
            if beside_a_job and not self._steps_back:
                step_back(self._waiting.pid)
            elif self._steps_back and not beside_a_job:
                step_forward(self._waiting.pid)
            self._steps_back = beside_a_job

    def begin(self, order: Order) -> subprocess.Popen[bytes]:
        """Have a process carry out an order. Raises LabrigError."""
        with self._lock:
            waiting, self._waiting = self._waiting, None
        if waiting is not None:
            if self._steps_back:
                step_forward(waiting.pid)
            with suppress(OSError):  # it has died meanwhile
                _hand_over(waiting, order)
                return waiting
        process = _started(self._data, None)
        try:
            _hand_over(process, order)
        except OSError as error:
            raise _not_started(error) from None
        return process

    def close(self) -> None:
        """End the process that waits; those with an order go on."""
        with self._lock:
            self._closed = True
            waiting, self._waiting = self._waiting, None
        if waiting is not None:
            with suppress(OSError):
                if waiting.stdin is not None:
                    waiting.stdin.close()
                waiting.terminate()  # it may be importing still
            with suppress(subprocess.TimeoutExpired):
                waiting.wait(_END_S)


def _started(data: Path, rig: Path | None) -> subprocess.Popen[bytes]:
    """Start one, in a session of its own: neither Ctrl-C nor the panel's end reaches a job."""
    try:
        with (hidden_folder(data) / WARM_UP_LOG).open("wb") as output:
            process = subprocess.Popen(
                [sys.executable, "-m", "labrig.panel.job"],
                stdin=subprocess.PIPE,
                stdout=output,
                stderr=output,
                env=module_environment(),
                **detached(),
            )
        assert process.stdin is not None  # noqa: S101 - for the type checker
        process.stdin.write(json.dumps(None if rig is None else str(rig)).encode() + b"\n")
        process.stdin.flush()
    except OSError as error:
        raise _not_started(error) from None
    return process


def _hand_over(process: subprocess.Popen[bytes], order: Order) -> None:
    assert process.stdin is not None  # noqa: S101 - for the type checker
    process.stdin.write(order.to_json().encode("utf-8"))
    process.stdin.close()
    if process.poll() is not None:
        raise BrokenPipeError


def _not_started(error: OSError) -> LabrigError:
    return LabrigError(f"a job cannot be started ({error}).")


def print_into_log(data: Path) -> None:
    """In the job's process: let what is printed go into the log of this job alone."""
    flags = os.O_WRONLY | os.O_CREAT | os.O_TRUNC
    with suppress(OSError):  # it stays in the other one
        log = os.open(hidden_folder(data) / LOG, flags, 0o644)
        os.dup2(log, 1)
        os.dup2(log, 2)
        os.close(log)
