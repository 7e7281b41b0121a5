"""What the sheet is made of: linear viscoelasticity in bending.

M_i = B [(k - k0) + eta k_t + sum_i g_i (k - k0 - z_i)] - Me,   tau_i dz_i/dt = k - k0 - z_i.
B is the relaxed stiffness, B (1 + sum g_i) the instantaneous one; eta is the time of a Kelvin-Voigt
damper, g_i and tau_i are shares and times of a Prony series.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.measurements import FloatArray, ModelError


@dataclass(frozen=True, kw_only=True)
class Viscoelasticity:
    """A bending stiffness with its loss."""

    B_Nm2: float  # relaxed
    shares: tuple[float, ...] = ()  # g_i
    times_s: tuple[float, ...] = ()  # tau_i
    viscous_time_s: float = 0.0  # eta

    def __post_init__(self) -> None:
        """Refuse what no material is."""
        if not 0.0 < self.B_Nm2 < np.inf:
            raise ModelError(f"the bending stiffness must be positive, not {self.B_Nm2:g} N m^2")
        if len(self.shares) != len(self.times_s):
            raise ModelError(
                f"a Prony series needs as many times as shares, not {len(self.times_s)} times"
                f" and {len(self.shares)} shares"
            )
        if not all(0.0 < g < np.inf for g in self.shares):
            raise ModelError(f"the shares of a Prony series must be positive: {self.shares}")
        if not all(0.0 < t < np.inf for t in self.times_s):
            raise ModelError(f"the times of a Prony series must be positive: {self.times_s} s")
        if not 0.0 <= self.viscous_time_s < np.inf:
            raise ModelError(
                f"the viscous time must be zero or positive, not {self.viscous_time_s:g} s"
            )

    def complex_stiffness(self, p: complex | FloatArray) -> FloatArray:
        """Return B*(p) = B (1 + eta p + sum g_i p tau_i / (1 + p tau_i)) for exp(p t)."""
        p = np.asarray(p)
        total = 1.0 + self.viscous_time_s * p
        for share, time in zip(self.shares, self.times_s, strict=True):
            total = total + share * p * time / (1.0 + p * time)
        return np.asarray(self.B_Nm2 * total)


def relaxation(step_s: FloatArray | float, time_s: FloatArray | float) -> tuple[FloatArray, ...]:
    """Return (e, a, b) of z+ = e z + a y + b y+: exact where y is a straight line in the step.

    With x = h/tau: e = exp(-x), b = 1 - (1 - e)/x, a = 1 - e - b.
    """
    x = np.asarray(step_s) / np.asarray(time_s)
    part = -np.expm1(-x)
    small = x < 1e-3
    safe = np.where(small, 1.0, x)
    b = np.where(small, x * (0.5 - x * (1.0 / 6.0 - x / 24.0)), 1.0 - part / safe)
    return np.exp(-x), part - b, b
