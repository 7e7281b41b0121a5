"""What the simulated board is told while something runs."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager

from sim_hardware.world import World

Write = tuple[float, float]  # clock time in s, volts of the board


@contextmanager
def spied_output() -> Iterator[list[Write]]:
    """Yield the writes as they come."""
    writes: list[Write] = []
    real = World.write

    def write(self: World, device: str, channel: str, volts: float, when: float) -> None:
        if channel == "ao0":
            writes.append((when, volts))
        real(self, device, channel, volts, when)

    World.write = write  # type: ignore[method-assign]
    try:
        yield writes
    finally:
        World.write = real  # type: ignore[method-assign]


def highest_V(writes: list[Write]) -> float:
    """Return the largest voltage of the board, either sign."""
    return max((abs(volts) for _, volts in writes), default=0.0)


def under_voltage_s(writes: list[Write]) -> float:
    """Return the longest time without 0 V: from a first voltage to the next 0 V, or to the end."""
    longest_s, since_s = 0.0, None
    for when, volts in writes:
        if since_s is None:
            since_s = when if volts else None
            continue
        longest_s = max(longest_s, when - since_s)
        if not volts:
            since_s = None
    return longest_s
