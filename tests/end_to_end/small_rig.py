"""A simulated rig in a folder, and commands on it."""

from __future__ import annotations

from pathlib import Path

import pytest

from labrig.cli.main import run
from labrig.config.templates import write_templates
from tests.made_once import made_once

PROTOCOL = """
[pulse_train]
zero_readings = 3
readings_per_voltage = 3

[[places]]
configuration = "long"
positions_mm = [10, 20]

[[places]]
configuration = "short"
positions_mm = [10, 20]

[extras]
mode = "paper"
"""

TWO_POSITIONS = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 3

[[places]]
configuration = "long"
positions_mm = [5, 15]

[extras]
mode = "paper"
"""

ONE_POSITION = """
[pulse_train]
zero_readings = 2
readings_per_voltage = 1

[[places]]
configuration = "long"
positions_mm = [10]

[extras]
"""
# Of `world.toml`: a fault in the second run; the world's time in which one can be run is about 6 s.
OVERLOADED_IN_THE_SECOND_RUN = """
[[faults]]
what = "cell_overloaded"
since = "first_voltage"
from_s = 5.0
"""


def make_rig(folder: Path, protocol: str = PROTOCOL, world: str = "", board: str = "ni") -> Path:
    """A simulated rig's files in `folder`; `world` is the text of a world.toml of its own."""
    write_templates(folder, simulated=True, board=board)
    (folder / "protocol.toml").write_text(protocol)
    if world:
        (folder / "world.toml").write_text(world)
    return folder


def labrig(*arguments: object) -> int:
    """One command in this process; its exit code."""
    return run([str(argument) for argument in arguments])


def run_rig(folder: Path, name: str = "session.h5") -> Path:
    """Run the rig in `folder`; the session's path."""
    files = [folder / file for file in ("rig.toml", "protocol.toml", "sheet.toml")]
    assert labrig("run", *files, "-o", folder / name) == 0
    return folder / name


def small_rig(factory: pytest.TempPathFactory) -> Path:
    """A rig's folder whose session of two configurations was run, once for all; leave it as is."""
    return made_once(factory, "small-rig", lambda folder: run_rig(make_rig(folder)))


def two_positions(factory: pytest.TempPathFactory) -> Path:
    """A session of one sheet, not analysed, run once for all; copy it before it is changed."""
    make = lambda folder: run_rig(make_rig(folder, TWO_POSITIONS))  # noqa: E731
    return made_once(factory, "two-positions", make) / "session.h5"
