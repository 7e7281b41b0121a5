"""The sheets of the reference numbers (tests/data/reference/dynamics)."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import numpy as np
from numpy.polynomial import legendre

from model.dynamics import DynamicBeam, ElectrodeLine, FluidLoad, HeldVoltage, Viscoelasticity
from model.mechanics.field import Field
from model.mechanics.tip_load import tip_load

REFERENCE = Path(__file__).parents[2] / "data" / "reference"
B, MU, L, R = 1.27e-6, 5.775e-3, 0.05, 0.04
LINE = ElectrodeLine(
    electrode_ohm_per_m=4000.0, capacitance_F_per_m=0.3, bulk_ohm_m=0.5, leak_S_per_m=0.1
)
AIR = FluidLoad(added_mass_kg_per_m=1.2e-4, quadratic_Ns2_per_m3=0.013)
STRAIGHT = Field.constant(0.0, L)
CURVED = Field.smooth(lambda s: 24.0 * np.exp(-s / 0.04), L)
PULSES = HeldVoltage(np.array([0.1, 0.7]), np.array([2.0, -2.0]))


def table(name: str) -> Any:
    """A reference table as a record array; an empty field is NaN."""
    return np.genfromtxt(REFERENCE / "dynamics" / name, delimiter=",", names=True)


def material(prony: bool = True, eta: float = 2e-4) -> Viscoelasticity:
    shares, times = ((0.15, 0.10), (0.02, 0.3)) if prony else ((), ())
    return Viscoelasticity(B_Nm2=B, shares=shares, times_s=times, viscous_time_s=eta)


def plain(rest: Field = STRAIGHT, **other: Any) -> DynamicBeam:
    """The sheet without electrodes and loss."""
    given: dict[str, Any] = {
        "length_m": L, "mass_per_length_kg_per_m": MU, "material": material(False, 0.0),
        "rest": rest,
    }  # fmt: skip
    return DynamicBeam(**(given | other))


def driven(rest: Field = CURVED, **other: Any) -> DynamicBeam:
    """The sheet with electrodes and loss."""
    given: dict[str, Any] = {
        "material": material(), "electrodes": LINE, "moment_per_volt_Nm": (30.0 * B, 30.0 * B)
    }  # fmt: skip
    return plain(rest, **(given | other))


def under_tip_load() -> Field:
    """Curvature of the straight sheet under the dead load F l^2/B = 3 across its tip."""
    from scipy.interpolate import BarycentricInterpolator

    load = 3.0 / L**2
    held = tip_load(STRAIGHT, (0.0, load), follows=False)
    order = np.argsort(held.s_m)
    x = BarycentricInterpolator(held.s_m[order], held.x_m[order])
    return Field.smooth(lambda s: load * (held.tip_x_m - x(s)), L)


def arc_moment(t: np.ndarray, s: np.ndarray) -> np.ndarray:
    """The moment Me(s, t) under which the straight, lossless sheet moves with k = 40 cos 30 t.

    Me = B k + mu int_s^l (r(u) - r(s)) x r_tt(u) du, with phi = k u.
    """
    t, s = t.reshape(-1, 1, 1, 1), s.reshape(1, -1, 1, 1)
    k, spin, swing = 40.0 * np.cos(30.0 * t), -1200.0 * np.sin(30.0 * t), -36e3 * np.cos(30.0 * t)
    x, w = legendre.leggauss(24)
    share, w = 0.5 * (x + 1.0), 0.5 * w
    u = s + (L - s) * share[:, None]  # (1, S, 24, 1)
    v = u * share
    ax = np.sum(u * w * (-np.sin(k * v) * swing * v - np.cos(k * v) * (spin * v) ** 2), axis=-1)
    ay = np.sum(u * w * (np.cos(k * v) * swing * v - np.sin(k * v) * (spin * v) ** 2), axis=-1)
    v = s + (u - s) * share
    rx = np.sum((u - s) * w * np.cos(k * v), axis=-1)
    ry = np.sum((u - s) * w * np.sin(k * v), axis=-1)
    inertia = np.sum((L - s[..., 0]) * w * (rx * ay - ry * ax), axis=-1)
    return B * k[:, :, 0, 0] + MU * inertia
