"""Files to start from."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.screen import say


def init(
    folder: Annotated[Path, typer.Argument(help="made when it is not there")],
    simulated: Annotated[
        bool, typer.Option("--simulated", help="a rig that needs no hardware")
    ] = False,
    board: Annotated[
        str, typer.Option("--board", help="the family of boards, such as ni or labjack")
    ] = "ni",
    camera: Annotated[
        str, typer.Option("--camera", help="the kind of camera, such as opencv, aravis or gentl")
    ] = "opencv",
) -> None:
    """Write commented configuration files to start from.

    They are rig.toml, sheet.toml, protocol.toml, about.toml and calibrations.
    """
    from labrig.config.templates import write_templates

    for path in write_templates(folder, simulated=simulated, board=board, camera=camera):
        say(f"wrote {path}")


COMMAND = Command(
    "init",
    init,
    order=20,
    examples=(
        CommandExample(line="labrig init my_rig --simulated"),
        CommandExample(line="labrig init my_labjack --board labjack"),
        CommandExample(line="labrig init my_lab --camera aravis --board labjack"),
    ),
)
