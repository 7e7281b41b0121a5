"""From images to the sheet's neutral curve, and the camera's calibration."""

from labrig.vision.batch import BatchOptions, BatchResult, extract_curves
from labrig.vision.board import Board, write_board_pdf
from labrig.vision.calibration import Calibration, calibrate_camera, calibrate_ruler
from labrig.vision.compare import (
    Comparison,
    FrameAverage,
    average_of_frames,
    compare_with_frames,
)
from labrig.vision.contact import contact_from_picture
from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extract import neutral_curve
from labrig.vision.files import curve_json, load_strip, read_image, write_overlay
from labrig.vision.optics import Look, Optics, load_optics
from labrig.vision.tracker import Tracker

__all__ = [
    "BatchOptions",
    "BatchResult",
    "Board",
    "Calibration",
    "Comparison",
    "FrameAverage",
    "Look",
    "NeutralCurve",
    "Optics",
    "StripGeometry",
    "Tracker",
    "average_of_frames",
    "calibrate_camera",
    "calibrate_ruler",
    "compare_with_frames",
    "contact_from_picture",
    "curve_json",
    "extract_curves",
    "load_optics",
    "load_strip",
    "neutral_curve",
    "read_image",
    "write_board_pdf",
    "write_overlay",
]
