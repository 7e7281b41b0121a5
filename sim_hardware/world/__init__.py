"""The simulated sheet with all that surrounds it: amplifier, water, rolls, load cell, camera."""

from sim_hardware.world.load_cell import CellFault
from sim_hardware.world.loading import WorldError, load_world
from sim_hardware.world.reduced import (
    CurveErrors,
    ReducedCondition,
    ReducedSession,
    reduced_session,
)
from sim_hardware.world.settings import FaultSettings, WorldSettings
from sim_hardware.world.world import World

__all__ = [
    "CellFault",
    "CurveErrors",
    "FaultSettings",
    "ReducedCondition",
    "ReducedSession",
    "World",
    "WorldError",
    "WorldSettings",
    "load_world",
    "reduced_session",
]
