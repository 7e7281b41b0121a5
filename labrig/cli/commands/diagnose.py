"""What the model is missing: diagnose, next, effects."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from labrig.cli.screen import print_json, print_table, progress, say, warn
from labrig.errors import BadInputError, LabrigError
from labrig.files import write_text

if TYPE_CHECKING:
    from labrig.report.parts.table import Table
    from model import Measurements, SheetModel
    from model.discrepancy import DiagnoseOptions, Diagnosis

Sessions = Annotated[
    list[Path] | None,
    typer.Argument(help="a session; further ones of the same sheet are taken together with it"),
]
Json = Annotated[bool, typer.Option("--json", help="print one JSON object")]
Sheet = Annotated[
    Path | None, typer.Option(help="sheet.toml, with CSV tables instead of a session")
]
Forces = Annotated[Path | None, typer.Option(help="forces.csv")]
Curves = Annotated[Path | None, typer.Option(help="curves.csv")]
Signals = Annotated[Path | None, typer.Option(help="signals.csv")]
Known = Annotated[
    Path | None, typer.Option("--model", help="a model file, whose effects are taken as known")
]
Symmetric = Annotated[
    bool, typer.Option("--symmetric", help="one |EIBM| for both polarities: asymmetry is a finding")
]


def add_to(app: typer.Typer) -> None:
    """Add these commands."""
    app.command()(diagnose)
    app.command(name="next")(next_measurement)
    effects = typer.Typer(
        help="The catalogue of effects that diagnose knows.", invoke_without_command=True
    )
    effects.callback()(list_effects)
    effects.command(name="show")(show_effect)
    app.add_typer(effects, name="effects")


def diagnose(
    sessions: Sessions = None,
    sheet: Sheet = None,
    forces: Forces = None,
    curves: Curves = None,
    signals: Signals = None,
    model: Known = None,
    output: Annotated[
        Path | None,
        typer.Option("--output", "-o", help="the model file to write, with what was found (TOML)"),
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite the model file")] = False,
    report: Annotated[
        Path | None, typer.Option("--report", help="a folder for the page and its figures")
    ] = None,
    hold_out: Annotated[
        list[str] | None,
        typer.Option(
            metavar="[configuration=NAME,]position=MM", help="leave a position out; repeatable"
        ),
    ] = None,
    symmetric: Symmetric = False,
    without: Annotated[
        list[str] | None,
        typer.Option(metavar="EFFECT", help="an effect that is known not to be there; repeatable"),
    ] = None,
    calibrate: Annotated[
        int, typer.Option(min=0, max=10_000, help="sessions to simulate for the threshold; 0: none")
    ] = 0,
    as_json: Json = False,
) -> None:  # fmt: skip
    """Say where simulation and measurement disagree, and which effect the model is missing.

    What is found is kept in the (first) session; labrig report shows it, too.
    """
    from labrig.analysis.holding_out import held_out
    from labrig.experiment.next_protocol import with_protocol
    from model.discrepancy import DiagnoseOptions
    from model.effects import effect

    if output is not None and output.exists() and not force:
        raise BadInputError(f"{output}: is already there; give --force to overwrite it.")
    for name in without or ():
        effect(name)  # at once: what follows may take minutes
    measurements = _measured(sessions, sheet, forces, curves, signals)
    options = DiagnoseOptions(
        symmetric=symmetric, calibrate=calibrate, model=_model(model), exclude=tuple(without or ()),
        hold_out=held_out(hold_out or [], measurements),
    )  # fmt: skip
    found = diagnosed(measurements, options)
    found = with_protocol(found, measurements, sessions[0] if sessions else None)
    if sessions:
        keep(sessions[0], found)
    written = []
    if output is not None:
        from labrig.model_file import save_model

        save_model(found.model, output)
        written.append(output)
    if report is not None:
        from labrig.report.diagnosis.page import write_diagnosis

        written.append(write_diagnosis(found, report))
    if as_json:
        print_json(found.to_json())
        return
    print_diagnosis(found)
    for path in written:
        say(f"wrote {path}")


def diagnosed(measurements: Measurements, options: DiagnoseOptions) -> Diagnosis:
    """Diagnose with a progress bar."""
    from model.discrepancy import diagnose as find

    if not any(c.voltage_V for c in measurements.conditions):
        raise BadInputError(
            "nothing was measured under voltage, so there is no EIBM to be found; measure at 0 V"
            " and at one voltage at least."
        )
    with progress("diagnose") as advance:
        return find(measurements, options, lambda text, share: advance(share, text))


def keep(session: Path, found: Diagnosis) -> None:
    """Keep what was found in the session, which may be where nothing can be written."""
    from labrig.report.diagnosis.store import keep_diagnosis

    try:
        keep_diagnosis(session, found)
    except LabrigError as error:
        warn(f"not kept in the session: {error}")


def print_diagnosis(found: Diagnosis) -> None:
    """Everything that was found, in the order in which it was found."""
    from labrig.report.diagnosis import tables as made

    say(made.gap_sentence(found))
    _print(made.where_table(found))
    for text in made.visibility(found):
        say(text)
    say()
    _print(made.invisible_table(found))
    _print(made.ranking_table(found))
    for text in made.verdict_sentences(found):
        say(text)
    say()
    _print(made.parameter_table(found))
    _print(made.improvement_table(found))
    scatter = made.scatter_sentence(found)
    for text in [scatter] * bool(scatter) + made.further_sentences(found):
        say(text)
    for text in made.next_sentences(found):
        say(text)


def _print(table: Table | None) -> None:
    if table is None:
        return
    if table.rows:
        print_table(table.title, table.columns, table.rows)
    if table.note:
        say(table.note)
        say()


def next_measurement(
    sessions: Sessions = None,
    between: Annotated[
        tuple[str, str] | None, typer.Option(help="two effects to be told apart")
    ] = None,
    sheet: Sheet = None,
    forces: Forces = None,
    curves: Curves = None,
    signals: Signals = None,
    model: Known = None,
    symmetric: Symmetric = False,
    output: Annotated[
        Path | None, typer.Option("--output", "-o", help="the protocol.toml to write")
    ] = None,
    force: Annotated[bool, typer.Option("--force", help="overwrite the protocol")] = False,
    as_json: Json = False,
) -> None:
    """Say which further measurement tells two effects apart, and write its protocol."""
    from labrig.experiment.next_protocol import protocol_text
    from labrig.report.diagnosis.tables import next_told
    from model.discrepancy import DiagnoseOptions
    from model.discrepancy import next_measurement as find

    if between is None:
        raise BadInputError(
            "name two effects with --between, such as --between gravity clamp_angle."
        )
    if between[0] == between[1]:
        raise BadInputError(f"--between names {between[0]} twice; name two different effects.")
    if output is not None and output.exists() and not force:
        raise BadInputError(f"{output}: is already there; give --force to overwrite it.")
    measurements = _measured(sessions, sheet, forces, curves, signals)
    options = DiagnoseOptions(symmetric=symmetric, model=_model(model))
    found = find(measurements, between, options)
    text = protocol_text(found, measurements, sessions[0] if sessions else None)
    if output is not None:
        write_text(output, text)
    if as_json:
        from labrig.config.base import parse_toml

        print_json({
            "why": found.why, "extra": found.extra, "separation_now": found.separation,
            "separation_expected": found.expected, "minutes": found.minutes,
            "protocol": parse_toml(text, "protocol.toml"),
        })  # fmt: skip
        return
    say(next_told(found))
    if output is None:
        say()
        say(text)
    else:
        say(f"wrote {output}")


def list_effects(context: typer.Context, as_json: Json = False) -> None:
    """The catalogue of effects that diagnose knows."""
    from labrig.report.tables.effects import catalogue_table, effect_as_dict
    from model.effects import catalogue

    if context.invoked_subcommand is not None:
        return
    every = catalogue()
    if as_json:
        print_json([effect_as_dict(one) for one in every.values()])
        return
    _print(catalogue_table(every))
    say("labrig effects show NAME says more about one.")


def show_effect(
    name: Annotated[str, typer.Argument(help="an effect's name")], as_json: Json = False
) -> None:
    """An effect: what it is, its form, how it shows, and what isolates it."""
    from labrig.report.tables.effects import effect_as_dict, effect_lines, parameter_table
    from model.effects import effect

    one = effect(name)
    if as_json:
        print_json(effect_as_dict(one))
        return
    for line in effect_lines(one):
        say(line)
    say()
    _print(parameter_table(one))


def _measured(
    sessions: list[Path] | None, sheet: Path | None, forces: Path | None, curves: Path | None,
    signals: Path | None,
) -> Measurements:  # fmt: skip
    tables = [path for path in (sheet, forces, curves, signals) if path is not None]
    if sessions and tables:
        raise BadInputError("give either a session or CSV tables, not both.")
    if sessions:
        return of_sessions(sessions)
    if sheet is None or forces is None:
        raise BadInputError("give a session, or CSV tables with --sheet and --forces.")
    from labrig.config import load_sheet
    from labrig.session import read_tables

    found = read_tables(load_sheet(sheet), forces, curves, signals)
    for text in found.warnings:
        warn(text)
    return found


def of_sessions(sessions: list[Path]) -> Measurements:
    """Measurements of sessions, taken together; what is not analysed yet is analysed."""
    from labrig.analysis.together import together
    from labrig.report.data.findings import measured

    with progress("analyze") as advance:
        return together([(path, measured(path, advance, warn)) for path in sessions])


def _model(path: Path | None) -> SheetModel | None:
    if path is None:
        return None
    from labrig.model_file import load_model

    return load_model(path)
