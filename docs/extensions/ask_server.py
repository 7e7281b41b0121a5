"""Asks the command server for a command or a kernel, and is its process for who started it.

Signals are handed on, and the exit code is that of the command. With PYTHONPATH set the command is
started by itself, as the server knows another path. Nothing but the standard library is imported.
"""

from __future__ import annotations

import json
import os
import signal
import socket
import sys
from contextlib import suppress


def main() -> None:
    """Ask for sys.argv[1:] and end as it ends."""
    asked = sys.argv[1:]
    if "PYTHONPATH" in os.environ:
        program = os.path.join(os.path.dirname(sys.executable), asked[0])
        os.execv(program, asked)  # noqa: S606 - no shell is wanted
    environment = dict(os.environ)
    if asked[0] == "kernel":
        environment.pop("MPLBACKEND", None)  # a notebook shows its figures
    message = {"arguments": asked, "folder": os.getcwd(), "environment": environment}
    with socket.socket(socket.AF_UNIX) as server:
        server.connect(os.environ["LABRIG_DOCS_SERVER"])
        socket.send_fds(server, [f"{json.dumps(message)}\n".encode()], [0, 1, 2])
        answers = server.makefile()
        child = int(answers.readline())
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, lambda given, _frame: _hand_on(child, given))
        code = int(answers.readline() or 1)
    os._exit(code)


def _hand_on(child: int, given: int) -> None:
    with suppress(ProcessLookupError):
        os.kill(child, given)


if __name__ == "__main__":
    main()
