"""The simulated sheet with all that surrounds it: amplifier, water, rolls, load cell, camera."""

from sim_hardware.world.curve_noise import CurveErrors
from sim_hardware.world.loading import WorldError, load_world
from sim_hardware.world.reduced import (
    ReducedCondition,
    ReducedSession,
    reduced_session,
)
from sim_hardware.world.settings import FaultSettings, WorldSettings
from sim_hardware.world.setup import Scatter
from sim_hardware.world.signals.load_cell import CellFault
from sim_hardware.world.timed import TimedReading, TimedRun, Train, Visit, each_after, timed_session
from sim_hardware.world.world import World

__all__ = [
    "CellFault",
    "CurveErrors",
    "FaultSettings",
    "ReducedCondition",
    "ReducedSession",
    "Scatter",
    "TimedReading",
    "TimedRun",
    "Train",
    "Visit",
    "World",
    "WorldError",
    "WorldSettings",
    "each_after",
    "load_world",
    "reduced_session",
    "timed_session",
]
