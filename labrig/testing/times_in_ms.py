"""Whether a protocol or an extra seems to state its times in milliseconds.

A long run is no fault where a rig allows it, so that the loader does not ask.
"""

from __future__ import annotations

from collections.abc import Iterable

from protocols.extras import conformance as extras
from protocols.kinds import conformance as kinds
from protocols.kinds.pulse_train import PulseTrain
from protocols.planning.builder import StepsAndReadings
from protocols.planning.limits import time_under_voltage_s

LONGEST_S = 300.0  # by default, in one run: ten times what a rig allows that states nothing else


def protocol_faults(kind: type) -> list[str]:
    """Return what is wrong with a kind of protocol, and whether its times seem to be in ms."""
    return kinds.faults(kind) or _too_long([kind().steps_and_readings()])


def extra_faults(extra: type) -> list[str]:
    """Return what is wrong with an extra, and whether its times seem to be in ms."""
    found = extras.faults(extra)
    return found or _too_long(run.parts for run in extra().runs(PulseTrain(), (0.0, 0.01)))


def _too_long(every: Iterable[StepsAndReadings]) -> list[str]:
    runs = [kinds.planned(parts) for parts in every if parts[0]]
    under_s = max((time_under_voltage_s(run) for run in runs), default=0.0)
    if under_s <= LONGEST_S:
        return []
    return [f"by default a run is {under_s:g} s under voltage: are its times in ms, not in s?"]
