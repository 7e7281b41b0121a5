"""Controllers of the force: PI, and LQG with an integrator, for a loop that runs at a fixed rate.

PI has the highest integral gain at which the sensitivity's peak Ms = max |1/(1 + L)| stays below a
bound (Astrom and Hagglund, Advanced PID Control, ch. 6). LQG estimates a constant disturbance of
the voltage along with the plant's states and takes it away: that is its integrator (Franklin,
Powell and Workman, ch. 9). It keeps the same bound.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np

from model.dynamics.linear.state_space import ComplexArray, LinearSystem
from model.measurements import FloatArray, ModelError

Method = Literal["pi", "lqg"]

LARGEST_SENSITIVITY = 1.6  # Ms
_LOWEST_HZ = 1e-3
_MOST_TRIALS = 12  # of LQG, each with half the disturbance
_PER_DECADE = 80  # of the frequencies at which Ms is looked for
_NEAR_MODE = np.linspace(-3.0, 3.0, 61)  # around a mode, in its own half-widths
REFERENCE, MEASURED, WRITTEN = "reference_N", "force_N", "voltage_V"


@dataclass(frozen=True, kw_only=True)
class ForceController:
    """u = C x + D [r, y], x+ = A x + B [r, y] + w (written - u), once each sample.

    r: force that is wanted; y: force that was measured, N; u: voltage, V. `written` is u within the
    limits, so that nothing winds up while the voltage is at one.
    """

    law: LinearSystem  # inputs r and y, output u
    anti_windup: FloatArray  # (n,) w

    @property
    def sample_time_s(self) -> float:
        """Return the time from one sample to the next."""
        assert self.law.sample_time_s is not None  # noqa: S101 - for the type checker
        return self.law.sample_time_s

    def loop(self, plant: LinearSystem, frequencies_hz: FloatArray) -> ComplexArray:
        """Return the loop's transfer function L, (frequencies,)."""
        feedback = self.law.response(frequencies_hz)[:, 0, 1]
        return np.asarray(-feedback * plant.response(frequencies_hz)[:, 0, 0])

    @property
    def integral_gain(self) -> float:
        """Return k_i in V/(N s): how fast the voltage rises for a force that is constantly off."""
        T = self.sample_time_s
        low = self.law.response(np.array([1e-6 / T]))[0, 0, 1]
        return float(abs(low * (np.exp(2e-6j * np.pi) - 1.0))) / T

    def sensitivity_peak(self, plant: LinearSystem) -> float:
        """Return Ms of the loop with a sampled plant."""
        return float(np.max(1.0 / np.abs(1.0 + self.loop(plant, _frequencies(plant)))))

    def closed_loop(self, plant: LinearSystem) -> LinearSystem:
        """Return the loop from r to force and voltage, without limits of the voltage."""
        _require_same_rate(self, plant)
        law, n = self.law, self.law.order
        by_r, by_y = law.B[:, :1], law.B[:, 1:]
        u_r, u_y = law.D[:, :1], law.D[:, 1:]
        A = np.block(
            [[law.A, by_y @ plant.C], [plant.B @ law.C, plant.A + plant.B @ u_y @ plant.C]]
        )
        return LinearSystem(
            A=A,
            B=np.vstack([by_r, plant.B @ u_r]),
            C=np.block([[np.zeros((1, n)), plant.C], [law.C, u_y @ plant.C]]),
            D=np.vstack([np.zeros((1, 1)), u_r]),
            inputs=(REFERENCE,),
            outputs=(MEASURED, WRITTEN),
            sample_time_s=plant.sample_time_s,
        )

    def follow(
        self, plant: LinearSystem, reference_N: FloatArray, limit_V: float
    ) -> tuple[FloatArray, FloatArray]:
        """Return force and voltage, sample by sample, of the linear plant within the limits."""
        _require_same_rate(self, plant)
        law, x, state = self.law, np.zeros(self.law.order), np.zeros(plant.order)
        force_N, voltage_V = np.empty(len(reference_N)), np.empty(len(reference_N))
        for k, r in enumerate(reference_N):
            y = float((plant.C @ state)[0])
            given = np.array([r, y])
            u = float((law.C @ x + law.D @ given)[0])
            written = float(np.clip(u, -limit_V, limit_V))
            x = law.A @ x + law.B @ given + self.anti_windup * (written - u)
            state = plant.A @ state + plant.B[:, 0] * written
            force_N[k], voltage_V[k] = y, written
        return force_N, voltage_V


