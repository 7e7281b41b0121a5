"""Faults that a test can switch on while the server runs."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(kw_only=True)
class Faults:
    """The faults of the server; all are off until they are set. Fields may be set at any time."""

    delay_s: float = 0.0  # every call takes this much longer
    hang: set[str] = field(default_factory=set)  # calls that never answer; "*": all
    unavailable: bool = False  # the server does not answer
    refuse: dict[str, int] = field(default_factory=dict)  # call: the status code it fails with
    lose_after_reads: int | None = None  # so many more reads, and samples are lost (-200279)
    underflow: bool = False  # clocked outputs get no samples any more, and keep their volts
    nan: set[str] = field(default_factory=set)  # inputs that read NaN, such as PCI6034E/ai0
    stuck_outputs: set[str] = field(default_factory=set)  # confirm a write, and keep their volts

    def hangs(self, method: str) -> bool:
        """Return whether this call never answers."""
        return method in self.hang or "*" in self.hang

    def loses_samples(self) -> bool:
        """Count a read; whether it is one that has lost samples."""
        if self.lose_after_reads is None:
            return False
        self.lose_after_reads -= 1
        return self.lose_after_reads < 0
