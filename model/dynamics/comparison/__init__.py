"""Models of the sheet in time, fitted to the same runs and compared on others."""

from model.dynamics.comparison.compared_run import QUANTITIES, ComparedRun, Quantity
from model.dynamics.comparison.contender import Contender, FullContender, PublishedContender
from model.dynamics.comparison.hold_out import HeldOut, hold_out
from model.dynamics.comparison.model_fit import FittedModel, fit_model
from model.dynamics.comparison.rows import ComparisonRow, Score, compare_models

__all__ = [
    "QUANTITIES",
    "ComparedRun",
    "ComparisonRow",
    "Contender",
    "FittedModel",
    "FullContender",
    "HeldOut",
    "PublishedContender",
    "Quantity",
    "Score",
    "compare_models",
    "fit_model",
    "hold_out",
]
