"""From images to the sheet's neutral curve, and the camera's calibration.

Each name is loaded when it is first used: what only needs the optics waits for no numba.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazy_imports import lazily
from labrig.own_packages import require_own_packages

if TYPE_CHECKING:
    from labrig.vision.batch.curves import BatchResult as BatchResult
    from labrig.vision.batch.curves import extract_curves as extract_curves
    from labrig.vision.batch.options import BatchOptions as BatchOptions
    from labrig.vision.calibration.board import CalibrationBoard as CalibrationBoard
    from labrig.vision.calibration.board import write_board_pdf as write_board_pdf
    from labrig.vision.calibration.camera import Calibration as Calibration
    from labrig.vision.calibration.camera import calibrate_camera as calibrate_camera
    from labrig.vision.calibration.camera import calibrate_ruler as calibrate_ruler
    from labrig.vision.calibration.optics import Optics as Optics
    from labrig.vision.calibration.optics import SheetAppearance as SheetAppearance
    from labrig.vision.calibration.optics import load_optics as load_optics
    from labrig.vision.curve import NeutralCurve as NeutralCurve
    from labrig.vision.curve import StripGeometry as StripGeometry
    from labrig.vision.extraction.extract import neutral_curve as neutral_curve
    from labrig.vision.image.files import curve_json as curve_json
    from labrig.vision.image.files import load_strip as load_strip
    from labrig.vision.image.overlay import write_overlay as write_overlay
    from labrig.vision.image.reading import read_image as read_image
    from labrig.vision.tracking.contact import contact_from_image as contact_from_image
    from labrig.vision.tracking.frame_average import Comparison as Comparison
    from labrig.vision.tracking.frame_average import FrameAverage as FrameAverage
    from labrig.vision.tracking.frame_average import average_of_frames as average_of_frames
    from labrig.vision.tracking.frame_average import compare_with_frames as compare_with_frames
    from labrig.vision.tracking.tracker import Tracker as Tracker

_HOMES = {
    "labrig.vision.batch.curves": ("BatchResult", "extract_curves"),
    "labrig.vision.batch.options": ("BatchOptions",),
    "labrig.vision.calibration.board": ("CalibrationBoard", "write_board_pdf"),
    "labrig.vision.calibration.camera": ("Calibration", "calibrate_camera", "calibrate_ruler"),
    "labrig.vision.tracking.frame_average": (
        "Comparison", "FrameAverage", "average_of_frames", "compare_with_frames"
    ),
    "labrig.vision.tracking.contact": ("contact_from_image",),
    "labrig.vision.curve": ("NeutralCurve", "StripGeometry"),
    "labrig.vision.extraction.extract": ("neutral_curve",),
    "labrig.vision.image.files": ("curve_json", "load_strip"),
    "labrig.vision.image.overlay": ("write_overlay",),
    "labrig.vision.image.reading": ("read_image",),
    "labrig.vision.calibration.optics": ("SheetAppearance", "Optics", "load_optics"),
    "labrig.vision.tracking.tracker": ("Tracker",),
}  # fmt: skip
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES, before=require_own_packages)
