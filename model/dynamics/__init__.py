"""The sheet in time: mass, loss, fluid, electrodes, contact."""

from model.dynamics.beam import (
    NO_ELONGATION,
    UNDRIVEN,
    ClampTurn,
    ContactSetup,
    DynamicBeam,
    Elongation,
    HeldVoltage,
    PrescribedMoment,
)
from model.dynamics.fluid import AIR, VACUUM, FluidLoad, fluid_load, hydrodynamic_function
from model.dynamics.line import ElectrodeLine, LineModes
from model.dynamics.material import Viscoelasticity
from model.dynamics.motion import Resolution, SheetMotion, Simulation, simulate

__all__ = [
    "AIR",
    "NO_ELONGATION",
    "UNDRIVEN",
    "VACUUM",
    "ClampTurn",
    "ContactSetup",
    "DynamicBeam",
    "ElectrodeLine",
    "Elongation",
    "FluidLoad",
    "HeldVoltage",
    "LineModes",
    "PrescribedMoment",
    "Resolution",
    "SheetMotion",
    "Simulation",
    "Viscoelasticity",
    "fluid_load",
    "hydrodynamic_function",
    "simulate",
]
