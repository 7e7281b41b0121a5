"""A simulated rig behind sockets, and labrig's files for it."""

from __future__ import annotations

import subprocess
import sys
import threading
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from labrig.config.templates import write_templates

_START_S = 60.0
_END_S = 5.0
_RIG = """
[ni]
address = "{grpc}"
[limits]
sheet_voltage_V = 2.5
time_under_voltage_s = 120.0
[load_cell]
calibration = "load_cell.toml"
[camera]
source = "{camera}"
optics = "optics.json"
[stage]
kind = "manual"
"""


@contextmanager
def served(*arguments: str) -> Iterator[dict[str, str]]:
    """`python -m sim_hardware serve` with these arguments; yields the addresses that it prints."""
    command = [sys.executable, "-m", "sim_hardware", "serve", *arguments]
    process = subprocess.Popen(command, stdout=subprocess.PIPE, text=True)
    alarm = threading.Timer(_START_S, process.kill)
    alarm.start()
    found: dict[str, str] = {}
    try:
        for line in process.stdout or ():
            if line.strip() == "ready":
                break
            name, _, where = line.strip().partition("=")
            found[name] = where
        else:
            raise SystemExit("the simulated rig did not start")
        alarm.cancel()
        yield found
    finally:
        alarm.cancel()
        process.terminate()
        try:
            process.wait(_END_S)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()


def write_files(folder: Path, addresses: dict[str, str], protocol: str) -> None:
    """Write the files for a rig at these addresses, with this protocol.toml."""
    write_templates(folder, simulated=True)
    (folder / "rig.toml").write_text(_RIG.format(**addresses), encoding="utf-8")
    (folder / "protocol.toml").write_text(protocol, encoding="utf-8")
