"""Before the rig is touched: init, plan, check, config."""

from __future__ import annotations

import json
from pathlib import Path
from typing import Annotated, Any

import typer

from labrig.cli.screen import print_json, print_table, say
from labrig.errors import BadInputError, NotReadyError
from labrig.files import write_text


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    app.command()(init)
    app.command()(plan)
    app.command()(check)
    config = typer.Typer(help="The configuration files.", no_args_is_help=True)
    config.command()(schema)
    app.add_typer(config, name="config")


def init(
    folder: Annotated[Path, typer.Argument(help="made when it is not there")],
    simulated: Annotated[
        bool, typer.Option("--simulated", help="a rig that needs no hardware")
    ] = False,
) -> None:
    """Write commented rig.toml, sheet.toml, protocol.toml and calibrations to start from."""
    from labrig.config.templates import write_templates

    for path in write_templates(folder, simulated=simulated):
        say(f"wrote {path}")


def plan(
    protocol: Annotated[Path, typer.Argument(help="protocol.toml")],
    picture: Annotated[
        Path | None, typer.Option(help="draw one run's voltages and readings (png, svg, pdf)")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Show the schedule: times, voltages, readings, total duration, time under voltage."""
    from labrig.config import load_protocol
    from labrig.report.tables.schedule import overview_rows, run_rows
    from protocols import describe, schedule_to_dict

    schedule = load_protocol(protocol).schedule(str(protocol))
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
    say(
        f"{len(schedule.runs)} runs: {found.running_s:.1f} s, {found.under_voltage_s:.1f} s of it "
        f"under voltage; about {found.estimate_s / 60:.0f} min with what is done between them."
    )
    if picture is not None:
        say(f"wrote {picture}")


def check(
    rig: Annotated[Path, typer.Argument(help="rig.toml")],
    protocol: Annotated[
        Path | None, typer.Option(help="protocol.toml; by default the one beside rig.toml")
    ] = None,
    sheet: Annotated[
        Path | None, typer.Option(help="sheet.toml; by default the one beside rig.toml")
    ] = None,
    as_json: Annotated[bool, typer.Option("--json", help="print one JSON object")] = False,
) -> None:
    """Preflight: everything that rig.toml names is there, quiet, calibrated and at 0 V.

    Nothing but 0 V is written. Ends with code 3 when a check fails.
    """
    from labrig.experiment.preflight import check_rig

    checks = check_rig(rig, protocol, sheet)
    good = all(item.ok for item in checks)
    if as_json:
        print_json({"ok": good, "checks": [item.as_dict() for item in checks]})
    else:
        rows = [[c.word, c.name, _short(c.found), c.wanted] for c in checks]
        print_table(f"Preflight of {rig}", ["", "check", "found", "wanted"], rows)
    if not good:
        failed = "; ".join(f"{c.name}: {c.found}" for c in checks if not c.ok)
        raise NotReadyError(f"{rig} is not ready: {failed}.")


def _short(text: str) -> str:
    """What fits into a table; a long fault stands below it, too, and there in full."""
    return text if len(text) < 70 else "see below"


def schema(
    folder: Annotated[Path, typer.Argument(help="where to write the *.schema.json files")],
) -> None:
    """Write the JSON Schemas of the configuration files, for editors and forms."""
    from labrig.config.schema import schemas

    if folder.exists() and not folder.is_dir():
        raise BadInputError(f"{folder}: this is a file, a folder is needed.")
    folder.mkdir(parents=True, exist_ok=True)
    for name, content in schemas().items():
        path = folder / f"{name}.schema.json"
        write_text(path, _as_text(content))
        say(f"wrote {path}")


def _as_text(content: dict[str, Any]) -> str:
    return json.dumps(content, indent=2, sort_keys=True) + "\n"
