"""Choose an export format by its name, and write a session with it."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager, suppress
from pathlib import Path
from typing import Final

from drivers.plugins import OWN, PluginFolder, UnknownPartError
from labrig.errors import BadArgumentError, LabrigError
from labrig.exports.conformance import faults
from labrig.exports.contract import ExportFormat
from labrig.files import make_folder
from labrig.session import open_session

DEFAULT: Final = "csv"
FORMATS: Final[PluginFolder[ExportFormat]] = PluginFolder(
    what="export format",
    package="labrig.exports",
    constant="FORMAT",
    group="labrig.exports",
    faults=faults,
)


def export(
    session: Path | str,
    folder: Path | str,
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
    try:
        chosen = FORMATS.get(format)
    except UnknownPartError as error:
        raise BadArgumentError(f"format: {error}.", "format") from None
    with open_session(session):  # a file of another kind leaves no empty folder
        pass
    with _folder(Path(folder)) as target:
        try:
            written: object = chosen.write(Path(session), target)
        except ModuleNotFoundError as error:
            raise BadArgumentError(
                f"format {format} needs the package {_package(format, error)}.", "format"
            ) from None
    whose = f"the export format '{format}' of {FORMATS.origins().get(format, 'labrig')}"
    if not isinstance(written, list) or not all(isinstance(one, Path) for one in written):
        raise LabrigError(
            f"{whose} returned {type(written).__name__}, not a list of the files that it wrote; "
            f"see {target}."
        )
    missing = [one.name for one in written if not one.exists()]
    if missing:
        raise LabrigError(
            f"{whose} did not write {', '.join(missing)}, which it says it wrote; see {target}."
        )
    return written


def _package(name: str, error: ModuleNotFoundError) -> str:
    """Return the package that a format lacks, and what to do."""
    part = FORMATS.find(name)
    distribution = OWN if part is None else part.distribution
    if part is None or not part.part.extra:
        return f"{error.name}, which {distribution} does not install; install it"
    return f'{error.name}; install it with: pip install "{distribution}[{part.part.extra}]"'


@contextmanager
def _folder(path: Path) -> Iterator[Path]:
    """Make a folder where there is none, and take it away again if nothing comes into it."""
    was_there = path.exists()
    make_folder(path)
    try:
        yield path
    except BaseException:
        if not was_there:
            with suppress(OSError):  # something is in it
                path.rmdir()
        raise
