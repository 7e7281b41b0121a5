"""`simulate`: voltage in, force, current and shape out, in time."""

from model.dynamics.motion.resolution import SAME_TIME, Resolution
from model.dynamics.motion.sheet_motion import SheetMotion
from model.dynamics.motion.simulation import Simulation, simulate

__all__ = ["SAME_TIME", "Resolution", "SheetMotion", "Simulation", "simulate"]
