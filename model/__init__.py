"""The mechanics of the sheet: equilibrium, identification, effects, discrepancy, design."""

from model.identification.fit import ConfigurationFit, Fit, fit
from model.identification.options import FitOptions
from model.measurements import (
    Condition,
    Curve,
    Measurements,
    ModelError,
    Reading,
    SheetGeometry,
    TimeSeries,
)
from model.parameter import Parameter
from model.sheet.configured_sheet import Along, ConfiguredSheet
from model.sheet.prediction import Prediction, predict, predict_free
from model.sheet.predictions import PredictionArray, predict_array
from model.sheet.sheet_model import SheetModel

__all__ = [
    "Along",
    "Condition",
    "ConfigurationFit",
    "ConfiguredSheet",
    "Curve",
    "Fit",
    "FitOptions",
    "Measurements",
    "ModelError",
    "Parameter",
    "Prediction",
    "PredictionArray",
    "Reading",
    "SheetGeometry",
    "SheetModel",
    "TimeSeries",
    "fit",
    "predict",
    "predict_array",
    "predict_free",
]
