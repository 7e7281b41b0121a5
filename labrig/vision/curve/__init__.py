"""The neutral curve: what goes in beside the image, what comes out, and its parametrisation."""

from labrig.vision.curve.neutral import FindCurve, NeutralCurve, StripGeometry, smallness

__all__ = ["FindCurve", "NeutralCurve", "StripGeometry", "smallness"]
