"""Which files of a folder are images or videos, and what they and their results are called."""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy.typing as npt

from labrig.vision.calibration.drawing import is_drawing

IMAGE_SUFFIXES = (".png", ".tif", ".tiff", ".bmp", ".jpg", ".jpeg", ".pgm", ".webp")
TIFF_SUFFIXES = (".tif", ".tiff")
HEIC_SUFFIXES = (".heic", ".heif")  # of many telephones; refused with a reason
_CONTAINERS = (".avi", ".mp4", ".m4v", ".mov", ".mkv", ".webm")
VIDEO_SUFFIXES = (*_CONTAINERS, ".y4m", ".mjpg", ".mjpeg", ".gif")


def picture_name(path: Path) -> str:
    """Return what a file's results are called: NAME of NAME.png.

    Where NAME.jpg, or a video of that name, lies beside it, it is the whole name, NAME.png.
    """
    suffixes = IMAGE_SUFFIXES + VIDEO_SUFFIXES
    # not a list of the folder: that of one with many files takes long for each of them
    written = (*suffixes, *(suffix.upper() for suffix in suffixes))
    beside = (path.with_name(path.stem + suffix) for suffix in written)
    return path.name if any(_is_other(each, path) for each in beside) else path.stem


def _is_other(path: Path, than: Path) -> bool:
    """Whether there is such a photograph beside the other one."""
    if path == than or not path.is_file() or is_drawing(path):
        return False
    return not (than.exists() and path.samefile(than))  # .PNG and .png may be one file


def is_video(path: Path) -> bool:
    """Return whether a file is read as a video."""
    return path.suffix.lower() in VIDEO_SUFFIXES


def files_in(folder: Path, *, videos: bool) -> list[Path]:
    """Return the images, and videos, of a folder; HEIC ones that are not there in another form.

    What labrig drew itself is left out.
    """
    every = every_file_in(folder)
    stems = {path.stem for path in every if path.suffix.lower() not in HEIC_SUFFIXES}
    heic = [path for path in every if path.suffix.lower() in HEIC_SUFFIXES]
    suffixes = IMAGE_SUFFIXES + (VIDEO_SUFFIXES if videos else ())
    known = [path for path in every if path.suffix.lower() in suffixes]
    return sorted(known + [path for path in heic if path.stem not in stems])


def every_file_in(folder: Path) -> list[Path]:
    """Return all images and videos of a folder but what labrig drew itself."""
    suffixes = IMAGE_SUFFIXES + VIDEO_SUFFIXES + HEIC_SUFFIXES
    known = (path for path in folder.iterdir() if path.suffix.lower() in suffixes)
    return sorted(path for path in known if path.is_file() and not is_drawing(path))


def holds_several(path: Path) -> bool:
    """Return whether a file is of a kind that may hold several pictures."""
    return path.suffix.lower() in (*VIDEO_SUFFIXES, *TIFF_SUFFIXES)


def whole_stem(file_stem: str) -> str:
    """Return the stem of the file that a frame or page of such a name belongs to."""
    return re.sub(r"_(\d{6,}|page\d{4,})$", "", file_stem)


@dataclass(frozen=True, kw_only=True)
class PictureLabel:
    """What a picture is called: FILE, FILE:PAGE or FILE_FRAME; with several strips also :STRIP.

    FILE is as `picture_name` returns it.
    """

    name: str
    file_stem: str  # of the files that are written for it
    frame: int | None = None  # of a video, from 0; of a TIFF with several pages the page, from 1
    time_s: float | None = None  # from the video's begin, as the video states it
    strip: str = ""  # which one of several strips

    def of_strip(self, strip: str) -> PictureLabel:
        """Return the label of one of several strips; of the only one, without a name, the same."""
        if not strip:
            return self
        stem = f"{self.file_stem}_{strip}"
        return replace(self, name=f"{self.name}:{strip}", file_stem=stem, strip=strip)


def whole_file(path: Path) -> PictureLabel:
    """Return the label of a file with one picture, or with none that can be read."""
    name = picture_name(path)
    return PictureLabel(name=name, file_stem=name)


@dataclass(frozen=True, kw_only=True, eq=False)
class Picture:
    """A picture of a file. Where it cannot be read, `image` is None and `why` is a sentence."""

    label: PictureLabel
    image: npt.NDArray[Any] | None
    why: str = ""
