"""What recorded motions say about the sheet: its parameters, each with an interval, or that not."""

from model.dynamics.identification.fit import (
    Identification,
    NotConvergedError,
    best_sheet,
    identify,
)
from model.dynamics.identification.information import expected, information, information_matrix
from model.dynamics.identification.noise import ChannelNoise, RecordingNoise
from model.dynamics.identification.runs import RecordedRun, RunPlan
from model.dynamics.identification.uncertainty import DynamicParameter

__all__ = [
    "ChannelNoise",
    "DynamicParameter",
    "Identification",
    "NotConvergedError",
    "RecordedRun",
    "RecordingNoise",
    "RunPlan",
    "best_sheet",
    "expected",
    "identify",
    "information",
    "information_matrix",
]