def controller_of(
    A: FloatArray,
    B: FloatArray,
    C: FloatArray,
    D: FloatArray,
    anti_windup: FloatArray,
    sample_time_s: float,
) -> ForceController:
    """Return a controller of these matrices. Raises ModelError when they do not fit together."""
    if anti_windup.shape != (len(A),):
        raise ModelError(f"anti_windup has {anti_windup.size} numbers for {len(A)} states")
    return ForceController(law=_law(A, B, C, D, sample_time_s), anti_windup=anti_windup)


def pi(plant: LinearSystem, largest_sensitivity: float = LARGEST_SENSITIVITY) -> ForceController:
    """Return the PI controller u = k_p e + k_i int e dt of a sampled plant with one input."""
    T = _sample_time(plant)
    f = _frequencies(plant)
    P, integrator = plant.response(f)[:, 0, 0], T / (np.exp(2j * np.pi * f * T) - 1.0)

    def highest_gain(ratio_s: float) -> float:
        """Return k_i with k_p = ratio k_i at which |1 + L| first comes to 1/Ms."""
        loop = P * np.sign(plant.static_gain[0, 0]) * (ratio_s + integrator)
        return _first_root(np.abs(loop) ** 2, loop.real, 1.0 - largest_sensitivity**-2)

    ratios_s = np.concatenate([[0.0], T * np.geomspace(0.1, 1e5, 400)])
    gains = [highest_gain(ratio_s) for ratio_s in ratios_s]
    ratio_s, k_i = float(ratios_s[np.argmax(gains)]), float(np.max(gains))
    k_i *= float(np.sign(plant.static_gain[0, 0]))
    k_p = ratio_s * k_i
    return ForceController(
        law=_law(
            A=np.eye(1), B=np.array([[k_i * T, -k_i * T]]), C=np.eye(1),
            D=np.array([[k_p, -k_p]]), sample_time_s=T,
        ),
        anti_windup=np.array([min(1.0, T / ratio_s) if ratio_s else 1.0]),
    )  # fmt: skip


@dataclass(frozen=True, kw_only=True)
class LqgWeights:
    """What LQG weighs against each other."""

    voltage: float = 0.01  # (G0 u)^2 against y^2, G0 the plant's static gain
    force_noise_N: float = 5e-5  # of one measured force
    unrest_V: float = 0.02  # noise that acts as if it were voltage, a sample
    # how fast a voltage's disturbance wanders, V in one second; it grows with the root of the time
    disturbance_V: float = 0.15


def lqg(
    plant: LinearSystem,
    design: LinearSystem,
    weights: LqgWeights | None = None,
    largest_sensitivity: float = LARGEST_SENSITIVITY,
) -> ForceController:
    """Return the LQG controller with an integrator.

    `design`: a reduced model, sampled with the same delay, on which it is designed. Ms is that of
    the loop with `plant`: where it is too large the disturbance is taken to wander more slowly.
    """
    weights = weights or LqgWeights()
    for _ in range(_MOST_TRIALS):
        found = _lqg(design, weights)
        stable = found.closed_loop(plant).is_stable
        if stable and found.sensitivity_peak(plant) <= largest_sensitivity:
            return found
        weights = replace(weights, disturbance_V=weights.disturbance_V / 2)
    raise ModelError(
        f"no LQG controller keeps the sensitivity's peak below {largest_sensitivity:g}: use a "
        "higher rate, a shorter delay, more states, or PI"
    )


