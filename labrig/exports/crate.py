"""An RO-Crate: session, models, report, licence and what was made from what.

Source: https://www.researchobject.org/ro-crate/specification/1.1.
"""

from __future__ import annotations

import tempfile
from pathlib import Path
from typing import Any
from urllib.parse import unquote

from labrig.errors import BadInputError
from labrig.exports._files import new_file
from labrig.files import all_or_none, check_is_text
from labrig.library.fits import looks_like_model
from labrig.model_file import load_model
from labrig.report.page.write import write_report
from labrig.session import open_session
from labrig.session.reading.session import RecordedSession

_SPDX = "https://spdx.org/licenses/"
_ORCID = "https://orcid.org/"


class _Crate:
    summary = "An RO-Crate: session, its models, the report, licence and provenance."
    extra = "crate"

    def write(self, session: Path, folder: Path) -> list[Path]:
        from rocrate.rocrate import ROCrate

        for path in (session, folder):
            check_is_text(path.absolute())
        metadata = new_file(folder, "ro-crate-metadata.json")
        crate = ROCrate()
        with open_session(session) as opened, tempfile.TemporaryDirectory() as made:
            if opened.outdated:
                raise BadInputError(f"{session}: {opened.outdated}")
            recording = _recording(crate, opened, session)
            _about(crate, opened)
            sources = [recording, *_models(crate, session, opened.checksum, recording)]
            if opened.has_measurements:
                _report(crate, session, Path(made), sources)
            files = [_place(folder, entity) for entity in crate.data_entities]
            with all_or_none([metadata, *files]):
                crate.write(folder)
        return [metadata, *sorted(files)]


def _place(folder: Path, entity: Any) -> Path:
    """Return where a file is written. What lies there already must be that very file."""
    path = folder / unquote(entity.id)
    if path.exists() and not path.samefile(entity.source):
        return new_file(folder, path.name)
    return path


def _recording(crate: Any, session: RecordedSession, path: Path) -> Any:
    properties = {
        "name": "session file",
        "encodingFormat": ["application/x-hdf5", {"@id": "https://www.nexusformat.org/"}],
        "identifier": session.identifier,
        "dateCreated": session.started,
    }
    recording = crate.add_file(path, path.name, properties=properties)
    boards = f"boards: {session.boards}"
    _action(
        crate,
        "#recording",
        "labrig run",
        sources=[],
        result=recording,
        when=session.ended,
        why=boards,
    )
    return recording


def _about(crate: Any, session: RecordedSession) -> None:
    from rocrate.model.contextentity import ContextEntity
    from rocrate.model.person import Person

    about = session.about
    crate.name = about.title or session.path.stem
    crate.description = f"A session of labrig: {session.schedule.protocol}, {session.outcome.value}"
    crate.datePublished = session.ended or session.started
    if about.licence:
        named = ContextEntity(
            crate,
            f"{_SPDX}{about.licence}",
            properties={"@type": "CreativeWork", "name": about.licence},
        )
        crate.license = crate.add(named)
    people = [
        Person(
            crate,
            f"{_ORCID}{person.orcid}" if person.orcid else f"#person-{number}",
            properties={
                key: value
                for key, value in (
                    ("name", person.name),
                    ("affiliation", person.affiliation),
                    ("email", person.email),
                )
                if value
            },
        )
        for number, person in enumerate(about.people, 1)
    ]
    if people:
        crate.creator = [crate.add(person) for person in people]


def _models(crate: Any, session: Path, checksum: str, recording: Any) -> list[Any]:
    """Add the model files beside the session that were fitted to it."""
    found = []
    for path in sorted(session.parent.glob("*.toml")):
        if not looks_like_model(path):
            continue
        model = load_model(path)
        if model.checksum != checksum:
            continue
        properties = {"name": "model of the sheet", "encodingFormat": "application/toml"}
        entity = crate.add_file(path, path.name, properties=properties)
        command = "labrig diagnose" if model.effects else "labrig fit"
        held = ", ".join(model.held_out) or "nothing"
        why = f"held out: {held}; data sha256 {model.checksum}"
        _action(crate, f"#{path.stem}", command, sources=[recording], result=entity, why=why)
        found.append(entity)
    return found


def _report(crate: Any, session: Path, made: Path, sources: list[Any]) -> None:
    page = write_report(session, made / "report")
    properties = {"name": "report", "encodingFormat": "text/html"}
    entity = crate.add_file(page, "report.html", properties=properties)
    _action(crate, "#report", "labrig report", sources=sources, result=entity)


def _action(
    crate: Any,
    identifier: str,
    command: str,
    *,
    sources: list[Any],
    result: Any,
    when: str = "",
    why: str = "",
) -> None:
    """Add what made one entity of others: the provenance."""
    from rocrate.model.contextentity import ContextEntity

    program = crate.dereference("#labrig") or crate.add(
        ContextEntity(
            crate, "#labrig", properties={"@type": "SoftwareApplication", "name": "labrig"}
        )
    )
    action = crate.add(
        ContextEntity(
            crate,
            identifier,
            properties={
                key: value
                for key, value in (
                    ("@type", "CreateAction"),
                    ("name", command),
                    ("description", why),
                    ("endTime", when),
                )
                if value
            },
        )
    )
    action["instrument"] = program
    if sources:
        action["object"] = sources
    action["result"] = result


FORMAT = _Crate()
