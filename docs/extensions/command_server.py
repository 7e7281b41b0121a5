"""Runs labrig's commands and the kernels of notebooks in children of one process.

A command by itself imports for more than half a second, a kernel for two. Here each is a fork of a
process that has imported and loaded what they need. Else it is the same: its own arguments, folder,
environment, input, output and exit code. `ask_server.py` is the other side of the socket.
"""

from __future__ import annotations

import gc
import json
import os
import select
import signal
import socket
import sys
from importlib import import_module
from typing import Any

# Nothing of gRPC or ZeroMQ is started here: it does not survive a fork.
_SLOW = (
    "IPython.core.completer",
    "cv2",
    "h5py",
    "ipykernel.kernelapp",
    "jinja2",
    "labrig.analysis",
    "labrig.api.design",
    "labrig.api.next_measurement",
    "labrig.cli.app",
    "labrig.cli.main",
    "labrig.config.protocol",
    "labrig.config.rig",
    "labrig.model_file",
    "labrig.report.page.write",
    "labrig.session",
    "labrig.vision",
    "matplotlib.backends.backend_agg",
    "matplotlib.backends.backend_svg",
    "matplotlib.pyplot",
    "model.dynamics",
    "model.effects.catalogue",
    "model.identification.fit",
    "pandas",
    "scipy.interpolate",
    "scipy.linalg",
    "scipy.optimize",
)


def main() -> None:
    """Serve until standard input ends."""
    del sys.path[0]  # the folder of this file
    for name in _SLOW:
        import_module(name)
    _load_compiled()
    gc.freeze()  # a child need not look through what is here already
    with socket.socket(socket.AF_UNIX) as listener:
        listener.bind(sys.argv[1])
        listener.listen()
        sys.stdout.write("ready\n")
        sys.stdout.flush()
        while listener in select.select([listener, sys.stdin], (), ())[0]:
            asked, _ = listener.accept()
            if os.fork() == 0:
                listener.close()
                _attend(asked)
            asked.close()
            _reap(os.WNOHANG)
    _reap()


def _reap(options: int = 0) -> None:
    """Wait for children, so that their time is counted."""
    try:
        while os.waitpid(-1, options)[0]:
            pass
    except ChildProcessError:
        pass


def _load_compiled() -> None:
    """Load compiled code with the smallest question to a sheet."""
    labrig = import_module("labrig")
    sheet = labrig.sheet(
        free_length_mm=50, width_mm=11, thickness_mm=0.2, B_Nm2=1e-6, EIBM_Nm={1.0: 1e-5}
    )
    labrig.predict(sheet, "sheet", [0.0, 0.01], [0.0, 1.0])


def _attend(asked: socket.socket) -> None:
    """Run what a connection asks for in a child, send its exit code, and end this process.

    The child is killed when the other side is gone.
    """
    message, files, _, _ = socket.recv_fds(asked, 1 << 16, 3)
    while not message.endswith(b"\n"):
        message += asked.recv(1 << 16)
    child = os.fork()
    if child == 0:
        asked.close()
        _become(json.loads(message), files)
    asked.sendall(f"{child}\n".encode())
    for file in files:
        os.close(file)
    ended, status = os.waitpid(child, os.WNOHANG)
    while not ended:
        if select.select([asked], (), (), 0.02)[0]:
            os.kill(child, signal.SIGKILL)
            os._exit(1)
        ended, status = os.waitpid(child, os.WNOHANG)
    code = os.waitstatus_to_exitcode(status)
    asked.sendall(f"{code if code >= 0 else 128 - code}\n".encode())
    os._exit(0)


def _become(asked: dict[str, Any], files: list[int]) -> None:
    """Run a command or a kernel in this process, and end it."""
    os.setsid()
    os.environ.clear()
    os.environ.update(asked["environment"])
    os.chdir(asked["folder"])
    for number, file in enumerate(files):
        os.dup2(file, number)
        os.close(file)
    sys.stdin = open(0, encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stdout = open(1, "w", encoding="utf-8", closefd=False)  # noqa: SIM115
    sys.stderr = open(2, "w", encoding="utf-8", closefd=False, buffering=1)  # noqa: SIM115
    name, *arguments = asked["arguments"]
    sys.argv = [name, *arguments]
    code = 1
    try:
        if name == "kernel":
            sys.path.insert(0, "")
            ends_with = f"--IPKernelApp.parent_handle={os.getppid()}"
            import_module("ipykernel.kernelapp").launch_new_instance([*arguments, ends_with])
            code = 0
        else:
            import_module("labrig.cli.main").main()
    except SystemExit as ended:
        code = int(ended.code or 0)
    finally:
        for stream in (sys.stdout, sys.stderr):
            stream.flush()
        os._exit(code)


if __name__ == "__main__":
    main()
