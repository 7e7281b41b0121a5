"""The faults of the simulated camera, by frame number."""

from __future__ import annotations

from collections.abc import Container
from dataclasses import dataclass, field

FOREVER = 1 << 62


def from_frame(first: int) -> range:
    """All frames from this one on."""
    return range(first, FOREVER)


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
    spans: dict[str, tuple[float, float]] = field(default_factory=dict)
    """The same by time: what, such as `drop`, and from when until when frames are taken so."""

    def strike(self, what: str, number: int, time_s: float) -> bool:
        """Return whether a frame suffers from this."""
        numbers: Container[int] = getattr(self, what)
        from_s, until_s = self.spans.get(what, (0.0, 0.0))
        return number in numbers or from_s <= time_s < until_s
