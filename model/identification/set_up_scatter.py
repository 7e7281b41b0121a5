"""How a new measurement would scatter about a fitted model: set-ups and noise, as the fit has them.

A parameter's uncertainty says where the model is. A measurement lies beside it: each set-up has its
own EIBM, stiffness, position, tilt, registration and zero, and each reading its noise.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.joint import Joint
from model.measurements import Curve, FloatArray

Place = tuple[float | None, float]  # position in m, None: free; voltage in V


@dataclass(frozen=True, kw_only=True)
class ConditionScatter:
    """Standard deviations of what one condition of a new set-up measures, about the model."""

    force_N: float  # of the mean of its readings; NaN: there is no force
    s_m: FloatArray  # (S,) distance from the clamp; empty: there is no curve
    curve_m: FloatArray  # (S,) along the normal


def scatter_of(joint: Joint, n: int) -> dict[Place, ConditionScatter]:
    """Return the scatter of each place that was measured with a configuration."""
    row_index, configuration_model = joint.forward.row_index, joint.forward.configuration_models[n]
    block, seen = joint.forward.row_block(n), joint.forward.data_vectors[n].seen
    covariances = np.linalg.inv(joint.fitted.solution.weights)
    means = {
        int(k): int(row)
        for k, row in zip(
            block.trend_of[block.is_mean], block.trend_rows[block.is_mean], strict=True
        )
    }

    def covariance(rows: list[int]) -> FloatArray:
        run, own = row_index.run_of[rows[0]], row_index.row_of[rows]
        return np.asarray(covariances[run][np.ix_(own, own)])

    found: dict[Place, ConditionScatter] = {}
    for k, one in enumerate(seen):
        s_m, curve_m = np.zeros(0), np.zeros(0)
        if configuration_model.has_curve[k]:
            s_m = configuration_model.measured(k)[0]
            by = np.linalg.pinv(configuration_model.project[k])[: len(s_m)]
            modes = covariance(block.mode_rows[k].tolist())
            curve_m = np.sqrt(np.einsum("sm,mn,sn->s", by, modes, by) + _points(one.curve) ** 2)
        force = np.sqrt(covariance([means[k]])[0, 0]) if k in means else np.nan
        place = None if one.free else one.position_m
        scatter = ConditionScatter(force_N=float(force), s_m=s_m, curve_m=curve_m)
        found.setdefault((place, one.voltage_V), scatter)
    return found


def _points(curve: Curve | None) -> float:
    """Return the noise of a curve's points, which its modes leave out, as it is stated."""
    return 0.0 if curve is None or curve.sigma_m is None else float(np.mean(curve.sigma_m))
