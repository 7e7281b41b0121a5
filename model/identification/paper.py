"""Identification exactly as in the paper: (7) B, (8) EIBM along the sheet, (9) constant EIBM.

Each condition is taken by itself: from its curve come the contact, its tangential angle and the
moment of the measured force. `fit` does the same jointly; this is kept beside it for comparison.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.identification.data.curve_smoothing import SmoothCurve, touch
from model.identification.observations import Observation, Observed
from model.measurements import FloatArray, ModelError
from model.mechanics.field import Field
from model.mechanics.free_shape import free_shape


@dataclass(frozen=True, kw_only=True)
class Sample:
    """What one condition says by itself."""

    observation: Observation
    curve: SmoothCurve
    N_N: float
    s_hat_m: float
    l_hat_m: float
    turn_rad: float  # alpha_hat - alpha_hat0
    mean_moment_Nm: float  # (3)
    B_Nm2: float  # (7) for this condition; NaN where it is left out
    weight: float
    lever_m: tuple[FloatArray, FloatArray]  # s and (p_hat - r(s)).t_hat

    def moment_Nm(self, s_m: FloatArray) -> FloatArray:
        """M(s) of the measured force."""
        inside = np.interp(s_m, *self.lever_m)
        return np.where(s_m <= self.s_hat_m, -self.N_N * inside, 0.0)


@dataclass(frozen=True, kw_only=True)
class PaperFit:
    """The paper's Tables 4 and figure 8 for one configuration."""

    configuration: str
    samples: tuple[Sample, ...]
    B_Nm2: float
    B_sigma_Nm2: float  # from the scatter between positions
    eibm_Nm: dict[float, float]  # (9), mean over positions
    eibm_sigma_Nm: dict[float, float]
    s_m: FloatArray
    eibm_along_Nm: dict[float, FloatArray]  # (8), mean over positions


def identify(observed: Observed, rest: Field, weight_exponent: float = 1.0) -> PaperFit:
    """(7), (8) and (9) of one configuration; k0 is `rest`."""
    name = observed.sheet.configuration
    samples = [
        loaded(observed, o, rest, weight_exponent)
        for o in observed.touching()
        if o.curve is not None and np.isfinite(o.force_N)
    ]
    at_rest = [s for s in samples if s.observation.voltage_V == 0.0 and np.isfinite(s.B_Nm2)]
    if not at_rest:
        raise ModelError(
            f"configuration '{name}': (7) needs force and curve at 0 V away from the rest position"
        )
    weights = np.array([s.weight for s in at_rest])
    each = np.array([s.B_Nm2 for s in at_rest])
    B = float(weights @ each / weights.sum())
    if B <= 0.0:
        raise ModelError(
            f"configuration '{name}': (7) gives a negative stiffness; the forces have the opposite"
            " sign of what the shapes say (check the signs of the forces and of the curves, and"
            " the arc's origin)"
        )
    share = weights / weights.sum()
    degrees = max(len(each) - 1, 1)
    sigma = float(np.sqrt(np.sum(share**2 * (each - B) ** 2) * (degrees + 1) / degrees))
    s_m = np.linspace(0.0, observed.sheet.free_length_m, 51)
    constant, constant_sigma, along = {}, {}, {}
    for voltage in observed.voltages_V:
        here = [s for s in samples if s.observation.voltage_V == voltage]
        if not here:
            continue
        values = np.array([B * s.turn_rad / s.l_hat_m - s.mean_moment_Nm for s in here])
        constant[voltage], constant_sigma[voltage] = _mean(values)
        curves = [B * (s.curve.curvature(s_m) - rest(s_m)) - s.moment_Nm(s_m) for s in here]
        along[voltage] = np.mean(curves, axis=0)
    return PaperFit(
        configuration=name, samples=tuple(samples), B_Nm2=B, B_sigma_Nm2=sigma, eibm_Nm=constant,
        eibm_sigma_Nm=constant_sigma, s_m=s_m, eibm_along_Nm=along,
    )  # fmt: skip


def loaded(observed: Observed, o: Observation, rest: Field, exponent: float) -> Sample:
    """Return the evaluation of a single condition; `exponent` is q of (7)."""
    sheet = observed.sheet
    curve = observed.smoothed(o)
    at = touch(curve, sheet, o.name)
    N = o.force_N / np.cos(at.phi_hat_rad - at.polar_rad)  # (5)
    l_hat = min(at.s_hat_m, sheet.free_length_m)
    s = np.linspace(0.0, l_hat, 201)
    x, y, _ = free_shape(curve.curvature, s)
    lever = (at.x_m - x) * np.cos(at.phi_hat_rad) + (at.y_m - y) * np.sin(at.phi_hat_rad)
    mean_lever = float(np.trapezoid(lever, s) / l_hat)
    turn = float(curve.curvature.integral(l_hat)) - float(rest.integral(l_hat))
    moment = -N * mean_lever
    noise = np.sqrt(max(np.nan_to_num(o.force_variance_N2), 0.0) / max(o.readings, 1))
    sigma = max(noise * mean_lever, 1e-12)
    fixes = o.voltage_V == 0.0 and abs(moment) > sigma and turn != 0.0
    return Sample(
        observation=o, curve=curve, N_N=float(N), s_hat_m=at.s_hat_m, l_hat_m=l_hat, turn_rad=turn,
        mean_moment_Nm=moment, B_Nm2=l_hat * moment / turn if fixes else np.nan,
        weight=abs(moment) ** exponent if fixes else 0.0, lever_m=(s, lever),
    )  # fmt: skip


def _mean(values: FloatArray) -> tuple[float, float]:
    """Mean over positions and its standard uncertainty from their scatter."""
    if len(values) == 1:
        return float(values[0]), np.nan
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values)))
