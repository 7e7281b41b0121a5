"""The schedule of a protocol."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.options import Json
from labrig.cli.screen import print_json, print_table, say, warn
from labrig.errors import BadInputError

if TYPE_CHECKING:
    from model import SheetGeometry
    from protocols import Schedule


def plan(
    protocol: Annotated[Path, typer.Argument(help="protocol.toml")],
    picture: Annotated[
        Path | None, typer.Option(help="draw one run's voltages and readings (png, svg, pdf)")
    ] = None,
    as_json: Json = False,
) -> None:
    """Show the schedule: times, voltages, readings, durations.

    It states how long the sheet rests before free shapes. It warns where a dynamic fit ([extras]
    release, [analysis] dynamic) could not determine a parameter, of implausible positions on the
    arc of the sheet.toml beside it, and of what the limits of the rig.toml beside it refuse.
    """
    from labrig.experiment.next_measurement.dynamic_needs import not_determined
    from labrig.plausibility import SetUp, set_up_checks
    from labrig.report.tables.schedule import overview_rows, run_rows
    from labrig.session.tables.drive_table import load_protocol
    from protocols import describe, free_shapes_in_words, schedule_to_dict

    config = load_protocol(protocol)
    schedule = config.schedule(str(protocol))
    if picture is not None:
        from labrig.report.figures.schedule import draw_schedule

        draw_schedule(schedule, picture)
    if as_json:
        print_json(schedule_to_dict(schedule))
        return
    found = describe(schedule)
    print_table(
        f"One {schedule.protocol} run", ["", "time s", "volts", "reading at s"], run_rows(schedule)
    )
    columns = [
        "run",
        "starts",
        "configuration",
        "at mm",
        "first",
        "readings",
        "lasts s",
        "under V s",
    ]
    print_table("All runs", columns, overview_rows(found))
    runs = "1 run" if len(schedule.runs) == 1 else f"{len(schedule.runs)} runs"
    say(
        f"{runs}: {found.running_s:.1f} s, {found.under_voltage_s:.1f} s of it under voltage; "
        f"about {found.estimate_s / 60:.0f} min with what is done between them."
    )
    shapes = free_shapes_in_words(schedule)
    if shapes:
        say(f"Free shapes: {shapes}.")
    for text in not_determined(config, schedule):
        warn(f"{text}.")
    for check in set_up_checks(SetUp(schedule=schedule, sheets=_sheets_beside(protocol))):
        warn(f"warning: {check.in_words}")
    refused = _refused_beside(protocol, schedule)
    if refused:
        warn(f"warning: rig.toml beside it: {refused}; labrig run will refuse this.")
    if picture is not None:
        say(f"wrote {picture}")


def _sheets_beside(protocol: Path) -> dict[str, SheetGeometry] | None:
    """Return the sheets of the sheet.toml beside protocol.toml, if there is a good one."""
    from labrig.config import load_sheet

    try:
        return load_sheet(protocol.with_name("sheet.toml"))
    except BadInputError:
        return None


def _refused_beside(protocol: Path, schedule: Schedule) -> str:
    """Return what is beyond the limits of the rig.toml beside protocol.toml; empty: nothing is."""
    from labrig.config import load_rig
    from labrig.config.rig import RigConfig
    from protocols import SafetyLimits, ScheduleError, check_schedule

    try:
        rig = load_rig(protocol.with_name("rig.toml"))
    except BadInputError:
        return ""
    if not isinstance(rig, RigConfig):
        return ""  # a replay sets no voltage
    limits = rig.limits
    try:
        check_schedule(schedule, SafetyLimits(limits.sheet_voltage_V, limits.time_under_voltage_s))
    except ScheduleError as error:
        return str(error)
    return ""


COMMAND = Command(
    "plan",
    plan,
    order=30,
    examples=(CommandExample(line="labrig plan rig/protocol.toml"),),
)
