"""The faults of the simulated camera, by frame number."""

from __future__ import annotations

from collections.abc import Container, Iterator
from dataclasses import dataclass, field

FOREVER = 1 << 62


def from_frame(first: int) -> range:
    """All frames from this one on."""
    return range(first, FOREVER)


@dataclass(frozen=True, kw_only=True)
class FaultSpan:
    """A fault of the frames that are taken within a time."""

    what: str  # such as `drop`
    from_s: float
    until_s: float
    late_s: float = 0.0  # of `late`


@dataclass(kw_only=True)
class CameraFaults:
    """The faults of frames; may be changed while the camera runs.

    Any container of frame numbers will do: a set, a range, `from_frame(100)`. Frames are numbered
    from 0, in the order in which the camera takes them, lost ones too.
    """

    drop: Container[int] = ()
    """Never arrive. After `from_frame(n)` a reader waits for its time-out: a camera that hangs."""
    late: Container[int] = ()
    """Arrive `late_s` after their time."""
    late_s: float = 0.1
    freeze: Container[int] = ()
    """Show again the last image that was not frozen."""
    black: Container[int] = ()
    """Show nothing at all."""
    wrong_size: Container[int] = ()
    """Come with half the rows and columns."""
    gone: Container[int] = ()
    """The camera is unplugged; one such frame ends the stream for good."""
    spans: list[FaultSpan] = field(default_factory=list)
    """The same by time; each acts, also where several of one kind overlap."""

    def strike(self, what: str, number: int, time_s: float) -> bool:
        """Return whether a frame suffers from this."""
        numbers: Container[int] = getattr(self, what)
        return number in numbers or any(self._spans_at(what, time_s))

    def delay_s(self, number: int, time_s: float) -> float:
        """Return how late a frame arrives: delays of several faults add up."""
        by_number = self.late_s if number in self.late else 0.0
        return by_number + sum(span.late_s for span in self._spans_at("late", time_s))

    def _spans_at(self, what: str, time_s: float) -> Iterator[FaultSpan]:
        of_this_kind = (span for span in self.spans if span.what == what)
        return (span for span in of_this_kind if span.from_s <= time_s < span.until_s)
