"""Calibrations: the load cell."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.screen import print_table, say, warn
from labrig.errors import BadInputError


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    room = typer.Typer(help="Calibrate what measures.", no_args_is_help=True)
    room.command(name="load-cell")(load_cell)
    app.add_typer(room, name="calibrate")


def load_cell(
    rig: Annotated[Path, typer.Argument(help="rig.toml")],
    weight_mN: Annotated[
        list[float], typer.Option("--weight-mN", help="a dead weight; repeat, 0 included")
    ],
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="by default the file rig.toml names")
    ] = None,
    yes: Annotated[bool, typer.Option("--yes", help="take each weight as hung")] = False,
) -> None:
    """Calibrate the load cell with dead weights, one by one, and write load_cell.toml.

    The output stays at 0 V. The calibration that is replaced is kept under its date.
    """
    from labrig.experiment.people import ConsoleOperator, NobodyAsked
    from labrig.experiment.preflight import plan_of
    from labrig.experiment.weighing import weigh, write_calibration
    from labrig.experiment.wiring import wire

    if len(set(weight_mN)) < 2 or len(weight_mN) < 3:
        raise BadInputError(
            "--weight-mN: at least three readings with two different weights are needed, such as "
            "--weight-mN 0 --weight-mN 19.6 --weight-mN 49."
        )
    plan = plan_of(rig)
    operator = NobodyAsked(warn) if yes else ConsoleOperator(warn)
    found = weigh(wire(plan, operator), plan, [load / 1000 for load in weight_mN], warn)
    rows = [
        [f"{1e3 * load:.2f}", f"{1e3 * volt:+.5f}", f"{1e3 * left:+.4f}"]
        for load, volt, left in zip(found.loads_N, found.volts, found.fit.residuals_N, strict=True)
    ]
    print_table("Dead weights", ["weight mN", "reading mV", "off the line mN"], rows)
    made = found.calibration
    say(
        f"sensitivity {made.sensitivity_V_per_N:.6f} ± {made.sensitivity_sigma_V_per_N:.6f} V/N, "
        f"offset {1e6 * made.offset_V:+.2f} ± {1e6 * made.offset_sigma_V:.2f} µV"
    )
    path = output or plan.rig.load_cell.calibration
    write_calibration(made, path)
    say(f"wrote {path}")
