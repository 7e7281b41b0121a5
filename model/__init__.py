"""The mechanics of the sheet: equilibrium, identification, effects, discrepancy, design.

Each name below is loaded when it is first used: who only reads measurements needs no scipy.
"""

from __future__ import annotations

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from model.identification.fit import fit
    from model.identification.fit_result import ConfigurationFit, Fit
    from model.identification.options import FitOptions
    from model.measurements import (
        CameraUncertainty,
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
    "CameraUncertainty",
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
_HOMES = {
    "Along": "sheet.configured_sheet",
    "CameraUncertainty": "measurements",
    "Condition": "measurements",
    "ConfigurationFit": "identification.fit_result",
    "ConfiguredSheet": "sheet.configured_sheet",
    "Curve": "measurements",
    "Fit": "identification.fit_result",
    "FitOptions": "identification.options",
    "Measurements": "measurements",
    "ModelError": "measurements",
    "Parameter": "parameter",
    "Prediction": "sheet.prediction",
    "PredictionArray": "sheet.predictions",
    "Reading": "measurements",
    "SheetGeometry": "measurements",
    "SheetModel": "sheet.sheet_model",
    "TimeSeries": "measurements",
    "fit": "identification.fit",
    "predict": "sheet.prediction",
    "predict_array": "sheet.predictions",
    "predict_free": "sheet.prediction",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'model' has no attribute {name!r}")
    return getattr(import_module(f"model.{_HOMES[name]}"), name)


def __dir__() -> list[str]:
    return list(__all__)
