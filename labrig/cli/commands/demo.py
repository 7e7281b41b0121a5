"""`labrig demo`: the whole experiment of the paper on the simulated rig, and what comes of it."""

from __future__ import annotations

import re
import time
from pathlib import Path
from typing import Annotated

import typer

from labrig.cli.command import Command, CommandExample
from labrig.cli.commands.analyze import analyze
from labrig.cli.commands.diagnose import diagnose
from labrig.cli.commands.fit import fit
from labrig.cli.commands.report import report
from labrig.cli.screen import print_table, say
from labrig.errors import BadInputError, ExitCode

READINGS = 10  # at 0 V and of each voltage, as in the paper; a test takes fewer
_REAL_CLOCK_PROTOCOL = """\
# Ten seconds of the paper's protocol, for the demo on the real clock.
moisten = false

[pulse_train]
zero_readings = 3
readings_per_voltage = 5

[[places]]
configuration = "long"
positions_mm = [10]

[extras]
mode = "paper"
"""


def demo(
    folder: Annotated[Path, typer.Argument(help="made for it; must not be there")],
    simulated_only: Annotated[
        bool, typer.Option("--simulated-only", help="leave out the ten seconds on the real clock")
    ] = False,
) -> None:
    """Run the paper's whole experiment on a simulated rig.

    It records, analyses, fits, diagnoses and reports.

    Then it runs for ten seconds on the real clock: the same drivers speak TCP and serial to the
    simulated boards, camera and stage in another process. At last it records a sheet that moves,
    identifies mass, losses and electrodes, and draws a pulse with its model.
    """
    from labrig.config.templates import write_templates

    if folder.exists():
        raise BadInputError(f"{folder}: is already there; give another folder, or remove it.")
    began = time.monotonic()
    _heading("1. A simulated rig: rig.toml, sheet.toml, protocol.toml and calibrations")
    write_templates(folder, simulated=True)
    _state_readings(folder / "protocol.toml")
    say(f"wrote {folder}{'/'}")
    session, model = folder / "session.h5", folder / "model.toml"
    _heading("2. The experiment: 2 configurations x 7 positions, on the virtual clock")
    _run(folder / "rig.toml", folder / "protocol.toml", folder / "sheet.toml", session)
    _heading("3. Frames to neutral curves, signals to forces")
    analyze(session)
    _heading("4. Bending stiffness and electrically induced bending moment")
    fit([session], output=model)
    _heading("5. Effects that are not in the model with constant EIBM")
    diagnose([session], output=folder / "model+.toml", report=folder / "diagnosis")
    _heading("6. The report")
    report(session, folder / "report")
    if not simulated_only:
        _heading(
            "7. Ten seconds on the real clock: boards over TCP, camera over HTTP, a serial stage"
        )
        _real_clock(folder / "real-clock")
    _heading(f"{7 if simulated_only else 8}. A sheet that moves: mass, losses, electrodes")
    _moving(folder / "moving")
    say()
    say(f"The demo took {time.monotonic() - began:.0f} s. Open {folder / 'report' / 'index.html'}")


def _heading(text: str) -> None:
    say()
    say(text)
    say("=" * len(text))


def _state_readings(protocol: Path) -> None:
    text = protocol.read_text(encoding="utf-8")
    changed, count = re.subn(
        r"(?m)^(zero_readings|readings_per_voltage) = \d+", rf"\1 = {READINGS}", text
    )
    if count != 2:
        raise ValueError("the template of the protocol states its readings in another way")
    protocol.write_text(changed, encoding="utf-8")


def _run(rig: Path, protocol: Path, sheet: Path, session: Path) -> None:
    from labrig.cli.follow import run_and_follow

    result = run_and_follow(rig, protocol, sheet, session, yes=True)
    say(f"{session}: {result.outcome.value}; output {result.status.output.value}")
    if result.code is not ExitCode.DONE:
        raise typer.Exit(int(result.code))


def _real_clock(folder: Path) -> None:
    from labrig.config.templates import template_text, write_templates
    from labrig.experiment.rig.networked_rig import served_rig
    from labrig.report.tables.overview import overview
    from labrig.session import open_session

    write_templates(folder, simulated=True)
    (folder / "protocol.toml").write_text(_REAL_CLOCK_PROTOCOL, encoding="utf-8")
    record = folder / "world_record.csv"
    with served_rig(record, "long") as addresses:
        text = template_text("rig_simulated.toml")
        text = text.replace('address = "simulated"', f'address = "{addresses["grpc"]}"')
        text = text.replace('source = "simulated"', f'source = "{addresses["camera"]}"')
        if "stage" in addresses:  # pseudo-terminals are there on POSIX only
            stage = f'kind = "zaber"\nport = "{addresses["stage"]}"'
            text = text.replace('kind = "manual"', stage)
        (folder / "rig.toml").write_text(text.split("[simulated]")[0], encoding="utf-8")
        for name, where in addresses.items():
            say(f"{name:8s}{where}")
        session = folder / "session.h5"
        _run(folder / "rig.toml", folder / "protocol.toml", folder / "sheet.toml", session)
    with open_session(session) as opened:
        table = overview(opened).runs_table()
    print_table(table.title, table.columns, table.rows)
    say(f"The world's own record of the last voltage: {_last_voltage(record)} V")


def _moving(folder: Path) -> None:
    from labrig.cli.moving_demo import fit_and_draw, write_moving_rig

    files = write_moving_rig(folder)
    _run(*files, folder / "session.h5")
    fit_and_draw(folder / "session.h5", folder)


def _last_voltage(record: Path) -> str:
    header, *rows = record.read_text(encoding="utf-8").splitlines()
    return rows[-1].split(",")[header.split(",").index("drive_V")]


COMMAND = Command(
    "demo",
    demo,
    order=10,
    examples=(CommandExample(line="labrig demo demo", run_by="make demo"),),
)
