"""Where a job is, by its messages: what computes beside pulses in real time makes them late."""

from __future__ import annotations

from labrig.panel.live.event_stream import Message


class RunPhase:
    """Follows one job; made anew for each."""

    def __init__(self) -> None:
        self._in_real_time = False
        self.begun = False  # the rig is ready: a run goes on, or somebody is asked for something
        self.pulses = False  # that others must not disturb

    def take(self, message: Message) -> None:
        """Follow a message of the job."""
        kind = message["type"]
        if kind == "plan":
            self._in_real_time = message["clock"] == "real"
        elif kind == "prompt":
            self.begun = True
        elif kind == "run_started":
            self.begun, self.pulses = True, self._in_real_time
        elif kind in ("run_stopped", "ended"):
            self.pulses = False
