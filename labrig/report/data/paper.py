"""The numbers that the paper's text states, for comparison with a session.

A mechanical model of an IPMC actuator with non-uniform bending at large deflections: tables 3, 5
and 6, and section 4.3. What it calls the long and the short sheet are its configurations.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass


@dataclass(frozen=True, kw_only=True)
class Quoted:
    """One configuration of the paper."""

    free_length_mm: float
    clamped_length_mm: float
    width_mm: float
    thickness_mm: float
    rest_position_mm: float  # of the load cell, undriven
    # (varying, constant) EIBM
    curve_rmse_at_0_mm: tuple[float, float]  # table 5: at +2 V, position 0
    curve_rmse_mm: tuple[float, float]  # table 6
    force_rmse_mN: tuple[float, float]


PAPER: Mapping[str, Quoted] = {
    "long": Quoted(
        free_length_mm=50.0,
        clamped_length_mm=1.5,
        width_mm=11.0,
        thickness_mm=0.21,
        rest_position_mm=15.0,
        curve_rmse_at_0_mm=(0.44, 2.23),
        curve_rmse_mm=(0.81, 2.13),
        force_rmse_mN=(0.322, 0.622),
    ),
    "short": Quoted(
        free_length_mm=4.5,
        clamped_length_mm=3.5,
        width_mm=11.0,
        thickness_mm=0.21,
        rest_position_mm=5.0,
        curve_rmse_at_0_mm=(0.05, 0.09),
        curve_rmse_mm=(0.13, 0.18),
        force_rmse_mN=(0.424, 0.422),
    ),
}
