"""The sheet's electrodes as a distributed RC line, in time.

V'' = r j, j = (V - U)/rho_b + g_p V, c U_t = (V - U)/rho_b, V_s - V(0) = R_s i, i = -V'(0)/r,
V'(l) = 0: V is the voltage between the electrodes, U that of the double layer, which bends the
sheet. U and V are Legendre polynomials over the sheet (Galerkin). One polynomial is the lumped RC
element. A step with held voltage is exact: each mode of the line decays by itself.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass
from functools import cache, cached_property
from itertools import pairwise
from math import isfinite
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import legendre

from model.measurements import FloatArray, ModelError


@dataclass(frozen=True, kw_only=True)
class ElectrodeLine:
    """Resistances and capacitance per length of the sheet; the source's resistance."""

    electrode_ohm_per_m: float  # r, both faces together
    capacitance_F_per_m: float  # c, of the double layer
    bulk_ohm_m: float  # rho_b, ionic resistance in series with it
    leak_S_per_m: float = 0.0  # g_p
    source_ohm: float = 1.0  # R_s: shunt, contacts, amplifier

    def __post_init__(self) -> None:
        """Refuse what no electrodes are."""
        if not all(isfinite(x) for x in astuple(self)):
            raise ModelError("the electrodes' properties must be finite numbers")
        for name, value in (
            ("resistance of the electrodes", self.electrode_ohm_per_m),
            ("capacitance of the double layer", self.capacitance_F_per_m),
            ("ionic resistance of the sheet", self.bulk_ohm_m),
            ("resistance of the source", self.source_ohm),
        ):
            if value <= 0.0:
                raise ModelError(f"the {name} must be positive, not {value:g}")
        if self.leak_S_per_m < 0.0:
            raise ModelError(f"the leak must be zero or positive, not {self.leak_S_per_m:g} S/m")


class _Modes(NamedTuple):
    """The line with its modes decoupled."""

    rate: FloatArray  # (T,) of decay, 1/s
    shape: FloatArray  # (T, T) modes -> Legendre coefficients of U
    final: FloatArray  # (T,) the modes after a long time, per volt of the source
    clamp: FloatArray  # (T,) V(0) per mode
    clamp_by_source: float  # V(0) per volt of the source


@cache
def _slopes(terms: int) -> FloatArray:
    """Return int P_i' P_j' from -1 to 1, (T, T)."""
    x, w = legendre.leggauss(terms + 1)
    slope = np.array([legendre.legval(x, legendre.legder(row)) for row in np.eye(terms)])
    return np.asarray(slope * w @ slope.T)


@dataclass(frozen=True)
class LineModes:
    """The line with `terms` Legendre polynomials over the sheet, as decoupled modes."""

    line: ElectrodeLine
    length_m: float
    terms: int

    @cached_property
    def _modes(self) -> _Modes:
        """Solve the weak form with orthonormal polynomials p_i; e_i = p_i(0), S_ij = int p_i' p_j'.

        [S/r + 1/rho_b + g_p + e e^T/R_s] v = u/rho_b + e V_s/R_s,   c u_t = (v - u)/rho_b.
        """
        of, T = self.line, self.terms
        scale = np.sqrt((2.0 * np.arange(T) + 1.0) / self.length_m)
        ends = scale * (-1.0) ** np.arange(T)
        H = self._slopes(scale) / of.electrode_ohm_per_m + np.outer(ends, ends) / of.source_ohm
        H[np.diag_indices(T)] += 1.0 / of.bulk_ohm_m + of.leak_S_per_m
        inverse = np.linalg.inv(H)
        by_u, by_source = inverse / of.bulk_ohm_m, inverse @ ends / of.source_ohm
        time = of.bulk_ohm_m * of.capacitance_F_per_m
        matrix = (np.eye(T) - by_u) / time
        rate, modes = np.linalg.eigh(0.5 * (matrix + matrix.T))
        return _Modes(
            rate=rate, shape=scale[:, None] * modes, final=modes.T @ by_source / (time * rate),
            clamp=modes.T @ (by_u.T @ ends), clamp_by_source=float(ends @ by_source),
        )  # fmt: skip

    def _slopes(self, scale: FloatArray) -> FloatArray:
        """Return S."""
        return np.asarray(_slopes(self.terms) * np.outer(scale, scale) * 2.0 / self.length_m)

    @property
    def rates_per_s(self) -> FloatArray:
        """Return the rates of decay of the modes, ascending."""
        return self._modes.rate

    def at(self, s_m: FloatArray) -> FloatArray:
        """Return the matrix (S, T) that takes modes to U at points of the sheet."""
        t = 2.0 * np.asarray(s_m, dtype=float) / self.length_m - 1.0
        return np.asarray(legendre.legvander(t, self.terms - 1) @ self._modes.shape)

    def respond(self, start: FloatArray, step_s: FloatArray, source_V: FloatArray) -> FloatArray:
        """Return the modes (n + 1, T) at the ends of n steps, each with its held voltage."""
        rate, final = self._modes.rate, self._modes.final
        out = np.empty((len(step_s) + 1, self.terms))
        out[0] = start
        if not len(step_s):
            return out
        edges = (np.flatnonzero(source_V[1:] != source_V[:-1]) + 1).tolist()
        for first, last in pairwise([0, *edges, len(step_s)]):
            rest = final * source_V[first]
            decay = np.exp(-np.cumsum(step_s[first:last])[:, None] * rate)
            out[first + 1 : last + 1] = rest + (out[first] - rest) * decay
        return out

    def charged(self, time_s: FloatArray, source_V: FloatArray) -> FloatArray:
        """Return the modes (T,) at time 0 of what was held from times before it on."""
        times = time_s[time_s < 0.0]
        if not len(times):
            return np.zeros(self.terms)
        widths = np.diff(times, append=0.0)
        modes = self.respond(np.zeros(self.terms), widths, source_V[: len(times)])
        return np.asarray(modes[-1])

    def transfer(self, p: complex) -> np.ndarray[Any, Any]:
        """Return the modes for a source of exp(p t) V."""
        return np.asarray(self._modes.final * self._modes.rate / (p + self._modes.rate))

    def clamp_V(self, modes: FloatArray, source_V: FloatArray) -> FloatArray:
        """Return V(0): modes (n, T) and the source's voltage (n,) at the same instants."""
        return np.asarray(modes @ self._modes.clamp + self._modes.clamp_by_source * source_V)

    def current_A(self, modes: FloatArray, source_V: FloatArray) -> FloatArray:
        """Return i = (V_s - V(0))/R_s."""
        return np.asarray((source_V - self.clamp_V(modes, source_V)) / self.line.source_ohm)
