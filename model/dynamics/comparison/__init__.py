"""Models of the sheet in time, fitted to the same runs and compared on others."""

from model.dynamics.comparison.measured import MeasuredRun, Noise, split_at, split_positions
from model.dynamics.comparison.model_fit import FittedModel, fit_model
from model.dynamics.comparison.rows import ComparisonRow, compare_models

__all__ = [
    "ComparisonRow",
    "FittedModel",
    "MeasuredRun",
    "Noise",
    "compare_models",
    "fit_model",
    "split_at",
    "split_positions",
]
