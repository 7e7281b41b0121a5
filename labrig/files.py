"""Files that appear whole or not at all, and why one could not be written."""

from __future__ import annotations

import datetime as dt
import errno
import os
import shlex
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager, suppress
from itertools import count
from pathlib import Path
from subprocess import list2cmdline
from zipfile import ZIP_DEFLATED, ZipFile

from labrig.errors import BadArgumentError, BadInputError, LabrigError, type_in_words

AnyPath = str | os.PathLike[str]  # also an open session
SESSION_ENDINGS = (".h5", ".hdf5", ".nxs")
# A path that cannot be written at all; other errors are the disk's.
_WRONG_PATH = frozenset(
    {errno.EROFS, errno.EACCES, errno.EPERM, errno.ENOENT, errno.ENOTDIR, errno.EISDIR,
     errno.EEXIST, errno.ENAMETOOLONG, errno.EINVAL}
)  # fmt: skip
_PARTS = count()


def path_of(path: AnyPath) -> Path:
    """Return a path that was given as text, as a path or as an open session.

    Raises BadInputError for anything else: a caller in Python may give anything.
    """
    try:
        return Path(os.fspath(path))
    except TypeError:
        raise BadInputError(f"a file is needed, not {type_in_words(path)}.") from None


def check_free(path: Path, *, force: bool = False) -> None:
    """Raise BadInputError where a file cannot be made there: before the work that it is for."""
    if path.is_dir():
        raise BadInputError(f"{path}: this is a folder; give the name of a file.")
    if path.exists() and not force:
        raise BadArgumentError(f"{path}: is already there; give force to overwrite it.", "force")
    if not path.parent.is_dir():
        raise BadInputError(f"{path.parent}: there is no such folder.")
    _refuse_unwritable(path)


def _refuse_unwritable(path: Path) -> None:
    """Raise what `not_written` returns where a file cannot be made beside one.

    It is tried: what the system says of permissions is not all, of an administrator or a network.
    """
    if _is_device(path):
        if not os.access(path, os.W_OK):
            raise not_written(path, PermissionError(errno.EACCES, os.strerror(errno.EACCES)))
        return
    part = part_of(path)
    try:
        part.touch(exist_ok=False)
    except OSError as error:
        raise not_written(path, error) from None
    finally:
        discard(part)


def check_session_name(path: Path) -> None:
    """Raise BadInputError for a session that is to be made under the name of another kind of file.

    Commands and the page look for sessions by their names.
    """
    if path.suffix.lower() not in SESSION_ENDINGS and not path.is_dir():
        raise BadInputError(f"{path}: a session is HDF5; name it {path.stem}.h5.")


def make_folder(folder: Path) -> None:
    """Make a folder if need be: before the work that it is for. Raise what `not_written` returns.

    Raises BadInputError where a file is in its place.
    """
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except FileExistsError:
        raise BadInputError(f"{folder}: this is a file, a folder is needed.") from None
    except OSError as error:
        raise not_written(folder, error) from None


@contextmanager
def new_folder(folder: Path) -> Iterator[Path]:
    """Make a folder where there is none, and take it away again if nothing comes into it."""
    was_there = folder.exists()
    make_folder(folder)
    try:
        yield folder
    except BaseException:
        if not was_there:
            with suppress(OSError):  # something is in it
                folder.rmdir()
        raise


def typed(path: Path | str) -> str:
    """Return a path, or another argument, as it is typed into a shell: quoted if need be."""
    return list2cmdline([str(path)]) if os.name == "nt" else shlex.quote(str(path))


def write_text(path: Path, text: str) -> None:
    """Write a file beside its place and rename it. Raise what `not_written` returns."""
    write_bytes(path, _encoded(text))


def as_text(text: str) -> str:
    """Return a text that may hold bytes, such as those of a name in an old encoding, as letters."""
    how = "replace" if os.name == "nt" else "surrogateescape"
    return text.encode("utf-8", how).decode("utf-8", "replace")


