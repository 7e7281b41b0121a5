"""Corrections of a folder that belong to no image there, such as of one that was renamed."""

from __future__ import annotations

import re
from collections.abc import Iterator
from pathlib import Path

from labrig.vision.calibration.optics import listed
from labrig.vision.image.beside import OPTICS_FILE, SHEET_FILE
from labrig.vision.image.names import every_file_in, picture_name
from labrig.vision.image.review import REVIEW_FILE, load_review

_OF_SEVERAL = re.compile(r"(:\d+|_\d{6,})$")  # a page's or frame's part of its name


def unused_corrections(folder: Path, *used: Path | None) -> str:
    """Return what belongs to no image of a folder, as a sentence; empty: nothing.

    `used`: files that serve all images. Raises BadInputError where curves_review.json is at fault.
    """
    serve_all = {path.resolve() for path in used if path is not None}
    files = every_file_in(folder)
    found = [
        *(path.name for path in _files(folder, files) if path.resolve() not in serve_all),
        *_decisions(folder, files),
    ]
    if not found:
        return ""
    belong, are, them = ("belongs", "is", "it") if len(found) == 1 else ("belong", "are", "them")
    return (
        f"{folder}: {listed(found)} {belong} to no image there and {are} not used; name {them} as "
        "the image is named."
    )


def _files(folder: Path, files: list[Path]) -> Iterator[Path]:
    names = {name for path in files for name in (path.name, path.stem)}
    for kind in (OPTICS_FILE, SHEET_FILE):
        for path in sorted(folder.glob(f"*.{kind}")):
            if path.name.removesuffix(f".{kind}") not in names:
                yield path


def _decisions(folder: Path, files: list[Path]) -> Iterator[str]:
    decided = load_review(folder)
    names = {picture_name(path) for path in files} if decided else set()
    for name in decided:
        if name not in names and _OF_SEVERAL.sub("", name) not in names:
            yield f"'{name}' of {REVIEW_FILE}"
