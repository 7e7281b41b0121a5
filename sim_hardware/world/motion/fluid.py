"""What air or water adds to the sheet's mass, and how it drags.

The hydrodynamic function of a thin blade that vibrates across its width: Sader, J. Appl. Phys. 84,
64 (1998), equations 20 to 22, good to 0.1 %; the quadratic drag of a plate across a stream.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Literal

import numpy as np

Fluid = Literal["none", "air", "water"]

_DENSITY_VISCOSITY = {"air": (1.2, 1.82e-5), "water": (998.0, 1.0e-3)}  # at 20 degrees C
_PLATE = 2.0  # drag coefficient of a plate across a stream
_REAL = (
    (0.91324, -0.48274, 0.46842, -0.12886, 0.044055, -0.0035117, 0.00069085),
    (1.0, -0.56964, 0.48690, -0.13444, 0.045155, -0.0035862, 0.00069085),
)
_IMAGINARY = (
    (-0.024134, -0.029256, 0.016294, -0.00010961, 0.000064577, -0.000044510),
    (1.0, -0.59702, 0.55182, -0.18357, 0.079156, -0.014369, 0.0028361),
)


@dataclass(frozen=True, kw_only=True)
class Immersion:
    """Per length of sheet; see `motion.links.Links`."""

    added_kg_per_m: float = 0.0
    normal_Ns_per_m2: float = 0.0
    quadratic_Ns2_per_m3: float = 0.0


def hydrodynamic(reynolds: float) -> complex:
    """Sader's function of a blade; `reynolds` = rho omega w^2 / (4 viscosity)."""
    from scipy.special import kv

    root = np.sqrt(1j * reynolds)
    circle = 1 + 4j * kv(1, -1j * root) / (root * kv(0, -1j * root))
    tau = math.log10(reynolds)
    parts = [np.polynomial.polynomial.polyval(tau, c) for c in (*_REAL, *_IMAGINARY)]
    return complex(circle * (parts[0] / parts[1] + 1j * parts[2] / parts[3]))


def immersion(fluid: Fluid, width_m: float, omega_rad_per_s: float) -> Immersion:
    """Return what a fluid does to a sheet of this width that swings at about this frequency."""
    if fluid == "none":
        return Immersion()
    density, viscosity = _DENSITY_VISCOSITY[fluid]
    moved = math.pi / 4 * density * width_m**2
    reynolds = density * omega_rad_per_s * width_m**2 / (4 * viscosity)
    gamma = hydrodynamic(reynolds)
    return Immersion(
        added_kg_per_m=moved * gamma.real,
        normal_Ns_per_m2=moved * omega_rad_per_s * gamma.imag,
        quadratic_Ns2_per_m3=density * _PLATE * width_m / 2,
    )
