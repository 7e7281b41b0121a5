"""The output guard: a small process that writes 0 V when the program that drives cannot.

The program starts it before the first voltage and reports to it through a pipe. When that
pipe closes (the program has died), when heartbeats stop while the sheet is energised, or for long
within a run (it hangs), or when the sheet has been energised for too long, the guard takes the
output over, writes 0 V, reads it back and ends. `python -m drivers.guard` is the process itself.
"""

from drivers.guard.parent import Guard
from drivers.guard.settings import GuardSettings

__all__ = ["Guard", "GuardSettings"]
