"""What the conditions of one set-up share."""

from __future__ import annotations

import numpy as np

from model.measurements import Condition, TimeSeries

# configuration, position (inf: free), mounting, run, tilt of the rig
RunKey = tuple[str, float, int, int, float]


def run_key(condition: Condition | TimeSeries) -> RunKey:
    """Return the key that all conditions of one set-up share."""
    position = np.inf if condition.position_m is None else condition.position_m
    # a series does not say how the rig was tilted
    tilt_rad = condition.tilt_rad if isinstance(condition, Condition) else 0.0
    return condition.configuration, float(position), condition.mounting, condition.run, tilt_rad
