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
from model.dynamics.dynamic_sheet import DynamicSheet, LoadCellResonance, PronyTerm
from model.dynamics.energy_balance import Energy, energy
from model.dynamics.fluid import VACUUM, FluidLoad, fluid_load, hydrodynamic_function
from model.dynamics.line import ElectrodeLine, LineModes
from model.dynamics.linearised import SmallMotion, linearise
from model.dynamics.material import Viscoelasticity
from model.dynamics.motion import Resolution, SheetMotion, Simulation, simulate

__all__ = [
    "NO_ELONGATION",
    "UNDRIVEN",
    "VACUUM",
    "ClampTurn",
    "ContactSetup",
    "DynamicBeam",
    "DynamicSheet",
    "ElectrodeLine",
    "Elongation",
    "Energy",
    "FluidLoad",
    "HeldVoltage",
    "LineModes",
    "LoadCellResonance",
    "PrescribedMoment",
    "PronyTerm",
    "Resolution",
    "SheetMotion",
    "Simulation",
    "SmallMotion",
    "Viscoelasticity",
    "energy",
    "fluid_load",
    "hydrodynamic_function",
    "linearise",
    "simulate",
]
