"""How often the run loop looks at what, and how long it acquires before and after a run."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class LoopTiming:
    """Times of the loop, s."""

    service_s: float = 0.025  # between two looks at signals, frames, stop request; also the beat
    least_margin_s: float = 0.005  # no service this close before an edge...
    most_margin_s: float = 0.04  # ... nor this close, however long the last services took
    edge_first_s: float = 0.001  # no trigger of the camera this close before an edge
    lead_in_s: float = 0.2  # acquisition before the first step
    tail_s: float = 0.2  # and after the last
    frame_grace_s: float = 0.3  # a frame may arrive this much later than it was taken
    starved_s: float = 2.0  # an input silent for so long has failed
