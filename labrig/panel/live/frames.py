"""A frame on its way: raw from the job to the panel, as a JPEG from there to the pages."""

from __future__ import annotations

import time
from typing import Any

import numpy as np
import numpy.typing as npt

from drivers.interfaces import Clock, Frame, GreyImage, RealClock
from labrig.errors import LabrigError
from labrig.panel.live.event_stream import Message, Picture
from protocols.planning.schedule import PlannedRun

JPEG_QUALITY = 85


def exposure_time(clock: Clock, time_s: float) -> float | None:
    """Return the time of day (s since 1970) of a clock time; None on a virtual clock."""
    return time.time() - (clock.now() - time_s) if isinstance(clock, RealClock) else None


def raw_picture(
    frame: Frame,
    time_s: float | None,
    run: PlannedRun | None,
    voltage_V: float | None,
    *,
    exposed_s: float | None = None,
    force_mN: float | None = None,
) -> Picture:
    """Return a frame as acquired, with the conditions from which a model predicts the shape.

    `exposed_s`: see `exposure_time`; `force_mN`: of the last reading under the same conditions.
    """
    rows, columns = frame.image.shape
    position_m = None if run is None else run.position_m
    header: Message = {
        "type": "picture",
        "frame": frame.number,
        "time_s": time_s,
        "exposed_s": exposed_s,
        "run": None if run is None else run.index,
        "width": columns,
        "height": rows,
        "dtype": frame.image.dtype.name,
        "configuration": None if run is None else run.configuration,
        "position_mm": None if position_m is None else 1e3 * position_m,
        "voltage_V": voltage_V,
        "force_mN": force_mN,
    }
    return header, np.ascontiguousarray(frame.image).tobytes()


def image_of(header: Message, payload: bytes | memoryview) -> GreyImage:
    """Return the pixels of a raw picture. Raises ValueError, KeyError."""
    dtype = np.dtype(np.uint16 if header["dtype"] == "uint16" else np.uint8)
    shape = (int(header["height"]), int(header["width"]))
    return np.frombuffer(payload, dtype=dtype).reshape(shape)


def shown(image: GreyImage) -> npt.NDArray[np.uint8]:
    """8 bit for the eye: 12 or 16 bit pictures are stretched to what is in them."""
    if image.dtype == np.uint8:
        return np.asarray(image, dtype=np.uint8)
    top = max(int(image.max()), 1)
    return (image.astype(np.float32) * (255.0 / top)).astype(np.uint8)


def jpeg_picture(header: Message, image: GreyImage) -> Picture:
    """Return what pages are sent."""
    kept = ("type", "frame", "time_s", "exposed_s", "run", "width", "height")
    return {**{key: header[key] for key in kept}, "mime": "image/jpeg"}, jpeg(image)


def jpeg(image: GreyImage) -> bytes:
    """Return the picture as a JPEG."""
    import cv2

    return _encoded(image, ".jpg", [cv2.IMWRITE_JPEG_QUALITY, JPEG_QUALITY])


def png(image: GreyImage) -> bytes:
    """Return the picture as a PNG, nothing lost."""
    return _encoded(image, ".png", [])


def _encoded(image: GreyImage, kind: str, options: list[int]) -> bytes:
    import cv2

    good, packed = cv2.imencode(kind, shown(image) if kind == ".jpg" else image, options)
    if not good:
        raise LabrigError("a picture could not be packed.")
    packed_array: npt.NDArray[Any] = np.asarray(packed)
    return packed_array.tobytes()
