"""What is looked at around a run: who is left to write 0 V, and whether this computer keeps up."""

from labrig.experiment.precautions.checks import precautions

__all__ = ["precautions"]
