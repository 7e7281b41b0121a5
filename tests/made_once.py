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

    Of several workers the first makes it and the others wait. Where making it failed, the next
    worker tries, so that each test that needs it fails with the reason.
    """
    root = factory.getbasetemp()
    if "PYTEST_XDIST_WORKER" in os.environ:
        root = root.parent  # each worker has a folder of its own in it
    folder, done, lock = root / name, root / f"{name}.done", root / f"{name}.lock"
    while not done.exists():
        try:
            lock.touch(exist_ok=False)
        except FileExistsError:
            threading.Event().wait(WAIT_S)
            continue
        try:
            _fill(folder, done, make)
        finally:
            lock.unlink()
    return folder


def _fill(folder: Path, done: Path, make: Callable[[Path], object]) -> None:
    if done.exists():  # since it was last asked for
        return
    if folder.exists():
        folder.rename(folder.with_name(f"{folder.name}-failed-{os.getpid()}"))
    make(folder)
    done.touch()
