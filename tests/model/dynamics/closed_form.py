"""Transfer functions of a straight sheet with distributed electrodes, in closed form.

Electrodes: the double layer is charged along the resistance of the two faces (a transmission
line), so that U falls along the sheet. Mechanics: a linear viscoelastic beam, clamped at s = 0,
bent by Me = alpha U. It is either free or rests on a roller that holds it in place. The structure
is that of Chen and Tan (IEEE/ASME Transactions on Mechatronics 13, 519, 2008), with the admittance
Y of a double layer behind an ionic resistance in place of their diffusion layer.

`p` is the complex frequency in 1/s, 2j pi f for the response at f hertz. Air and water, gravity
and the initial curvature are left out.
"""

from __future__ import annotations

import cmath
import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from model.dynamics.line import ElectrodeLine
from model.dynamics.material import Viscoelasticity
from model.measurements import FloatArray

ComplexArray = npt.NDArray[np.complex128]
Transfer = Callable[[complex], complex]  # of the complex frequency p in 1/s

_SERIES_BELOW = 2.0  # of |beta s|: below, differences such as cosh - cos lose digits
_TERMS = 10  # of the power series there: the next one is below 1e-30


@dataclass(frozen=True, kw_only=True)
class StraightSheet:
    """A uniform straight sheet and its electrodes."""

    length_m: float  # l
    mass_per_length_kg_per_m: float  # mu
    moment_per_volt_Nm: float  # alpha: Me = alpha U
    material: Viscoelasticity
    line: ElectrodeLine


def charge(sheet: StraightSheet, p: complex, s_m: float) -> complex:
    """Return U/V at s: the voltage of the double layer over that of the source."""
    G, D = _line(sheet, p)
    return cmath.cosh(G * (sheet.length_m - s_m)) / (D * _in_series(sheet, p))


def current(sheet: StraightSheet, p: complex) -> complex:
    """Return the current over the source's voltage, A/V."""
    G, D = _line(sheet, p)
    return G / sheet.line.electrode_ohm_per_m * cmath.sinh(G * sheet.length_m) / D


def deflection(sheet: StraightSheet, p: complex, s_m: float) -> complex:
    """Return y/V of the free sheet at s, m/V."""
    return _Beam(sheet, p).deflection(s_m)


def blocked_force(sheet: StraightSheet, p: complex, contact_m: float) -> complex:
    """Return the force on a fixed roller at s = `contact_m` over the voltage, N/V.

    It is the roller's reaction that keeps the sheet there at y = 0.
    """
    beam = _Beam(sheet, p)
    return beam.deflection(contact_m) / beam.compliance(contact_m)


def response(transfer: Transfer, frequencies_hz: FloatArray) -> ComplexArray:
    """Return a transfer function at these frequencies, of their shape."""
    f = np.asarray(frequencies_hz, dtype=float)
    values = [complex(transfer(2j * math.pi * each)) for each in f.ravel()]
    return np.array(values, dtype=np.complex128).reshape(f.shape)


def _line(sheet: StraightSheet, p: complex) -> tuple[complex, complex]:
    """Return G in 1/m (U'' = G^2 U along the sheet) and the denominator D of the line."""
    r = sheet.line.electrode_ohm_per_m
    c = sheet.line.capacitance_F_per_m
    admittance = sheet.line.leak_S_per_m + c * p / _in_series(sheet, p)
    G = cmath.sqrt(r * admittance)
    end = G * sheet.length_m
    return G, cmath.cosh(end) + sheet.line.source_ohm / r * G * cmath.sinh(end)


def _in_series(sheet: StraightSheet, p: complex) -> complex:
    """Return V/U across the ionic resistance: 1 + rho_b c p."""
    return 1 + sheet.line.bulk_ohm_m * sheet.line.capacitance_F_per_m * p


class _Beam:
    """Solves B* y'''' + mu p^2 y = Me'' for Me = m cosh G(l - s), with V = 1.

    y = a particular solution + sum of c_n S_n(s), S_n with the n-th derivative 1 at s = 0.
    """

    def __init__(self, sheet: StraightSheet, p: complex) -> None:
        self._end = sheet.length_m
        self._B = complex(sheet.material.complex_stiffness(p))
        self._beta4 = -sheet.mass_per_length_kg_per_m * p * p / self._B
        self._G, D = _line(sheet, p)
        self._moment = sheet.moment_per_volt_Nm / (D * _in_series(sheet, p))  # m

    def deflection(self, s_m: float) -> complex:
        """Return y(s) of the free sheet."""
        if self._G == 0:  # no leak at p = 0: the moment is the same everywhere
            return self._moment / self._B * s_m**2 / 2
        # B* (y'' - y_p'') is the moment that the particular solution leaves at the free end
        G, end = self._G, self._end
        y_p = G**2 * self._moment / self._B / (G**4 - self._beta4)
        at_clamp = -y_p * cmath.cosh(G * end), y_p * G * cmath.sinh(G * end)
        left = self._moment / self._B - y_p * G**2
        return y_p * cmath.cosh(G * (end - s_m)) + self._homogeneous(s_m, at_clamp, left)

    def compliance(self, at_m: float) -> complex:
        """Return y at s = `at_m` for a unit force there, m/N."""
        beyond = self._end - at_m
        # the force's own part S_3(s - at)/B* also bends the free end
        moment = -self._basis(beyond, 1) / self._B
        shear = -self._basis(beyond, 0) / self._B
        return self._homogeneous(at_m, (0.0, 0.0), moment, shear)

    def _homogeneous(
        self,
        s_m: float,
        at_clamp: tuple[complex, complex],
        curvature: complex,
        shear: complex = 0.0,
    ) -> complex:
        """Return the solution with y, y' at the clamp and y'', y''' at the free end as given."""
        end, S = self._end, self._basis
        c0, c1 = at_clamp
        matrix = np.array([[S(end, 0), S(end, 1)], [self._beta4 * S(end, 3), S(end, 0)]])
        wanted = np.array(
            [
                curvature - self._beta4 * (c0 * S(end, 2) + c1 * S(end, 3)),
                shear - self._beta4 * (c0 * S(end, 1) + c1 * S(end, 2)),
            ]
        )
        c2, c3 = np.linalg.solve(matrix, wanted)
        return complex(c0 * S(s_m, 0) + c1 * S(s_m, 1) + c2 * S(s_m, 2) + c3 * S(s_m, 3))

    def _basis(self, s_m: float, order: int) -> complex:
        """Return S_n(s) = sum over k of beta^4k s^(4k + n) / (4k + n)!."""
        beta = self._beta4**0.25
        x = beta * s_m
        if abs(x) < _SERIES_BELOW:
            return sum(
                self._beta4**k * s_m ** (4 * k + order) / math.factorial(4 * k + order)
                for k in range(_TERMS)
            )
        sums = (
            cmath.cosh(x) + cmath.cos(x),
            cmath.sinh(x) + cmath.sin(x),
            cmath.cosh(x) - cmath.cos(x),
            cmath.sinh(x) - cmath.sin(x),
        )
        return sums[order] / (2 * beta**order)
