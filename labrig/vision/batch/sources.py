"""The images and films of a batch; what is refused or told before the first is measured."""

from __future__ import annotations

import os
from collections.abc import Callable, Iterator, Sequence
from contextlib import suppress
from pathlib import Path

from labrig.errors import BadInputError, LabrigWarning, warn_caller
from labrig.vision.batch.known import measures_length, optics_of
from labrig.vision.batch.options import BatchOptions
from labrig.vision.calibration.drawing import is_drawing
from labrig.vision.calibration.optics import listed
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE, beside, missing, own_file
from labrig.vision.image.files import load_strip
from labrig.vision.image.names import (
    files_in,
    holds_several,
    picture_name,
    whole_stem,
)
from labrig.vision.image.unused import unused_corrections

_MOST_NAMES = 3  # that a sentence lists
_LONGEST_NAME = 255  # bytes, of the usual disks
ADDED_BESIDE = len(".mjpeg.optics.json")  # to the stem of an image
ADDED_IN_RESULTS = len("_curve.png.4194304-99999.part")


def files_of(sources: Sequence[Path]) -> Iterator[Path]:
    """Yield all images and films of files and folders, without labrig's own drawings.

    Raises BadInputError.
    """
    for source in sources:
        if source.is_dir():
            yield from files_in(source, videos=True)
        elif not source.exists():
            raise BadInputError(f"{source}: there is no such file or folder.")
        elif not is_drawing(source):
            yield source


def tell_of_drawings(sources: Sequence[Path]) -> None:
    """Warn of labrig's own drawings among files, such as those of a shell's *.png."""
    drawn = [source.name for source in sources if source.is_file() and is_drawing(source)]
    if drawn:
        more = f" and {len(drawn) - _MOST_NAMES} more" if len(drawn) > _MOST_NAMES else ""
        warn_caller(
            LabrigWarning(
                f"labrig's own drawings are left out: {', '.join(drawn[:_MOST_NAMES])}{more}."
            )
        )


def tell_of_subfolders(sources: Sequence[Path]) -> None:
    """Warn of images in folders of a folder, which are left out."""
    for source in filter(Path.is_dir, sources):
        inner = [path.name for path in sorted(source.iterdir()) if path.is_dir()]
        held = [name for name in inner if _holds_images(source / name)]
        if held:
            warn_caller(
                LabrigWarning(
                    f"{source}: images in its folders ({listed(held)}) are left out; measure "
                    "each of these folders by itself."
                )
            )


def tell_of_unused_corrections(sources: Sequence[Path], options: BatchOptions) -> None:
    """Warn of corrections and decisions that belong to no image of their folder."""
    for source in filter(Path.is_dir, sources):
        told = unused_corrections(source, options.optics, options.sheet)
        if told:
            warn_caller(LabrigWarning(told))


def _holds_images(folder: Path) -> bool:
    """Whether there are images in a folder; none is seen in one that cannot be read."""
    with suppress(OSError):
        return bool(files_in(folder, videos=True))
    return False


def refuse_long_names(files: list[Path], added: int) -> None:
    """Raise BadInputError where a disk takes no name with so many bytes more than an image's."""
    for path in files:
        if len(os.fsencode(path.stem)) + added > _LONGEST_NAME:
            raise BadInputError(
                f"{path}: this name is too long for those of files that belong to it; shorten it."
            )


def refuse_twins(files: list[Path]) -> None:
    """Raise BadInputError where the results of two files would have one name."""
    seen: dict[str, Path] = {}
    for path in files:
        name = picture_name(path)
        if name in seen:
            raise BadInputError(
                f"{seen[name]} and {path} would both be written to {name}.json; "
                "rename one, or run them into different folders."
            )
        seen[name] = path
    for name, path in seen.items():
        many = seen.get(whole_stem(name))
        if many is not None and many != path and holds_several(many):
            raise BadInputError(
                f"{path} is named as a frame or page of {many} is, and both would be written to "
                f"{name}.json; rename one, or run them into different folders."
            )


def keep_photographs(sources: Sequence[Path], output: Path) -> None:
    """Raise BadInputError where an overlay would be written over a photograph of the batch."""
    files = list(files_of(sources))
    photographs = {path.resolve() for path in files}
    for path in files:
        overlay = output / f"{picture_name(path)}_curve.png"
        if overlay.resolve() in photographs:
            raise BadInputError(
                f"the overlay of {path} would be written over {overlay}; choose another folder "
                "with -o."
            )


def refuse_common_faults(files: list[Path], options: BatchOptions) -> None:
    """Raise for a fault in a file of several images; one in an own file costs that image only."""
    kinds: tuple[tuple[str, Path | None, Callable[[Path], object]], ...] = (
        (OPTICS_FILE, options.optics, lambda path: _check_optics(path, files, options)),
        (SHEET_FILE, options.sheet, lambda path: _check_sheet(path, files, options)),
    )
    for kind, given, load in kinds:
        _refuse_missing(given)
        found = {path: beside(path, kind, given) for path in files}
        if not any(found.values()) and (kind == OPTICS_FILE or _needs_sheet(files[0], options)):
            raise BadInputError(missing(files[0], kind))
        if given is not None and given not in found.values():
            own = own_file(files[0], kind).name
            warn_caller(
                LabrigWarning(
                    f"{given} is not used: each image has its own file beside it, such as {own}."
                )
            )
        for common in {each for path, each in found.items() if each != own_file(path, kind)}:
            if common is not None:
                load(common)


def _refuse_missing(given: Path | None) -> None:
    if given is not None and not given.exists():
        raise BadInputError(f"{given}: there is no such file.")


def _needs_sheet(path: Path, options: BatchOptions) -> bool:
    try:
        return not measures_length(optics_of(path, options))
    except BadInputError:
        return False  # a fault of that image's own file costs that image only


def _check_optics(optics: Path, files: list[Path], options: BatchOptions) -> None:
    """Read a common optics.json, with what is stated besides, as the first image with it does."""
    optics_of(next(p for p in files if beside(p, OPTICS_FILE, options.optics) == optics), options)


def _check_sheet(sheet: Path, files: list[Path], options: BatchOptions) -> None:
    """Read a common sheet.toml as the first image that uses it does."""
    first = next(path for path in files if beside(path, SHEET_FILE, options.sheet) == sheet)
    try:
        names = optics_of(first, options).by_strip()
    except BadInputError:
        names = {}  # a fault of that image's own file costs that image only
    for name in names:
        load_strip(sheet, options.configuration, name)
