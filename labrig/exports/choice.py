"""Choose an export format by its name, and write a session with it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Final

from drivers.plugins import OWN, PluginFolder, UnknownPartError
from labrig.errors import BadArgumentError, LabrigError, type_in_words
from labrig.exports._files import new_file
from labrig.exports.conformance import faults
from labrig.exports.contract import ExportFormat
from labrig.files import AnyPath, new_folder, path_of
from labrig.session import open_session
from model.measurements.known_arguments import known_arguments

DEFAULT: Final = "csv"
FORMATS: Final[PluginFolder[ExportFormat]] = PluginFolder(
    what="export format",
    package="labrig.exports",
    constant="FORMAT",
    group="labrig.exports",
    faults=faults,
)


@known_arguments
def export(
    session: AnyPath,
    folder: AnyPath,
    format: str = DEFAULT,  # noqa: A002 - what it is; the function formats nothing else
) -> list[Path]:
    """Write a closed session into a folder in a format of this name.

    Args:
        session: the session file.
        folder: where to write; it is made where it does not exist.
        format: `csv`, `parquet`, `xarray`, `bluesky`, `crate`, `video`, or one of another
            distribution.

    Returns:
        The files written.

    Raises:
        BadInputError: no such format, a package is missing, a file is there already, or the session
            lacks what the format needs.
        LabrigError: another distribution's format does not say what it wrote.

    """
    if not isinstance(format, str):
        raise BadArgumentError(f"format: a text is needed, not {type_in_words(format)}.", "format")
    try:
        chosen = FORMATS.get(format)
    except UnknownPartError as error:
        raise BadArgumentError(f"format: {error}.", "format") from None
    session, folder = path_of(session), path_of(folder)
    with open_session(session):  # a file of another kind leaves no empty folder
        pass
    part = FORMATS.find(format)
    with new_folder(folder) as target:
        if part is None or part.distribution == OWN:
            return _written(format, chosen, session, target)
        with _aside(target) as aside:
            return _moved(_written(format, chosen, session, aside), aside, target)


def _written(name: str, chosen: ExportFormat, session: Path, folder: Path) -> list[Path]:
    """Return the files that a format wrote."""
    try:
        written: object = chosen.write(session, folder)
    except ModuleNotFoundError as error:
        raise BadArgumentError(
            f"format {name} needs the package {_package(name, error)}.", "format"
        ) from None
    whose = f"the export format '{name}' of {FORMATS.origins().get(name, 'labrig')}"
    if not isinstance(written, list) or not all(isinstance(one, Path) for one in written):
        raise LabrigError(
            f"{whose} returned {type(written).__name__}, not a list of the files that it wrote; "
            "nothing of it was kept."
        )
    missing = [one.name for one in written if not one.exists()]
    if missing:
        raise LabrigError(
            f"{whose} did not write {', '.join(missing)}, which it says it wrote; nothing of it "
            "was kept."
        )
    return written


@contextmanager
def _aside(folder: Path) -> Iterator[Path]:
    """Make a folder inside one for what another distribution writes: it may fail half-way."""
    with TemporaryDirectory(prefix=".export-", dir=folder, ignore_cleanup_errors=True) as aside:
        yield Path(aside)


def _moved(written: list[Path], aside: Path, folder: Path) -> list[Path]:
    """Move everything into the folder, all or nothing, and return where the files are then."""
    every = [one.relative_to(aside) for one in sorted(aside.rglob("*")) if not one.is_dir()]
    named = [_moved_to(one, aside, folder) for one in written]
    for one in every:
        for parent in one.parents:
            if not (folder / parent).is_dir():  # a file in the way of a folder
                new_file(folder, str(parent))
        new_file(folder, str(one))
    for one in every:
        (folder / one).parent.mkdir(parents=True, exist_ok=True)
        (aside / one).replace(folder / one)
    return named


def _moved_to(path: Path, aside: Path, folder: Path) -> Path:
    """Return where a file will be; a format may name it by another way to the folder aside."""
    there = path.parent.resolve() / path.name
    within = aside.resolve()
    return folder / there.relative_to(within) if there.is_relative_to(within) else path


def _package(name: str, error: ModuleNotFoundError) -> str:
    """Return the package that a format lacks, and what to do."""
    part = FORMATS.find(name)
    distribution = OWN if part is None else part.distribution
    if part is None or not part.part.extra:
        return f"{error.name}, which {distribution} does not install; install it"
    return f'{error.name}; install it with: pip install "{distribution}[{part.part.extra}]"'
