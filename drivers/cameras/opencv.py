"""Any camera that OpenCV opens: V4L2, DirectShow, network streams, files."""

from __future__ import annotations

from drivers.cameras.capture_camera import CaptureCamera
from drivers.cameras.contract import CameraKind, CameraSettings
from drivers.interfaces import Camera, Clock


def _make(settings: CameraSettings, clock: Clock, _rate_hz: float) -> Camera:
    return CaptureCamera(settings.source, clock)  # its sources run at a rate of their own


CAMERA = CameraKind(
    kind="opencv",
    help="anything OpenCV opens: a number, a device path, a file or a URL",
    make=_make,
)
