"""Videos: the frames of each run, with a caption that has time, voltage and force."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

from labrig.errors import BadInputError, LabrigError
from labrig.exports._files import new_file
from labrig.files import all_or_none, check_is_text, discard, not_written
from labrig.session import RunRecord, open_session
from model.measurements import in_volts

Picture = npt.NDArray[np.uint8]
CODEC = "MJPG"  # in AVI, which every system plays
_SLOWEST_HZ, _FASTEST_HZ = 0.5, 240.0
_CAPTION_PX, _NARROWEST_PX = 28, 320


class _Video:
    summary = "The frames of each run as run-NN-SHEET-PLACE.avi, at the rate they were taken."
    extra = ""

    def write(self, session: Path, folder: Path) -> list[Path]:
        with open_session(session) as recorded:
            runs = [run for run in recorded.runs if run.started and run.frame_count]
            if not runs:
                raise BadInputError(f"{session}: no frames were recorded, so there is no video.")
            paths = [new_file(folder, f"{_name(run)}.avi") for run in runs]
            with all_or_none(paths):
                for run, path in zip(runs, paths, strict=True):
                    _write(run, path)
        return paths


def _name(run: RunRecord) -> str:
    planned = run.planned
    place = "free" if planned.position_m is None else f"{1e3 * planned.position_m:g}mm"
    kind = f"-{planned.extra}" if planned.extra else ""
    return f"run-{planned.index + 1:02d}-{planned.configuration}-{place}{kind}"


def rate_hz(run: RunRecord) -> float:
    """Return the rate of a run's frames, as its clock has them."""
    steps = np.diff(run.frame_column("time"))
    steps = steps[steps > 0.0]
    rate = 1.0 / float(np.median(steps)) if len(steps) else 1.0
    return float(np.clip(rate, _SLOWEST_HZ, _FASTEST_HZ))


def _write(run: RunRecord, path: Path) -> None:
    """Write a video beside its place and rename it."""
    import cv2

    check_is_text(path)
    part = path.with_name(f"{path.stem}.part{path.suffix}")
    pictures = _pictures(run)
    first = next(pictures)
    size = (first.shape[1], first.shape[0])
    # The name's ending chooses the container; a build without FFmpeg takes OpenCV's own encoder.
    codec = cv2.VideoWriter.fourcc(*CODEC)
    writer = cv2.VideoWriter(str(part), codec, rate_hz(run), size, isColor=False)
    try:
        if not writer.isOpened():
            raise OSError(None, "the folder cannot be written", str(path))
        writer.write(first)
        for picture in pictures:
            writer.write(picture)
        writer.release()
        part.replace(path)
    except OSError as error:
        raise not_written(path, error) from None
    except cv2.error as error:
        raise LabrigError(f"{path}: cannot be encoded as a video ({error.err}).") from None
    finally:
        writer.release()
        discard(part)


def _pictures(run: RunRecord) -> Iterator[Picture]:
    """Yield the frames in order, as 8-bit grey with their captions."""
    times_s, readings = run.frame_column("time"), run.frame_column("reading")
    rows = {int(row["index"]): row for row in run.readings}
    for number in range(run.frame_count):
        grey = _enlarged(_eight_bits(run.image(number)))
        text = _caption(run, float(times_s[number]), rows.get(int(readings[number])))
        yield np.vstack([grey, _strip(grey.shape[1], text)])


def _eight_bits(image: npt.NDArray[Any]) -> Picture:
    if image.dtype == np.uint8:
        return np.asarray(image)
    return np.asarray(image >> 8 * (image.dtype.itemsize - 1), dtype=np.uint8)


def _enlarged(image: Picture) -> Picture:
    """Return a small image enlarged by a whole number: the caption needs room."""
    times = -(-_NARROWEST_PX // image.shape[1])
    return np.asarray(image.repeat(times, axis=0).repeat(times, axis=1))


def _caption(run: RunRecord, time_s: float, reading: Any) -> str:
    if reading is None:
        return f"{time_s:7.3f} s  {in_volts(_voltage_V(run, time_s))}"
    force_N = run.values(reading).get("force_N", np.nan)
    force = "" if np.isnan(force_N) else f"  {1e3 * force_N:+.2f} mN"
    invalid = "" if reading["valid"] else "  invalid"
    return f"{time_s:7.3f} s  {in_volts(float(reading['voltage_V']))}{force}{invalid}"


def _voltage_V(run: RunRecord, time_s: float) -> float:
    """Return the planned voltage at a time of the run."""
    before = [step.voltage_V for step in run.planned.steps if step.time_s <= time_s]
    return before[-1] if before else 0.0


def _strip(width: int, text: str) -> Picture:
    import cv2

    strip = np.zeros((_CAPTION_PX, width), np.uint8)
    cv2.putText(
        img=strip,
        text=text,
        org=(8, _CAPTION_PX - 9),
        fontFace=cv2.FONT_HERSHEY_SIMPLEX,
        fontScale=0.5,
        color=255,
        thickness=1,
        lineType=cv2.LINE_AA,
    )
    return strip


FORMAT = _Video()
