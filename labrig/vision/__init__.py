"""From images to the sheet's neutral curve, and the camera's calibration.

Each name is loaded when it is first used: what only needs the optics waits for no numba.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from labrig.lazily import lazily

if TYPE_CHECKING:
    from labrig.vision.batch import BatchOptions as BatchOptions
    from labrig.vision.batch import BatchResult as BatchResult
    from labrig.vision.batch import extract_curves as extract_curves
    from labrig.vision.board import Board as Board
    from labrig.vision.board import write_board_pdf as write_board_pdf
    from labrig.vision.calibration import Calibration as Calibration
    from labrig.vision.calibration import calibrate_camera as calibrate_camera
    from labrig.vision.calibration import calibrate_ruler as calibrate_ruler
    from labrig.vision.compare import Comparison as Comparison
    from labrig.vision.compare import FrameAverage as FrameAverage
    from labrig.vision.compare import average_of_frames as average_of_frames
    from labrig.vision.compare import compare_with_frames as compare_with_frames
    from labrig.vision.contact import contact_from_picture as contact_from_picture
    from labrig.vision.curve import NeutralCurve as NeutralCurve
    from labrig.vision.curve import StripGeometry as StripGeometry
    from labrig.vision.extract import neutral_curve as neutral_curve
    from labrig.vision.files import curve_json as curve_json
    from labrig.vision.files import load_strip as load_strip
    from labrig.vision.files import read_image as read_image
    from labrig.vision.files import write_overlay as write_overlay
    from labrig.vision.optics import Look as Look
    from labrig.vision.optics import Optics as Optics
    from labrig.vision.optics import load_optics as load_optics
    from labrig.vision.tracker import Tracker as Tracker

_HOMES = {
    "labrig.vision.batch": ("BatchOptions", "BatchResult", "extract_curves"),
    "labrig.vision.board": ("Board", "write_board_pdf"),
    "labrig.vision.calibration": ("Calibration", "calibrate_camera", "calibrate_ruler"),
    "labrig.vision.compare": (
        "Comparison", "FrameAverage", "average_of_frames", "compare_with_frames"
    ),
    "labrig.vision.contact": ("contact_from_picture",),
    "labrig.vision.curve": ("NeutralCurve", "StripGeometry"),
    "labrig.vision.extract": ("neutral_curve",),
    "labrig.vision.files": ("curve_json", "load_strip", "read_image", "write_overlay"),
    "labrig.vision.optics": ("Look", "Optics", "load_optics"),
    "labrig.vision.tracker": ("Tracker",),
}  # fmt: skip
__getattr__, __dir__, __all__ = lazily(__name__, _HOMES)
