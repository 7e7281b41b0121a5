"""Folders that are made once for all workers of a test run."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from pathlib import Path

import pytest

WAIT_S = 0.05


def made_once(factory: pytest.TempPathFactory, name: str, make: Callable[[Path], object]) -> Path:
    """Return a folder that `make` has filled, in this worker or in another; leave it as it is.

    Of several workers the first makes it and the others wait. Where making it failed, or where
    that worker died, the next one tries, so that each test that needs it fails with the reason.
    """
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # each worker has a folder of its own in it
    folder, done, lock = root / name, root / f"{name}.done", root / f"{name}.lock"
    while not done.exists():
        try:
            with lock.open("x") as file:
                file.write(str(os.getpid()))
        except FileExistsError:
            if _is_left(lock):
                lock.unlink(missing_ok=True)
            threading.Event().wait(WAIT_S)
            continue
        try:
            _fill(folder, done, make)
        finally:
            lock.unlink()
    return folder


def _is_left(lock: Path) -> bool:
    """Whether its worker has died: the others would wait until each of their tests times out."""
    try:
        pid = int(lock.read_text() or os.getpid())  # nothing: it is being written
        if os.name == "posix":  # elsewhere to ask would end the process
            os.kill(pid, 0)
    except ProcessLookupError:
        return True
    except (OSError, ValueError):
        pass
    return False


def _fill(folder: Path, done: Path, make: Callable[[Path], object]) -> None:
    if done.exists():  # since it was last asked for
        return
    if folder.exists():
        folder.rename(folder.with_name(f"{folder.name}-failed-{os.getpid()}"))
    make(folder)
    done.touch()
