"""Precautions around a run: the watch at the boards, and checks that need no device."""

from labrig.experiment.precautions.checks import precautions

__all__ = ["precautions"]
