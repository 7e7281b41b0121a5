"""Where the rolls are while the stage carries them along the arc."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

FloatArray = npt.NDArray[np.float64]

_LEAST_S = 0.02
_PEAK = 1.875  # of the speed on the way, over its mean


@dataclass(frozen=True, kw_only=True)
class Travel:
    """From one angle to another, beginning and ending without acceleration."""

    start_s: float = 0.0
    duration_s: float = _LEAST_S
    from_rad: float
    to_rad: float

    @staticmethod
    def at_most(start_s: float, from_rad: float, to_rad: float, rad_per_s: float) -> Travel:
        """Begin now, and be nowhere faster than this."""
        needed_s = _PEAK * abs(to_rad - from_rad) / rad_per_s
        return Travel(
            start_s=start_s,
            duration_s=max(_LEAST_S, needed_s),
            from_rad=from_rad,
            to_rad=to_rad,
        )

    def done(self, times: FloatArray) -> FloatArray:
        """Share of the way that is behind at some times; 1 from its end on."""
        u = np.clip((times - self.start_s) / self.duration_s, 0.0, 1.0)
        return np.asarray(np.where(u >= 1.0, 1.0, u**3 * (10.0 - 15.0 * u + 6.0 * u**2)))

    def at(self, times: FloatArray) -> FloatArray:
        """Angles at some times."""
        done = self.done(times)
        # The end is met exactly: a sheet at rest stays so.
        on_way = self.from_rad + (self.to_rad - self.from_rad) * done
        return np.asarray(np.where(done >= 1.0, self.to_rad, on_way))
