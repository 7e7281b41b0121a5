"""Simulated families of boards: one file each, and those of other distributions."""

from sim_hardware.families.contract import FOLDER, BoardOptions, SimulatedBoards, SimulatedFamily

__all__ = ["FOLDER", "BoardOptions", "SimulatedBoards", "SimulatedFamily"]
