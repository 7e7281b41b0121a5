"""Linear models of a sheet for control: where they hold, and as state-space matrices.

About an operating point, F = F0 + stiffness (p - p0) + gain (V - V0). With a mass m on the arc and
a voltage that acts with a lag: m p'' + damping p' = F, lag u' = V - u.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from model.design.force_map import force_map, known_voltages, reached, section
from model.design.propagation import propagate
from model.measurements import FloatArray, ModelError, in_volts
from model.parameter import Parameter
from model.sheet.sheet_model import SheetModel

STEP_M, STEP_V = 1e-5, 1e-3


@dataclass(frozen=True, kw_only=True)
class LinearModel:
    """F near an operating point."""

    configuration: str
    position_m: float
    voltage_V: float
    force_N: Parameter
    stiffness_N_per_m: Parameter  # dF/dp: negative where the sheet comes back by itself
    gain_N_per_V: Parameter  # dF/dV

    def force(self, position_m: FloatArray, voltage_V: FloatArray) -> FloatArray:
        """F in N of the linear model."""
        return (
            self.force_N.value
            + self.stiffness_N_per_m.value * (position_m - self.position_m)
            + self.gain_N_per_V.value * (voltage_V - self.voltage_V)
        )


def linearise(
    model: SheetModel, configuration: str, position_m: float, voltage_V: float = 0.0
) -> LinearModel:
    """Slopes of F at one place and voltage; at a kink of Me(V), as at 0 V, the mean of both."""
    volts = _driven_voltages(model, configuration)
    lower, upper = max(voltage_V - STEP_V, volts[0]), min(voltage_V + STEP_V, volts[-1])

    def question(changed: SheetModel) -> list[float]:
        at = force_map(
            changed, configuration, position_m + np.array([-STEP_M, 0.0, STEP_M]),
            np.array([lower, voltage_V, upper]),
        )  # fmt: skip
        if not at.all_reachable():
            raise ModelError(
                f"there is no linear model about {position_m * 1e3:g} mm and {in_volts(voltage_V)}:"
                " the place is not reachable"
            )
        F = at.tangential_N
        return [
            float(F[1, 1]),
            float(F[2, 1] - F[0, 1]) / (2.0 * STEP_M),
            float(F[1, 2] - F[1, 0]) / (upper - lower),
        ]

    force, stiffness, gain = propagate(model, configuration, question, ("N", "N/m", "N/V"))
    return LinearModel(
        configuration=configuration,
        position_m=position_m,
        voltage_V=voltage_V,
        force_N=force,
        stiffness_N_per_m=stiffness,
        gain_N_per_V=gain,
    )


def _driven_voltages(model: SheetModel, configuration: str) -> FloatArray:
    """Return the voltages of the model, 0 V included; a model without others has no gain."""
    volts = known_voltages(model, configuration)
    if len(volts) == 1:
        raise ModelError(
            f"the model of '{configuration}' has no driving voltage, so that it says nothing of a"
            " voltage's effect"
        )
    return volts


def fit_linear(
    model: SheetModel, configuration: str, low_m: float, high_m: float
) -> tuple[LinearModel, float]:
    """Fit the plane F(p, V) over section and voltages (least squares); return it and its RMS."""
    volts = _driven_voltages(model, configuration)
    p, V = section(low_m, high_m, 31), np.linspace(volts[0], volts[-1], 9)
    middle = 0.5 * (low_m + high_m)
    A = np.stack(
        [np.ones(len(p) * len(V)), np.repeat(p - middle, len(V)), np.tile(V, len(p))], axis=1
    )

    def question(changed: SheetModel) -> list[float]:
        F = reached(force_map(changed, configuration, p, V)).tangential_N.ravel()
        c = np.linalg.lstsq(A, F, rcond=None)[0]
        return [*(float(v) for v in c), float(np.sqrt(np.mean((A @ c - F) ** 2)))]

    force, stiffness, gain, error = propagate(
        model, configuration, question, ("N", "N/m", "N/V", "N")
    )
    return LinearModel(
        configuration=configuration,
        position_m=middle,
        voltage_V=0.0,
        force_N=force,
        stiffness_N_per_m=stiffness,
        gain_N_per_V=gain,
    ), error.value


@dataclass(frozen=True)
class ValidityMap:
    """Where a linear model may be used."""

    position_m: FloatArray  # (P,)
    voltage_V: FloatArray  # (V,)
    error_N: FloatArray  # (P, V) linear less full model; NaN: not reachable
    range_N: float  # of F over the map

    def valid(self, share: float = 0.05) -> FloatArray:
        """1 where the error is below a share of the range, else 0."""
        inside = np.abs(self.error_N) <= share * self.range_N
        return inside.astype(float)


def validity(
    model: SheetModel, linear: LinearModel, low_m: float, high_m: float, count: int = 31
) -> ValidityMap:
    """Return the error of a linear model over positions and voltages."""
    volts = known_voltages(model, linear.configuration)
    p, V = section(low_m, high_m, count), np.linspace(volts[0], volts[-1], 9)
    found = force_map(model, linear.configuration, p, V)
    error = linear.force(p[:, None], V[None, :]) - found.tangential_N
    return ValidityMap(
        p, V, error, float(np.nanmax(found.tangential_N) - np.nanmin(found.tangential_N))
    )


@dataclass(frozen=True, kw_only=True)
class StateSpace:
    """x' = A x + B (V - V0), y = C x: x = position and speed of the object, delayed voltage."""

    A: FloatArray  # (n, n)
    B: FloatArray  # (n, 1)
    C: FloatArray  # (2, n): position from the operating point (m), change of F (N)
    D: FloatArray  # (2, 1)
    states: tuple[str, ...]


