"""Diagnose, print and keep a diagnosis: for `diagnose` and for `run --diagnose`."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

from labrig.cli.screen import print_table, progress, say

if TYPE_CHECKING:
    from labrig.report.parts.table import Table
    from model import Measurements, SheetModel
    from model.discrepancy import DiagnoseOptions, Diagnosis


def diagnosed(measurements: Measurements, options: DiagnoseOptions) -> Diagnosis:
    """Diagnose with a progress bar."""
    from labrig.api.diagnose import diagnosed as searched

    with progress("diagnose") as advance:
        return searched(measurements, options, advance)


def known_model(path: Path | None) -> SheetModel | None:
    """Load the model file whose effects are known, where one is given."""
    if path is None:
        return None
    from labrig.model_file import load_model

    return load_model(path)


def print_diagnosis(found: Diagnosis, session: Path | None) -> None:
    """Print the whole diagnosis in the order in which it was made; `session` keeps it."""
    from labrig.report.diagnosis import tables as made
    from labrig.report.diagnosis.checks import check_table
    from labrig.report.diagnosis.limits import visibility
    from labrig.report.diagnosis.parameters import choice_table, parameter_table

    if not found.searched:
        for text in made.verdict_sentences(found) + made.further_sentences(found):
            say(text)
        return
    say(made.gap_sentence(found))
    print_noted_table(made.where_table(found))
    for text in visibility(found):
        say(text)
    say()
    print_noted_table(made.invisible_table(found))
    print_noted_table(made.ranking_table(found))
    for text in made.verdict_sentences(found):
        say(text)
    say()
    print_noted_table(check_table(found))
    print_noted_table(parameter_table(found))
    print_noted_table(choice_table(found))
    print_noted_table(made.improvement_table(found))
    scatter = made.scatter_sentence(found)
    for text in [scatter] * bool(scatter) + made.further_sentences(found):
        say(text)
    for text in made.next_sentences(found, None if session is None else str(session)):
        say(text)


def print_noted_table(table: Table | None) -> None:
    """Print a table, where there is one, and the note below it."""
    if table is None:
        return
    if table.rows:
        print_table(table.title, table.columns, table.rows)
    if table.note:
        say(table.note)
        say()
