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
    stage: Annotated[
        str, typer.Option("--stage", help="the kind of positioner, such as manual or zaber")
    ] = "manual",
    force_sensor: Annotated[
        str,
        typer.Option(
            "--force-sensor", help="the kind of force sensor, such as load_cell (at the boards)"
        ),
    ] = "load_cell",
    protocol: Annotated[
        str, typer.Option("--protocol", help="the kind of protocol, such as staircase or sine")
    ] = "pulse_train",
) -> None:
    """Write commented configuration files to start from.

    They are rig.toml, sheet.toml, protocol.toml, about.toml and calibrations. `labrig parts boards`
    lists the families of boards, `labrig parts protocols` the kinds of protocol, and so on.
    """
    from labrig.config.templates import write_templates

    written = write_templates(
        folder,
        simulated=simulated,
        board=board,
        camera=camera,
        stage=stage,
        force_sensor=force_sensor,
        protocol=protocol,
    )
    for path in written:
        say(f"wrote {path}")


COMMAND = Command(
    "init",
    init,
    order=20,
    examples=(
        CommandExample(line="labrig init my_rig --simulated"),
        CommandExample(line="labrig init my_labjack --board labjack"),
        CommandExample(line="labrig init my_steps --simulated --protocol staircase"),
        CommandExample(line="labrig init my_lab --camera aravis --board labjack"),
    ),
)
