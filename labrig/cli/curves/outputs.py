"""Where `labrig curves` may write: never over a photograph or what is known of it."""

from __future__ import annotations

from pathlib import Path

from labrig.errors import BadInputError
from labrig.files import check_free

_TABLES = (".csv", ".txt")


def check_outputs(
    output: Path | None,
    summary: Path | None = None,
    overlay: Path | None = None,
    *,
    force: bool = False,
) -> None:
    """Raise BadInputError, before anything is measured, for what cannot or must not be written.

    `force`: tables that are there already may be overwritten.
    """
    for path in (output, summary):
        if path is None:
            continue
        # a photograph is never overwritten, whatever is forced
        if _is_file(path) and not path.is_dir() and path.suffix.lower() not in _TABLES:
            raise BadInputError(f"{path}: a table is CSV; name it {path.stem}.csv.")
        check_free(path, force=force or _is_device(path))
    if overlay is not None:
        check_free(overlay, force=True)
    if output is not None and summary is not None and output.resolve() == summary.resolve():
        raise BadInputError(f"{output}: -o and --summary are two tables; name two files.")
    if overlay is not None:
        _check_overlay(overlay)


def _check_overlay(path: Path) -> None:
    from labrig.vision.calibration.drawing import is_drawing

    if _is_file(path) and path.suffix.lower() != ".png":
        raise BadInputError(f"{path}: an overlay is PNG; name it {path.stem}.png.")
    if path.is_file() and not is_drawing(path):
        raise BadInputError(
            f"{path}: this image would be overwritten; give --overlay another name."
        )


def _is_device(path: Path) -> bool:
    return path.exists() and not _is_file(path) and not path.is_dir()


def _is_file(path: Path) -> bool:
    """Whether it is or would be one, and not a device such as the terminal."""
    return path.is_file() or not path.exists()
