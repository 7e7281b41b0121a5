"""From a recorded session to measurements: forces, curves and time series."""

from labrig.analysis.analyze import analyze, measure
from labrig.analysis.curves import ConditionCurves, measure_curves
from labrig.analysis.forces import ForceReading, measure_forces
from labrig.analysis.series import time_series

__all__ = [
    "ConditionCurves",
    "ForceReading",
    "analyze",
    "measure",
    "measure_curves",
    "measure_forces",
    "time_series",
]