def check_is_text(path: Path) -> None:
    """Raise BadInputError for a name that a library which knows letters alone cannot take."""
    if as_text(str(path)) != str(path):
        raise BadInputError(
            f"{path}: its name holds bytes that are no letters here; rename it, or set "
            "PYTHONUTF8=1 where they are letters in UTF-8."
        )


def _encoded(text: str) -> bytes:
    return as_text(text).replace("\n", os.linesep).encode("utf-8")


def keep_replaced(path: Path, text: str) -> Path | None:
    """Copy a file that `text` is to replace to NAME.DATE.bak, or to the next free name like it.

    Returns the copy; None where nothing is lost. Raise what `not_written` returns.
    """
    if not path.is_file():
        return None
    before = path.read_bytes()
    if before == _encoded(text):
        return None
    day = dt.datetime.fromtimestamp(path.stat().st_mtime, dt.UTC).date().isoformat()
    names = (f"{path.name}.{day}{n}.bak" for n in ("", *(f".{i}" for i in range(1, 1000))))
    kept = next(path.with_name(name) for name in names if not path.with_name(name).exists())
    write_bytes(kept, before)
    return kept


def part_of(path: Path) -> Path:
    """Return a name beside a file to write it under: one that nobody else writes meanwhile.

    Raises BadInputError where a device or a pipe would be replaced.
    """
    if _is_device(path):
        raise BadInputError(f"{path}: this is a device or a pipe, an ordinary file is needed.")
    return path.with_name(f"{path.name}.{os.getpid()}-{next(_PARTS)}.part")


def write_bytes(path: Path, content: bytes) -> None:
    """Write a file as `write_text` does; into a device or a pipe, such as /dev/stdout, at once."""
    if _is_device(path):
        _write_into(path, content)
        return
    part = part_of(path)
    try:
        part.write_bytes(content)
        part.replace(path)
    except OSError as error:
        discard(part)
        raise not_written(path, error) from None


def _is_device(path: Path) -> bool:
    """Whether there is something that is neither a file nor a folder."""
    return path.exists() and not (path.is_file() or path.is_dir())


def _write_into(path: Path, content: bytes) -> None:
    try:
        with path.open("ab") as stream:
            stream.write(content)
    except OSError as error:
        raise not_written(path, error) from None


def write_zip(path: Path, files: Mapping[Path, str]) -> None:
    """Pack files under these names, beside the archive's place, and rename it. Raises likewise."""
    part = part_of(path)
    try:
        # Not strict: a computer without a battery for its clock begins in 1970, a zip in 1980.
        with ZipFile(part, "w", ZIP_DEFLATED, strict_timestamps=False) as archive:
            for file, name in files.items():
                archive.write(file, name)
        part.replace(path)
    except OSError as error:
        discard(part)
        raise not_written(path, error) from None


@contextmanager
def all_or_none(paths: Iterable[Path]) -> Iterator[None]:
    """Remove the files that were made of these, where one cannot be, or Ctrl-C comes between.

    Else the same command finds some of them there and refuses to go on. Others stay as they were.
    """
    new = [path for path in paths if not path.exists()]
    try:
        yield
    except BaseException:
        for path in new:
            discard(path)
        raise


def discard(part: Path) -> None:
    """Remove an unfinished file, as far as the disk allows it: it may be read-only."""
    with suppress(OSError):
        part.unlink(missing_ok=True)


def not_written(path: Path, error: OSError) -> LabrigError:
    """Return the error to raise: a failure where the disk is full or broken, else a wrong path."""
    why = "the disk is full" if error.errno == errno.ENOSPC else error.strerror
    return family_of(error)(f"{path}: cannot be written ({why}).")


def family_of(error: Exception) -> type[LabrigError]:
    """Return the family of errors: a wrong path, or the disk's fault."""
    wrong_path = isinstance(error, OSError) and error.errno in _WRONG_PATH
    return BadInputError if wrong_path else LabrigError
