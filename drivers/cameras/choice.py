"""The camera that [camera] source in rig.toml names."""

from __future__ import annotations

from typing import Any

from drivers.cameras.opencv import OpenCvCamera
from drivers.interfaces import Clock


def camera_for(source: int | str, clock: Clock, rate_hz: float = 30.0) -> OpenCvCamera:
    """A camera on libdc1394 for `iidc:GUID`, else whatever OpenCV opens; not opened yet."""
    if isinstance(source, str) and source.startswith("iidc:"):

        def iidc(name: str) -> Any:
            from drivers.cameras.iidc import IidcCapture, iidc_guid

            return IidcCapture(iidc_guid(name), clock, rate_hz)

        return OpenCvCamera(source, clock, iidc)
    return OpenCvCamera(source, clock)