def state_space(
    linear: LinearModel, mass_kg: float, damping_Ns_per_m: float = 0.0, lag_s: float = 0.0
) -> StateSpace:
    """Return matrices for an object on the arc; without lag the voltage acts at once."""
    if not (mass_kg > 0.0 and damping_Ns_per_m >= 0.0 and lag_s >= 0.0):
        raise ModelError("the mass must be positive, damping and lag must not be negative")
    k, g = linear.stiffness_N_per_m.value, linear.gain_N_per_V.value
    A = np.array([[0.0, 1.0], [k / mass_kg, -damping_Ns_per_m / mass_kg]])
    B, C, D = (
        np.array([[0.0], [g / mass_kg]]),
        np.array([[1.0, 0.0], [k, 0.0]]),
        np.array([[0.0], [g]]),
    )
    if lag_s == 0.0:
        return StateSpace(A=A, B=B, C=C, D=D, states=("position_m", "speed_m_per_s"))
    A = np.block([[A, B], [np.zeros((1, 2)), np.array([[-1.0 / lag_s]])]])
    C = np.block([C, D])
    return StateSpace(
        A=A, B=np.array([[0.0], [0.0], [1.0 / lag_s]]), C=C, D=np.zeros((2, 1)),
        states=("position_m", "speed_m_per_s", "voltage_V"),
    )  # fmt: skip


@dataclass(frozen=True)
class Controller:
    """V = feedforward_V + feedforward_V_per_m p - position_V_per_m (p - wanted) - speed_.. p'."""

    feedforward_V: float
    feedforward_V_per_m: float  # voltage that holds the object still, over its position
    position_V_per_m: float
    speed_Vs_per_m: float


def controller(
    linear: LinearModel,
    mass_kg: float,
    bandwidth_rad_per_s: float,
    damping_ratio: float = 1.0,
    damping_Ns_per_m: float = 0.0,
) -> Controller:
    """Gains that give an object the wanted second-order response.

    The feedforward cancels the sheet's own stiffness: m p'' = -m w^2 (p - wanted) - 2 z m w p'.
    """
    g = linear.gain_N_per_V.value
    if g == 0.0 or not (mass_kg > 0.0 and bandwidth_rad_per_s > 0.0 and damping_ratio > 0.0):
        raise ModelError(
            "a controller needs a gain, and positive mass, bandwidth and damping ratio"
        )
    k = linear.stiffness_N_per_m.value
    at_zero = linear.force_N.value - k * linear.position_m - g * linear.voltage_V
    return Controller(
        -at_zero / g,
        -k / g,
        mass_kg * bandwidth_rad_per_s**2 / g,
        (2.0 * damping_ratio * mass_kg * bandwidth_rad_per_s - damping_Ns_per_m) / g,
    )
