"""The folder in which the examples of the commands are run: made once for each build.

Its commands are those of the first session. Pages that show them show this output.
"""

from __future__ import annotations

import os
import re
import shutil
import signal
import subprocess
import tempfile
import time
from collections.abc import Sequence
from functools import cache
from pathlib import Path
from typing import IO

DATA = Path(__file__).parents[1] / "tutorials" / "data"
COMMANDS = (
    "labrig init rig --simulated",
    "cp five_positions.toml rig/protocol.toml",
    "labrig plan rig/protocol.toml",
    "labrig check rig/rig.toml",
    "labrig run rig/rig.toml rig/protocol.toml rig/sheet.toml -o session.h5 --yes",
    "labrig analyze session.h5",
    "labrig fit session.h5 -o model.toml",
    "labrig diagnose session.h5 -o model+.toml",
    "labrig report session.h5 -o report",
)
_PROGRESS = re.compile(r"^[\w -]+: \d+ %")
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
    """Remove the folder, if it was made."""
    if prepared.cache_info().currsize:
        shutil.rmtree(prepared()[0], ignore_errors=True)
        prepared.cache_clear()


def run(
    command: str, folder: Path, answers: Sequence[str] = (), *, stop: bool = False
) -> tuple[int, str]:
    """Run a line of the shell and return its exit code and output, without progress lines.

    With `stop`, Ctrl-C is pressed a second after its first output.
    """
    with tempfile.TemporaryFile("w+") as printed, tempfile.TemporaryFile("w+") as typed:
        typed.write("".join(f"{answer}\n" for answer in answers))
        typed.seek(0)
        process = subprocess.Popen(
            ["bash", "-c", command],
            cwd=folder,
            stdin=typed,
            stdout=printed,
            stderr=subprocess.STDOUT,
            start_new_session=True,
        )
        if stop:
            _wait_for_output(process, printed)
            process.send_signal(signal.SIGINT)
        process.wait(_TIMEOUT_S)
        printed.seek(0)
        output = printed.read().replace(f"{folder}/", "")  # where it is says nothing
        kept = [line for line in output.splitlines() if not _PROGRESS.match(line)]
    return process.returncode, "\n".join(kept).strip("\n")


def _wait_for_output(process: subprocess.Popen[bytes], printed: IO[str]) -> None:
    ends = time.monotonic() + _TIMEOUT_S
    while process.poll() is None and time.monotonic() < ends:
        time.sleep(1.0)
        if os.fstat(printed.fileno()).st_size:
            return
