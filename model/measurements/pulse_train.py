"""The paper's pulse train, at one place.

A prediction stands for a run of it, and readings without times are taken to be of it. What takes
its course in a pulse or in a run is stated for one of these lengths, whatever was measured.
"""

from __future__ import annotations

PULSE_S, SAMPLE_S = 0.6, 0.5  # length of a pulse, and when it is sampled after its edge
ZEROS, PULSES, DISCARDED = 10, 22, 2  # readings at 0 V, pulses after them, the first of these
DRIVEN_S = 13.2  # under voltage in a run
