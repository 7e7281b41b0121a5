"""The frames of a free-running camera: when each is there, and what is in it."""

from __future__ import annotations

import threading

import numpy as np
import numpy.typing as npt

from sim_hardware.camera.faults import CameraFaults
from sim_hardware.simulated_rig import OpticalSide

Image = npt.NDArray[np.uint8]


TRANSFER_S = 2e-3  # from the end of an exposure to the frame's arrival, where it was triggered


class FrameStream:
    """Frame k's exposure ends at start + (k + 1) / rate; jitter and faults are added to that."""

    def __init__(
        self, scene: OpticalSide, start_s: float, faults: CameraFaults, jitter_s: float = 0.0
    ) -> None:
        self.scene = scene
        self.faults = faults
        self.start_s = start_s
        self.period_s = 1 / scene.frame_rate_hz
        self._jitter_s = jitter_s
        self._lock = threading.Lock()
        self._last_good: Image | None = None

    def time_of(self, number: int) -> float:
        """Clock time at which the frame's exposure ends; jitter only delays."""
        time_s = self.start_s + (number + 1) * self.period_s
        if self._jitter_s:
            time_s += float(np.random.default_rng((number, 0xCA3)).uniform(0, self._jitter_s))
        return time_s

    def arrival_of(self, number: int) -> float:
        """Clock time at which the frame can be read."""
        time_s = self.time_of(number)
        return time_s + self.faults.delay_s(number, time_s)

    def suffers(self, what: str, number: int) -> bool:
        """Return whether the frame has this fault."""
        return self.faults.strike(what, number, self.time_of(number))

    def latest_at(self, when_s: float) -> int:
        """Return the number of the last frame whose nominal time has passed; -1 before it."""
        # A frame whose time is just now counts, whatever the last bit of the division is.
        return int((when_s - self.start_s) / self.period_s + 1e-6) - 1

    def image(self, number: int) -> Image:
        """Return the frame (rows, columns) as it arrives."""
        if self.suffers("black", number):
            return np.zeros(self.scene.frame_shape, dtype=np.uint8)
        with self._lock:
            if self.suffers("freeze", number) and self._last_good is not None:
                image = self._last_good
            else:
                image = self.scene.image(self.time_of(number), number)
                self._last_good = image
        if self.suffers("wrong_size", number):
            image = image[::2, ::2]
        return image.copy()


class TriggeredStream(FrameStream):
    """Frames whose exposures begin when they are triggered.

    A trigger that comes during an exposure is ignored.
    """

    def __init__(
        self, scene: OpticalSide, start_s: float, faults: CameraFaults, exposure_s: float
    ) -> None:
        super().__init__(scene, start_s, faults)
        self._exposure_s = exposure_s
        self._ends_s: list[float] = []

    def trigger(self, when_s: float) -> None:
        """Begin an exposure."""
        if not self._ends_s or when_s >= self._ends_s[-1]:
            self._ends_s.append(when_s + self._exposure_s)

    @property
    def taken(self) -> int:
        """Return how many exposures have begun."""
        return len(self._ends_s)

    def time_of(self, number: int) -> float:
        """See `FrameStream.time_of`."""
        return self._ends_s[number]

    def arrival_of(self, number: int) -> float:
        """See `FrameStream.arrival_of`."""
        return super().arrival_of(number) + TRANSFER_S
