"""The force of the surrounding air or water on the moving sheet.

f = -[m_a (r_tt . n) + c_n v_n + c_q |v_n| v_n] n - c_t v_t t per length, with v_n = r_t . n and
v_t = r_t . t. The convective part of a large motion's added mass (Candelier, Boyer & Leroyer 2011)
is left out: 3 % of the sheet's mass in air; in water it is a choice.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass

import numpy as np

from model.measurements import FloatArray, ModelError

# log10(Re) polynomials of the rectangle's correction, Sader 1998 (J. Appl. Phys. 84, 64), eq. (21).
# Public codes disagree about the last coefficient of the imaginary numerator, 0.000044510 or
# 0.000045510; it is not checked in print.
_REAL = (0.91324, -0.48274, 0.46842, -0.12886, 0.044055, -0.0035117, 0.00069085)
_REAL_BELOW = (1.0, -0.56964, 0.48690, -0.13444, 0.045155, -0.0035862, 0.00069085)
_IMAGINARY = (-0.024134, -0.029256, 0.016294, -0.00010961, 0.000064577, -0.000044510)
_IMAGINARY_BELOW = (1.0, -0.59702, 0.55182, -0.18357, 0.079156, -0.014369, 0.0028361)


@dataclass(frozen=True, kw_only=True)
class FluidLoad:
    """Coefficients per length; all zero: vacuum."""

    added_mass_kg_per_m: float = 0.0  # m_a
    normal_Ns_per_m2: float = 0.0  # c_n
    quadratic_Ns2_per_m3: float = 0.0  # c_q = density x drag coefficient x width / 2
    tangential_Ns_per_m2: float = 0.0  # c_t

    def __post_init__(self) -> None:
        """Refuse negative coefficients."""
        if not all(0.0 <= c < np.inf for c in astuple(self)):
            raise ModelError("added mass and drag of the fluid must be zero or positive")


VACUUM = FluidLoad()


def hydrodynamic_function(reynolds: FloatArray | float, *, circle: bool = False) -> FloatArray:
    """Return Gamma(Re) of an oscillating beam of rectangular (thin) or circular cross-section.

    Re = density x omega x width^2 / (4 viscosity). Circle: exact; rectangle: Sader's fit to 0.1 %.
    """
    from scipy.special import kve  # slow to import

    Re = np.asarray(reynolds, dtype=float)
    root = np.sqrt(1j * Re)
    gamma = 1.0 + 4j * kve(1, -1j * root) / (root * kve(0, -1j * root))
    if circle:
        return np.asarray(gamma)
    tau = np.log10(Re)
    polynomial = np.polynomial.polynomial.polyval
    real = polynomial(tau, _REAL) / polynomial(tau, _REAL_BELOW)
    imaginary = polynomial(tau, _IMAGINARY) / polynomial(tau, _IMAGINARY_BELOW)
    return np.asarray(gamma * (real + 1j * imaginary))


def fluid_load(
    width_m: float, density_kg_per_m3: float, viscosity_Pa_s: float, frequency_hz: float,
    drag_coefficient: float = 0.0,
) -> FluidLoad:  # fmt: skip
    """Return added mass and linear drag of a flat sheet that oscillates at one frequency."""
    if not all(
        0.0 < x < np.inf for x in (width_m, density_kg_per_m3, viscosity_Pa_s, frequency_hz)
    ):
        raise ModelError("width, density, viscosity and frequency must be positive")
    omega = 2.0 * np.pi * frequency_hz
    gamma = complex(
        hydrodynamic_function(density_kg_per_m3 * omega * width_m**2 / (4.0 * viscosity_Pa_s))
    )
    area = 0.25 * np.pi * density_kg_per_m3 * width_m**2
    return FluidLoad(
        added_mass_kg_per_m=area * gamma.real,
        normal_Ns_per_m2=area * omega * gamma.imag,
        quadratic_Ns2_per_m3=0.5 * density_kg_per_m3 * drag_coefficient * width_m,
    )
