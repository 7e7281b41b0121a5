"""What kind of thing a [camera] source of OpenCV is, and what is known of the camera there."""

from __future__ import annotations

import os
import re
import stat
import sys
from contextlib import closing, suppress
from pathlib import Path
from typing import Any
from urllib.parse import urlsplit, urlunsplit

from drivers.identity import says_simulated
from drivers.interfaces import DeviceIdentity

_VIDEO_DEVICE = re.compile(r"/dev/video(\d+)")
_PREFIX = re.compile(r"\w{2,}:")  # of an address or a kind of camera; a drive has one letter
_V4L = Path("/sys/class/video4linux")
_ANSWER_S = 0.4  # to connect, and to answer
_SHOWN = 80  # characters of a server's name


def is_url(source: int | str) -> bool:
    """Whether a source is the address of a stream."""
    return isinstance(source, str) and "://" in source


def is_file(source: int | str) -> bool:
    """Whether a source is a recording."""
    try:
        return isinstance(source, str) and stat.S_ISREG(os.stat(source).st_mode)
    except (OSError, ValueError):  # a pipeline or a URL is no path
        return False


def may_be_path(source: str) -> bool:
    """Whether a source names a file or device: no address, pipeline of GStreamer, or number."""
    return not (_PREFIX.match(source) or "!" in source or source.isdecimal())


def identity_of_source(source: int | str, capture: Any, v4l: Path = _V4L) -> DeviceIdentity:
    """Return what is known of the camera behind a capture of OpenCV.

    OpenCV itself knows its backend only; on Linux the kernel knows model and serial of a camera
    with a number; a camera on the network names its server.
    """
    product, serial = _by_kernel(source, v4l)
    product = product or _by_server(source)
    return DeviceIdentity(
        name=without_password(str(source)),
        product=product,
        serial=serial,
        driver=_driver(capture),
        is_simulated=says_simulated(product),
    )


def without_password(source: str) -> str:
    """Return a source as it may be recorded: an address without its user and password."""
    return re.sub(r"://[^/@]*@", "://", source)


def _driver(capture: Any) -> str:
    """Return OpenCV's version and backend; empty for a capture of another make."""
    if "cv2" not in sys.modules:  # then it made no capture either
        return ""
    import cv2

    if not isinstance(capture, cv2.VideoCapture):
        return ""
    try:
        return f"OpenCV {cv2.__version__} {capture.getBackendName()}"
    except cv2.error:
        return f"OpenCV {cv2.__version__}"


def _by_kernel(source: int | str, v4l: Path) -> tuple[str, str]:
    """Return model and serial of a video device, where this system is a Linux that knows it."""
    match = _VIDEO_DEVICE.fullmatch(os.path.realpath(source)) if isinstance(source, str) else None
    number = source if isinstance(source, int) else int(match.group(1)) if match else None
    if number is None:
        return "", ""
    device = v4l / f"video{number}"
    return _line(device / "name"), _line(device / "device" / ".." / "serial")


def _by_server(source: int | str) -> str:
    """Return what an HTTP server calls itself; empty for other sources, and where it does not.

    The name stands in the header of any answer, a refusal included: no password is sent.
    """
    if not (isinstance(source, str) and source.startswith(("http://", "https://"))):
        return ""
    from http.client import HTTPConnection, HTTPException, HTTPSConnection  # slow to import

    with suppress(OSError, HTTPException, ValueError):
        address = urlsplit(source)
        kind = HTTPSConnection if address.scheme == "https" else HTTPConnection
        with closing(kind(address.hostname or "", address.port, timeout=_ANSWER_S)) as connection:
            connection.request("HEAD", urlunsplit(("", "", address.path or "/", address.query, "")))
            return (connection.getresponse().headers["Server"] or "").strip()[:_SHOWN]
    return ""


def _line(path: Path) -> str:
    with suppress(OSError, UnicodeDecodeError, ValueError):
        return path.read_text(encoding="utf-8").strip()
    return ""
