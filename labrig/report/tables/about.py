"""People, sample and notes as tables."""

from __future__ import annotations

from collections.abc import Sequence

from labrig.config import About
from labrig.report.parts.table import Table
from labrig.session import Note

ROLES = {"principal_investigator": "principal investigator", "data_curator": "data curator"}


def about_tables(about: About) -> list[Table]:
    """Return what about.toml states; nothing for what it does not."""
    found = [_facts("About", _experiment(about)), _people(about), _facts("Sample", _sample(about))]
    return [table for table in found if table.rows]


def notes_table(notes: Sequence[Note]) -> Table:
    """Return all notes in their order; a photograph by its name."""
    rows = tuple((note.when[:16].replace("T", " "), note.who, text_of(note)) for note in notes)
    columns = ("when (UTC)", "who", "note")
    return Table(title="Notes", columns=columns, rows=rows, text=True)


def text_of(note: Note) -> str:
    """Return a note's text; a photograph is named with it."""
    if not note.has_photograph:
        return note.text
    photograph = f"photograph {note.file_name}".strip()
    return f"{note.text} ({photograph})" if note.text else photograph


def _facts(title: str, rows: dict[str, str]) -> Table:
    stated = tuple((name, text) for name, text in rows.items() if text)
    return Table(title=title, columns=("property", "value"), rows=stated, text=True)


def _experiment(about: About) -> dict[str, str]:
    return {"title": about.title, "project": about.project, "licence": about.licence}


def _people(about: About) -> Table:
    """Return a row for each person; what is stated of nobody has no column."""
    rows = [
        (person.name, ROLES.get(person.role, person.role), person.affiliation, person.email,
         f"https://orcid.org/{person.orcid}" if person.orcid else "")
        for person in about.people
    ]  # fmt: skip
    columns = ("name", "role", "affiliation", "e-mail", "ORCID iD")
    used = [place for place in range(len(columns)) if any(row[place] for row in rows)]
    return Table(
        title="People",
        columns=tuple(columns[place] for place in used),
        rows=tuple(tuple(row[place] for place in used) for row in rows),
        text=True,
    )


def _sample(about: About) -> dict[str, str]:
    sample = about.sample
    if sample is None:
        return {}
    made = "" if sample.made is None else sample.made.isoformat()
    return {
        "identity": sample.identity,
        "material": sample.material,
        "batch": sample.batch,
        "preparation": sample.preparation,
        "made": made,
        "notes": sample.notes,
    }
