"""The folder in which the examples of the commands are run: made once for each build.

Its commands are those of the first session. Pages that show them show this output.
"""

from __future__ import annotations

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path

DATA = Path(__file__).parents[1] / "tutorials" / "data"
COMMANDS = (
    "labrig init rig --simulated",
    "cp short.toml rig/protocol.toml",
    "labrig plan rig/protocol.toml",
    "labrig check rig/rig.toml",
    "labrig run rig/rig.toml rig/protocol.toml rig/sheet.toml -o session.h5 --yes",
    "labrig analyze session.h5",
    "labrig fit session.h5 -o model.toml",
    "labrig diagnose session.h5 -o model+.toml",
    "labrig report session.h5 -o report",
    "labrig next session.h5 --model model+.toml --between gravity clamp_angle -o next.toml",
)
_PROGRESS = re.compile(r"^[\w -]+: \d+ %")
_PROGRAMS = Path(__file__).parent
_TIMEOUT_S = 180.0


def new_folder() -> Path:
    """Return a new temporary folder with the files of tutorials/data."""
    folder = Path(tempfile.mkdtemp(prefix="labrig-docs-"))
    shutil.copytree(DATA, folder, dirs_exist_ok=True)
    return folder


@cache
def prepared() -> tuple[Path, dict[str, tuple[int, str]]]:
    """Return the folder, and for each of its commands the exit code and the output."""
    folder = new_folder()
    return folder, {command: run(command, folder) for command in COMMANDS}


def remove_prepared() -> None:
    """Remove the folder, if it was made, and end the process that runs commands."""
    if _server.cache_info().currsize:
        server, folder = _server()
        assert server.stdin is not None  # noqa: S101 - it was opened as a pipe
        server.stdin.close()
        server.wait(_TIMEOUT_S)
        shutil.rmtree(folder, ignore_errors=True)
        _server.cache_clear()
    if prepared.cache_info().currsize:
        shutil.rmtree(prepared()[0], ignore_errors=True)
        prepared.cache_clear()


def install(build: Path) -> dict[str, str]:
    """Write what asks the server in place of `labrig` and of a kernel; return its environment."""
    ask = [sys.executable, "-IS", str(_PROGRAMS / "ask_server.py")]
    command = build / "bin" / "labrig"
    kernel = build / "jupyter" / "kernels" / "python3" / "kernel.json"
    for path in (command, kernel):
        path.parent.mkdir(parents=True, exist_ok=True)
    command.write_text(f'#!/bin/sh\nexec {shlex.join(ask)} labrig "$@"\n')
    command.chmod(0o755)
    started = [*ask, "kernel", "-f", "{connection_file}"]
    kernel.write_text(json.dumps({"argv": started, "display_name": "Python", "language": "python"}))
    path = os.pathsep.join([str(command.parent), os.environ["PATH"]])
    return {"PATH": path, "JUPYTER_PATH": str(kernel.parents[2])}


def run(
    command: str, folder: Path, answers: Sequence[str] = (), *, stop: bool = False
) -> tuple[int, str]:
    """Run a line of the shell and return its exit code and output, without progress lines.

    With `stop`, Ctrl-C is pressed a second after its first output.
    """
    start_server()
    with tempfile.TemporaryDirectory() as files:
        typed, printed = Path(files, "typed"), Path(files, "printed")
        typed.write_text("".join(f"{answer}\n" for answer in answers))
        with typed.open() as standard_input, printed.open("w") as output:
            process = subprocess.Popen(
                ["bash", "-c", command],
                cwd=folder,
                stdin=standard_input,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        if stop:
            _wait_for(printed)
            os.kill(process.pid, signal.SIGINT)
        code = process.wait(_TIMEOUT_S)
        text = printed.read_text().replace(f"{folder}/", "")  # where it is says nothing
    kept = [line for line in text.splitlines() if not _PROGRESS.match(line)]
    return code, "\n".join(kept).strip("\n")


def start_server() -> None:
    """Start the process that runs commands and kernels, if it does not run yet."""
    _server()


@cache
def _server() -> tuple[subprocess.Popen[str], Path]:
    folder = Path(tempfile.mkdtemp(prefix="labrig-docs-"))
    os.environ["LABRIG_DOCS_SERVER"] = str(folder / "socket")
    program = [sys.executable, str(_PROGRAMS / "command_server.py"), str(folder / "socket")]
    environment = {name: os.environ[name] for name in os.environ if name != "MPLBACKEND"}
    pipe = subprocess.PIPE
    server = subprocess.Popen(program, env=environment, stdin=pipe, stdout=pipe, text=True)
    assert server.stdout is not None  # noqa: S101 - it was opened as a pipe
    if server.stdout.readline() != "ready\n":
        raise RuntimeError("the process that runs the documentation's commands did not start")
    return server, folder


def _wait_for(printed: Path) -> None:
    ends = time.monotonic() + _TIMEOUT_S
    while not printed.stat().st_size and time.monotonic() < ends:
        time.sleep(0.2)
    time.sleep(1.0)
