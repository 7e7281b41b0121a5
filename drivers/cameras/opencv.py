"""Any camera that OpenCV opens: V4L2, DirectShow, network streams, files."""

from __future__ import annotations

from dataclasses import dataclass, field

from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.cameras.sources import may_be_path
from drivers.interfaces import Camera, Clock


@dataclass(frozen=True, kw_only=True)
class OpenCVSettings(CameraSettings):
    """Anything OpenCV opens."""

    source: int | str = field(
        metadata={
            "description": "a number, a device, an address, or a file beside this one",
            "path": may_be_path,
        }
    )


def _make(settings: CameraSettings, clock: Clock, _rate_hz: float) -> Camera:
    return CaptureCamera(settings.source, clock)  # its sources run at a rate of their own


CAMERA = CameraKind(
    kind="opencv",
    help="anything OpenCV opens: a number, a device path, a file or a URL",
    settings=OpenCVSettings,
    make=_make,
)
