"""Read the frames of a video, each with its number and time."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from labrig.errors import BadInputError, LabrigWarning, warn_caller
from labrig.files import check_is_text
from labrig.vision.image.cut_short import lacks_bytes
from labrig.vision.image.library_messages import without_lines_of_libraries
from labrig.vision.image.names import Picture, PictureLabel, picture_name, whole_file

# of FFmpeg, which conceals what it cannot decode; others of its lines are of harmless faults
_DAMAGED_FRAME = re.compile(
    "damaged|corrupt|concealing|error (y=|count|while decoding)|error at MB|bad vlc|invalid"
    "|overread|LZW decode failed",
    re.IGNORECASE,
)
_BESIDE_THE_PICTURE = re.compile(r"\bAPP fields|\bapp: |\bEXIF\b|\bICC\b")  # of a frame of MJPEG
_INTERLACED = "Cannot convert interlaced"  # of FFmpeg; the picture is then of anything
_ENDED_EARLY = "ended prematurely"  # of FFmpeg, of a Matroska file
_SQUARE_TO = 0.01  # of the width of a pixel


@dataclass(frozen=True)
class _Frame:
    """A frame as OpenCV gives it; `image` is None where it was not asked for."""

    is_there: bool  # False: after the last one
    time_s: float
    image: Any
    said: list[str]  # by FFmpeg, while it was read


def frames_in(path: Path, every: int) -> Iterator[Picture]:
    """Yield the first of each `every` frames, each that is damaged, and a row on a lost end.

    Raises BadInputError where none can be read.
    """
    check_is_text(path)
    video = _opened(path)
    try:
        if not video.isOpened():
            raise BadInputError(f"{path}: not a video that OpenCV can open.")
        _tell_of_pixels(path, video)
        yield from _pictures(path, video, every)
    finally:
        video.release()


def _pictures(path: Path, video: Any, every: int) -> Iterator[Picture]:
    name, number, begin_s, last_s, cut = picture_name(path), 0, 0.0, -1.0, False
    while True:
        frame = _next(video, is_wanted=number % every == 0)
        cut = cut or any(_ENDED_EARLY in line for line in frame.said)
        if not frame.is_there:
            break
        begin_s = frame.time_s if number == 0 else begin_s
        # a stream without time stamps gives 0 for each frame
        time_s = round(frame.time_s - begin_s, 6) if frame.time_s > last_s else None
        stem = f"{name}_{number:06d}"
        label = PictureLabel(name=stem, file_stem=stem, frame=number, time_s=time_s)
        if why := _why_unusable(frame.said):
            yield Picture(label=label, image=None, why=f"{path}: frame {number} {why}")
        elif frame.image is not None:
            yield Picture(label=label, image=np.asarray(frame.image))
        last_s = max(last_s, frame.time_s)
        number += 1
    if number == 0:
        raise BadInputError(
            f"{path}: this video has no frame that can be read; copy it again, or save it in "
            "another format, such as H.264 in MP4."
        )
    if cut or _is_cut(path, video, number, frame.said):
        why = (
            f"{path}: this video is damaged or cut short: after frame {number - 1} none could"
            " be read; copy it again."
        )
        yield Picture(label=whole_file(path), image=None, why=why)


def _next(video: Any, *, is_wanted: bool) -> _Frame:
    import cv2

    with without_lines_of_libraries() as said:
        is_there, image = video.grab(), None
        time_s = video.get(cv2.CAP_PROP_POS_MSEC) / 1000
        if is_there and is_wanted:
            is_there, image = video.retrieve()
    return _Frame(is_there, time_s, image, said)


def _is_cut(path: Path, video: Any, count: int, said_at_end: list[str]) -> bool:
    """Return whether frames lack at the end.

    Some formats state more frames than can be shown: those that an edit list hides, that were
    dropped in recording, or that fill the time of the longest stream, such as the sound.
    """
    import cv2

    stated = round(video.get(cv2.CAP_PROP_FRAME_COUNT))
    return count < stated and (bool(said_at_end) or lacks_bytes(path))


def _why_unusable(theirs: list[str]) -> str:
    """Return why a frame is not used, by what FFmpeg said of it; empty: it is used."""
    if any(_INTERLACED in line for line in theirs):
        return (
            "is interlaced (made of two half pictures), which OpenCV cannot convert; convert the "
            "video first, as `ffmpeg -i OLD -vf yadif NEW` does."
        )
    said = (line for line in theirs if not _BESIDE_THE_PICTURE.search(line))
    if any(_DAMAGED_FRAME.search(line) for line in said):
        return "is damaged; those after it may be, too."
    return ""


def _tell_of_pixels(path: Path, video: Any) -> None:
    """Warn of pixels that are not square: lengths across and down have other scales then."""
    import cv2

    wide, high = video.get(cv2.CAP_PROP_SAR_NUM), video.get(cv2.CAP_PROP_SAR_DEN)
    if wide > 0 and high > 0 and abs(wide / high - 1) > _SQUARE_TO:
        warn_caller(
            LabrigWarning(
                f"{path}: its pixels are {wide / high:.3g} times as wide as high, and are taken as "
                "square; convert the video first, as `ffmpeg -i OLD -vf scale=iw*sar:ih,setsar=1 "
                "NEW` does."
            )
        )


def _opened(path: Path) -> Any:
    """Return a video; by FFmpeg with one thread, so that what it says is of the frame it reads."""
    import cv2

    cv2.utils.logging.setLogLevel(cv2.utils.logging.LOG_LEVEL_SILENT)  # no backend, no video
    with without_lines_of_libraries():
        video = cv2.VideoCapture(str(path), cv2.CAP_FFMPEG, [cv2.CAP_PROP_N_THREADS, 1])
        video = video if video.isOpened() else cv2.VideoCapture(str(path))
        video.set(cv2.CAP_PROP_ORIENTATION_AUTO, 1)
    return video
