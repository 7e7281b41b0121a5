"""How late the edges were written."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass

import numpy as np

from drivers.interfaces import VoltageWrite
from protocols.execution.events import VoltageSet


def written_s(write: VoltageWrite) -> float:
    """Return when a write counts as done: midway between sending and confirmation, s."""
    return (write.before_s + write.after_s) / 2


def lateness_s(event: VoltageSet) -> float:
    """How much later than due an edge was written, s."""
    return written_s(event.write) - event.due_s


@dataclass(frozen=True)
class Lateness:
    """Of all the edges of a run or a session, s."""

    edges: int
    median_s: float
    percentile99_s: float
    worst_s: float


def lateness_of(events: Iterable[object]) -> Lateness | None:
    """Statistics over the VoltageSet among some events; None when there is none."""
    late_s = [lateness_s(event) for event in events if isinstance(event, VoltageSet)]
    if not late_s:
        return None
    return Lateness(
        edges=len(late_s),
        median_s=float(np.median(late_s)),
        percentile99_s=float(np.percentile(late_s, 99)),
        worst_s=max(late_s),
    )