def _lqg(design: LinearSystem, weights: LqgWeights) -> ForceController:
    """Return the LQG controller of a sampled model for given weights."""
    from scipy.linalg import solve_discrete_are

    n, G0 = design.order, float(design.static_gain[0, 0])
    A, B, C = design.A, design.B, design.C
    price = np.array([[weights.voltage * G0**2]])
    P = solve_discrete_are(A, B, C.T @ C, price)
    K = np.linalg.solve(price + B.T @ P @ B, B.T @ P @ A)
    closed = C @ np.linalg.solve(np.eye(n) - A + B @ K, B)
    # the plant, and the constant disturbance of its input
    A_d = np.block([[A, B], [np.zeros((1, n)), np.ones((1, 1))]])
    B_d, C_d = np.vstack([B, [[0.0]]]), np.hstack([C, [[0.0]]])
    noise = weights.unrest_V**2 * B_d @ B_d.T
    noise[n, n] = weights.disturbance_V**2 * _sample_time(design)
    read = np.array([[weights.force_noise_N**2]])
    S = solve_discrete_are(A_d.T, C_d.T, noise, read)
    gain = S @ C_d.T / (C_d @ S @ C_d.T + read)
    K_d = np.hstack([K, [[1.0]]])
    kept = np.eye(n + 1) - gain @ C_d  # what the estimate keeps when y has come
    back = (A_d - B_d @ K_d) @ gain
    forward = B_d / closed
    return ForceController(
        law=_law(
            A=(A_d - B_d @ K_d) @ kept, B=np.hstack([forward, back]), C=-K_d @ kept,
            D=np.hstack([1.0 / closed, -K_d @ gain]), sample_time_s=_sample_time(design),
        ),
        anti_windup=B_d[:, 0],
    )  # fmt: skip


def _first_root(squared: FloatArray, real: FloatArray, room: float) -> float:
    """Return the least k > 0 with |1 + k L|^2 = 1 - room at any frequency.

    squared = |L|^2, real = Re L: the smaller root of |L|^2 k^2 + 2 Re L k + room = 0. There is one:
    a sampled plant that does not answer at once has Im L = 0 > Re L at half the sampling rate.
    """
    under = real**2 - squared * room
    near = (real < 0.0) & (under >= 0.0)
    roots = room / (-real[near] + np.sqrt(under[near]))
    return float(roots.min())


def _frequencies(plant: LinearSystem) -> FloatArray:
    """Return frequencies up to half the sampling rate, dense around each mode of the plant."""
    T = _sample_time(plant)
    highest = 0.5 / T
    decades = np.log10(highest / _LOWEST_HZ)
    spread = np.geomspace(_LOWEST_HZ, highest, int(_PER_DECADE * decades))
    poles = plant.poles
    rates = np.log(poles[np.abs(poles) > 1e-6].astype(complex)) / T
    waves = rates[rates.imag > 0.0]
    near = (waves.imag[:, None] + np.abs(waves.real)[:, None] * _NEAR_MODE) / (2 * np.pi)
    return np.unique(np.concatenate([spread, near[(near > _LOWEST_HZ) & (near < highest)]]))


def _sample_time(plant: LinearSystem) -> float:
    if plant.sample_time_s is None:
        raise ModelError("a controller is designed for a sampled model")
    if plant.D.any():
        raise ModelError("a model that answers within the sample cannot be put in a loop")
    return plant.sample_time_s


def _require_same_rate(controller: ForceController, plant: LinearSystem) -> None:
    if abs(_sample_time(plant) / controller.sample_time_s - 1.0) > 1e-6:
        raise ModelError(
            f"the controller runs at {1 / controller.sample_time_s:g} Hz, its model at "
            f"{1 / _sample_time(plant):g} Hz"
        )


def _law(
    A: FloatArray, B: FloatArray, C: FloatArray, D: FloatArray, sample_time_s: float
) -> LinearSystem:
    return LinearSystem(
        A=A, B=B, C=C, D=D, inputs=(REFERENCE, MEASURED), outputs=(WRITTEN,),
        sample_time_s=sample_time_s,
    )  # fmt: skip
