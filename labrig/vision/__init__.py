"""From images to the sheet's neutral curve, and the camera's calibration."""

from labrig.vision.curve import NeutralCurve, StripGeometry
from labrig.vision.extract import neutral_curve
from labrig.vision.optics import Optics, load_optics

__all__ = ["NeutralCurve", "Optics", "StripGeometry", "load_optics", "neutral_curve"]
