"""Report how much of the measurements the dynamics of a model explained."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from model.measurements import in_digits


@dataclass(frozen=True, kw_only=True)
class DynamicsTaken:
    """What the dynamics of one configuration explain, root mean squares; NaN: not measured."""

    force_N: float  # of readings
    curve_m: float  # of the visible end, where the load cell touches
    free_m: float  # of the visible end of free shapes
    # mean along the sheet that the stated dynamics make at the instants of readings, by voltage
    eibm_Nm: Mapping[float, float] = field(default_factory=dict)

    def to_json(self) -> dict[str, Any]:
        """Return its object in a diagnosis; what was not measured is null."""
        numbers = {
            "force_rms_mN": self.force_N, "curve_end_rms_mm": self.curve_m,
            "free_end_rms_mm": self.free_m,
        }  # fmt: skip
        return {k: 1e3 * float(v) if np.isfinite(v) else None for k, v in numbers.items()}

    @property
    def sentence(self) -> str:
        """Return how much it is, without a full stop."""
        parts = [
            f"{in_digits(size, 2)} {unit} of {what}"
            for what, size, unit in (
                ("forces", 1e3 * self.force_N, "mN"),
                ("the end of curves", 1e3 * self.curve_m, "mm"),
                ("the end of free shapes", 1e3 * self.free_m, "mm"),
            )
            if np.isfinite(size)
        ]
        return f"{', '.join(parts)} (RMS, in motion less at rest)"
