"""The preflight."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

import typer

from labrig.check import failures
from labrig.cli.command import Command, CommandExample
from labrig.cli.options import AboutFile, Json, RigFile
from labrig.cli.screen import print_json, print_table, warn
from labrig.errors import NotReadyError


def check(
    rig: RigFile,
    protocol: Annotated[
        Path | None, typer.Option(help="protocol.toml; by default the one beside rig.toml")
    ] = None,
    sheet: Annotated[
        Path | None, typer.Option(help="sheet.toml; by default the one beside rig.toml")
    ] = None,
    about: AboutFile = None,
    as_json: Json = False,
) -> None:
    """Check the rig: devices, calibrations, quiet, output at 0 V.

    Nothing but 0 V is written. Ends with code 3 when a check fails.
    """
    from labrig.experiment.preflight import check_rig

    checks = check_rig(rig, protocol, sheet, about)
    good = all(item.ok for item in checks)
    if as_json:
        print_json({"ok": good, "checks": [item.as_dict() for item in checks]})
    else:
        rows = [[c.word, c.name, c.found if c.is_short else "see below", c.wanted] for c in checks]
        print_table(f"Preflight of {rig}", ["", "check", "found", "wanted"], rows)
        for item in checks:
            if item.ok and not item.is_short:
                warn(f"{item.name}: {item.found}.")
    if not good:
        raise NotReadyError(f"{rig} is not ready: {failures(checks)}.")


COMMAND = Command(
    "check",
    check,
    order=40,
    examples=(CommandExample(line="labrig check rig/rig.toml"),),
)
