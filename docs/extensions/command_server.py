"""Runs labrig's commands in children of one process, which has imported what they need.

A command by itself imports for more than half a second. Here each is a fork of a process that has
done so; else it is the same: its own arguments, folder, input, output and exit code. A line of
standard input is a command, as JSON; the answers are `pid` and then `exit code`, a line each.
"""

from __future__ import annotations

import json
import os
import sys
from importlib import import_module
from typing import Any

# Nothing of gRPC: what it starts does not survive a fork.
_SLOW = (
    "h5py",
    "labrig.cli.app",
    "labrig.cli.main",
    "labrig.config.protocol",
    "labrig.config.rig",
    "labrig.session",
    "matplotlib.figure",
    "model",
    "model.effects.catalogue",
    "numba",
    "numpy",
    "scipy.linalg",
    "scipy.optimize",
    "typer",
)


def main() -> None:
    """Serve until the input ends."""
    for name in _SLOW:
        import_module(name)
    for line in sys.stdin:
        asked = json.loads(line)
        child = os.fork()
        if child == 0:
            _become(asked)
        _answer(child)
        _, status = os.waitpid(child, 0)
        _answer(os.waitstatus_to_exitcode(status))


def _answer(number: int) -> None:
    sys.stdout.write(f"{number}\n")
    sys.stdout.flush()


def _become(asked: dict[str, Any]) -> None:
    """Run a command in this process, and end it."""
    os.setsid()
    os.chdir(asked["folder"])
    os.environ["PWD"] = asked["folder"]
    files = ((asked["typed"], os.O_RDONLY), (asked["printed"], os.O_WRONLY), None)
    for number, file in enumerate(files):
        source = os.open(*file) if file else 1
        os.dup2(source, number)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
    sys.argv = ["labrig", *asked["arguments"]]
    code = 1
    try:
        import_module("labrig.cli.main").main()
    except SystemExit as ended:
        code = int(ended.code or 0)
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)


if __name__ == "__main__":
    main()
