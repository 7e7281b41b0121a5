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
from typing import Protocol

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
_PLAIN = re.compile(r"labrig [^|&;<>$`\\\n]*")  # nothing that needs a shell
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
        server = _server()
        assert server.stdin is not None  # noqa: S101 - it was opened as a pipe
        server.stdin.close()
        server.wait(_TIMEOUT_S)
        _server.cache_clear()
    if prepared.cache_info().currsize:
        shutil.rmtree(prepared()[0], ignore_errors=True)
        prepared.cache_clear()


def run(
    command: str, folder: Path, answers: Sequence[str] = (), *, stop: bool = False
) -> tuple[int, str]:
    """Run a line of the shell and return its exit code and output, without progress lines.

    With `stop`, Ctrl-C is pressed a second after its first output.
    """
    with tempfile.TemporaryDirectory() as files:
        typed, printed = Path(files, "typed"), Path(files, "printed")
        typed.write_text("".join(f"{answer}\n" for answer in answers))
        printed.touch()
        if _PLAIN.fullmatch(command):
            process: _Process = _Forked(command, folder, typed, printed)
        else:
            process = _Shell(command, folder, typed, printed)
        if stop:
            _wait_for(printed)
            os.kill(process.pid, signal.SIGINT)
        code = process.wait()
        output = printed.read_text().replace(f"{folder}/", "")  # where it is says nothing
    kept = [line for line in output.splitlines() if not _PROGRESS.match(line)]
    return code, "\n".join(kept).strip("\n")


class _Process(Protocol):
    """A command that is running."""

    pid: int

    def wait(self) -> int:
        """Return the exit code when it has ended."""


class _Shell:
    def __init__(self, command: str, folder: Path, typed: Path, printed: Path) -> None:
        with typed.open() as standard_input, printed.open("w") as output:
            self._process = subprocess.Popen(
                ["bash", "-c", command],
                cwd=folder,
                stdin=standard_input,
                stdout=output,
                stderr=subprocess.STDOUT,
                start_new_session=True,
            )
        self.pid = self._process.pid

    def wait(self) -> int:
        return self._process.wait(_TIMEOUT_S)


class _Forked:
    """A command of labrig alone, in a child of the process that has imported what it needs."""

    def __init__(self, command: str, folder: Path, typed: Path, printed: Path) -> None:
        asked = {
            "arguments": shlex.split(command)[1:],
            "folder": str(folder),
            "typed": str(typed),
            "printed": str(printed),
        }
        server = _server()
        assert server.stdin is not None  # noqa: S101 - it was opened as a pipe
        server.stdin.write(f"{json.dumps(asked)}\n")
        server.stdin.flush()
        self.pid = self._answer()

    def wait(self) -> int:
        return self._answer()

    def _answer(self) -> int:
        output = _server().stdout
        assert output is not None  # noqa: S101 - it was opened as a pipe
        return int(output.readline())


@cache
def _server() -> subprocess.Popen[str]:
    program = Path(__file__).with_name("command_server.py")
    pipe = subprocess.PIPE
    return subprocess.Popen([sys.executable, str(program)], stdin=pipe, stdout=pipe, text=True)


def _wait_for(printed: Path) -> None:
    ends = time.monotonic() + _TIMEOUT_S
    while not printed.stat().st_size and time.monotonic() < ends:
        time.sleep(0.2)
    time.sleep(1.0)
