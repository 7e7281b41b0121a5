"""The sheet in time beside a run: motion step by step, and slow parameters estimated as it goes."""

from model.dynamics.online.grid_motion import GRID_S, Drive, GridMotion
from model.dynamics.online.run_estimator import MEAN_S, Estimate, RunEstimator

__all__ = ["GRID_S", "MEAN_S", "Drive", "Estimate", "GridMotion", "RunEstimator"]
