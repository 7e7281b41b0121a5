"""The neutral curve, the strip's geometry and the curve's parametrisation."""

from labrig.vision.curve.neutral import FindCurve, NeutralCurve, StripGeometry, smallness

__all__ = ["FindCurve", "NeutralCurve", "StripGeometry", "smallness"]
