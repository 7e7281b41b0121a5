"""Cameras: one kind a file (`contract` says what a kind is)."""

from drivers.cameras.contract import (
    CAMERAS,
    CameraKind,
    CameraSettings,
    SoftwareTrigger,
    kind_of_source,
)

__all__ = ["CAMERAS", "CameraKind", "CameraSettings", "SoftwareTrigger", "kind_of_source"]
