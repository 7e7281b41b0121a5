"""Faults of a simulated LabJack that a test can switch on while it runs."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(kw_only=True)
class LabJackFaults:
    """All are off until they are set. Fields may be set at any time."""

    unavailable: bool = False  # nobody answers at its address
    hang: bool = False  # it takes every request and answers none
    hang_stream: bool = False  # the same of requests for the stream's data
    delay_s: float = 0.0  # every answer takes this much longer
    refuse_outputs: bool = False  # it refuses to write an output
    garbage: bool = False  # its answers belong to other requests
    lose_samples: bool = False  # the stream's buffer overflows
    stuck: bool = False  # outputs confirm a write, and keep their volts
    dead_inputs: set[str] = field(default_factory=set)  # inputs whose codes are all at the end
