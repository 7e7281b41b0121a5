"""The process that computes results, one after the other; it ends with the panel at any moment."""

from __future__ import annotations

import os
import sys
import threading
from contextlib import suppress
from multiprocessing import get_context
from multiprocessing.process import BaseProcess
from pathlib import Path
from typing import Any, Literal

if sys.platform == "win32":
    from multiprocessing.connection import PipeConnection as Connection
else:
    from multiprocessing.connection import Connection

from labrig.errors import BadInputError, LabrigError
from labrig.panel.pages._result_data import fitted_result
from labrig.parent_process import end_with_parent
from model import ModelError

NICE = 10  # a run comes first
STEPS_S = 0.4  # of computing, after which the page is shown what is known
Stage = Literal["fitted", "settling", "whole"]


class ResultProcess:
    """Starts its process when it is first asked, and again after one that has died."""

    def __init__(self) -> None:
        self._turn = threading.Lock()
        self._connection: Connection[Any, Any] | None = None
        self._process: BaseProcess | None = None
        self._closed = False

    def ask(self, stage: Stage, path: Path, name: str, state: str) -> dict[str, Any]:
        """Return a session's result up to a stage. Raises BadInputError with the reason."""
        with self._turn:
            try:
                connection = self._connection or self._start()
                connection.send((stage, path, name, state))
                found, fault = connection.recv()
            except (EOFError, OSError):
                self._connection = None
                raise BadInputError(
                    f"{name}: the process that computes its result has died; try again."
                ) from None
        if fault is not None:
            raise BadInputError(fault)
        result: dict[str, Any] = found
        return result

    def prepare(self) -> None:
        """Start the process, which loads what it needs; where it cannot, who asks is told."""
        if self._turn.acquire(blocking=False):
            try:
                with suppress(EOFError, OSError):
                    self._connection = self._connection or self._start()
            finally:
                self._turn.release()

    def close(self) -> None:
        """End the process; whoever waits for it is refused."""
        self._closed = True
        if self._process is not None:
            self._process.terminate()

    def _start(self) -> Connection[Any, Any]:
        if self._closed:
            raise EOFError
        context = get_context("spawn")
        self._connection, theirs = context.Pipe()
        self._process = context.Process(
            target=_serve, args=(theirs,), daemon=True, name="labrig-results"
        )
        self._process.start()
        theirs.close()
        return self._connection


def _serve(connection: Connection[Any, Any]) -> None:
    end_with_parent()
    if hasattr(os, "nice"):
        os.nice(NICE)
    while True:
        try:
            stage, path, name, state = connection.recv()
        except (EOFError, KeyboardInterrupt):  # the panel has ended
            return
        try:
            connection.send((_computed(stage, path, name, state), None))
        except (LabrigError, ModelError) as error:
            connection.send((None, str(error)))


def _computed(stage: Stage, path: Path, name: str, state: str) -> dict[str, Any]:
    found = fitted_result(path, name, state)
    if stage == "fitted":
        return found.result
    return found.settling(STEPS_S) if stage == "settling" else found.whole()
