"""A pseudo-random binary sequence: two voltages in an order that looks random and is known."""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import lru_cache
from typing import ClassVar

from protocols.errors import ScheduleError
from protocols.kinds.fields import count, duration, voltage
from protocols.kinds.waveform import Waveform
from protocols.planning.builder import DECIMALS

# Taps of shift registers whose sequences have the greatest length, 2^order - 1.
_TAPS = {3: (3, 2), 4: (4, 3), 5: (5, 3), 6: (6, 5), 7: (7, 6), 8: (8, 6, 5, 4), 9: (9, 5),
         10: (10, 7), 11: (11, 9)}  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class PseudoRandom(Waveform):
    """A maximum-length sequence of two voltages; each bit is held for a multiple of the writes.

    Its spectrum is flat up to about 0.4/bit_s. It begins with the register full of ones.
    """

    name: ClassVar[str] = "pseudo_random"

    high_V: float = voltage(1.0, "of a one")
    low_V: float = voltage(-1.0, "of a zero")
    bit_s: float = duration(0.2, "of one bit, a multiple of write_every_s")
    order: int = field(
        default=6,
        metadata={
            "ge": min(_TAPS),
            "le": max(_TAPS),
            "description": "the sequence has 2^order - 1 bits",
        },
    )
    sequences: int = count(1, "one after the other", at_least=1, repeats=True)

    def check(self) -> None:
        """Raise ScheduleError unless bits are whole numbers of writes, and not too many."""
        writes = self.bit_s / self.write_every_s
        if round(writes) < 1 or abs(writes - round(writes)) > 10.0 ** -(DECIMALS - 3):
            raise ScheduleError(
                f"bit_s = {self.bit_s:g} s must be a multiple of write_every_s = "
                f"{self.write_every_s:g} s"
            )
        if self.high_V == self.low_V:
            raise ScheduleError("high_V and low_V are the same: that is no sequence")
        self.require_length()

    @property
    def length_s(self) -> float:
        """See `Waveform.length_s`."""
        return self.sequences * ((1 << self.order) - 1) * self.bit_s

    def value_V(self, time_s: float) -> float:
        """See `Waveform.value_V`."""
        bits = sequence(self.order)
        return self.high_V if bits[int(time_s / self.bit_s) % len(bits)] else self.low_V


@lru_cache(maxsize=16)
def sequence(order: int) -> tuple[bool, ...]:
    """Return one maximum-length sequence."""
    register = [True] * order
    bits = []
    for _ in range(2**order - 1):
        bits.append(register[-1])
        fed = sum(register[tap - 1] for tap in _TAPS[order]) % 2 == 1
        register = [fed, *register[:-1]]
    return tuple(bits)


PROTOCOL = PseudoRandom
