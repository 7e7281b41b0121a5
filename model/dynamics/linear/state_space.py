"""Linear models x' = A x + B u, y = C x + D u, in time or from sample to sample.

Sources: Franklin, Powell and Workman, Digital Control of Dynamic Systems (sampling with a delay);
Antoulas, Approximation of Large-Scale Dynamical Systems, ch. 7 (balanced truncation, its bound).
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from math import floor

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError

ComplexArray = npt.NDArray[np.complex128]

# Hankel singular values are known to the root of the rounding error; smaller ones are noise.
_LEAST_VALUE = 1e-7  # of the largest
_SAME_TIME = 1e-9  # of a sample: a delay this close to whole samples is whole


@dataclass(frozen=True, kw_only=True)
class LinearSystem:
    """A linear model; inputs and outputs are named with their units: voltage_V, force_N."""

    A: FloatArray  # (n, n)
    B: FloatArray  # (n, inputs)
    C: FloatArray  # (outputs, n)
    D: FloatArray  # (outputs, inputs)
    inputs: tuple[str, ...]
    outputs: tuple[str, ...]
    sample_time_s: float | None = None  # None: in continuous time

    def __post_init__(self) -> None:
        """Raise ModelError unless the matrices are finite and fit together."""
        n, m, p = len(self.A), len(self.inputs), len(self.outputs)
        wanted = {"A": (n, n), "B": (n, m), "C": (p, n), "D": (p, m)}
        for name, shape in wanted.items():
            matrix = getattr(self, name)
            if matrix.shape != shape:
                raise ModelError(
                    f"the matrix {name} of a linear model is {_size(matrix.shape)}; "
                    f"{_size(shape)} is needed"
                )
            if not np.all(np.isfinite(matrix)):
                raise ModelError(
                    f"the matrix {name} of a linear model has values that are not finite"
                )
        if self.sample_time_s is not None and not 0.0 < self.sample_time_s < np.inf:
            raise ModelError(f"a sample time of {self.sample_time_s} s is not positive")

    @property
    def order(self) -> int:
        """Return the number of states."""
        return len(self.A)

    @property
    def poles(self) -> ComplexArray:
        """Return the eigenvalues of A."""
        return np.asarray(np.linalg.eigvals(self.A), dtype=np.complex128)

    @property
    def is_stable(self) -> bool:
        """Whether it returns to rest from any state."""
        if not self.order:
            return True
        if self.sample_time_s is None:
            return bool(np.all(self.poles.real < 0.0))
        return bool(np.all(np.abs(self.poles) < 1.0))

    @property
    def static_gain(self) -> FloatArray:
        """Return the outputs' change for a change of the inputs that lasts, (outputs, inputs)."""
        rest = -self.A if self.sample_time_s is None else np.eye(self.order) - self.A
        return np.asarray(self.C @ np.linalg.solve(rest, self.B) + self.D)

    def output(self, name: str) -> LinearSystem:
        """Return the same model with one output."""
        if name not in self.outputs:
            raise ModelError(
                f"the linear model has no output {name}, only {', '.join(self.outputs)}"
            )
        row = [self.outputs.index(name)]
        return replace(self, C=self.C[row], D=self.D[row], outputs=(name,))

    def response(self, frequencies_hz: FloatArray) -> ComplexArray:
        """Return the frequency response, (frequencies, outputs, inputs)."""
        s = 2j * np.pi * np.asarray(frequencies_hz, dtype=float).reshape(-1, 1, 1)
        at = s if self.sample_time_s is None else np.exp(s * self.sample_time_s)
        states = np.linalg.solve(at * np.eye(self.order) - self.A, self.B[None].astype(complex))
        return np.asarray(self.C @ states + self.D)

    def simulate(self, inputs: FloatArray, start: FloatArray | None = None) -> FloatArray:
        """Return the outputs (samples, outputs) of a sampled model for inputs (samples, inputs)."""
        if self.sample_time_s is None:
            raise ModelError("a model in continuous time is sampled before it is simulated")
        x = np.zeros(self.order) if start is None else np.asarray(start, dtype=float)
        out = np.empty((len(inputs), len(self.outputs)))
        for k, u in enumerate(inputs):
            out[k] = self.C @ x + self.D @ u
            x = self.A @ x + self.B @ u
        return out

    def step(self, times_s: FloatArray) -> FloatArray:
        """Return the outputs (times, outputs) after a unit step of the first input at t = 0.

        Exact at every time; times ascend in equal steps from 0.
        """
        t = np.asarray(times_s, dtype=float)
        sampled = discretised(self, float(t[1] - t[0]))
        return sampled.simulate(np.eye(len(self.inputs))[:1].repeat(len(t), axis=0))


def discretised(system: LinearSystem, sample_time_s: float, delay_s: float = 0.0) -> LinearSystem:
    """Return the model from sample to sample of held inputs that act `delay_s` late; exact.

    The states are followed by past inputs, the latest first, as many as the delay spans. Without a
    delay an input acts at once on outputs with a direct path D.
    """
    from scipy.linalg import expm

    if system.sample_time_s is not None:
        raise ModelError("the model is sampled already")
    if not (0.0 < sample_time_s < np.inf and 0.0 <= delay_s < np.inf):
        raise ModelError("a sample time must be positive, and a delay must not be negative")
    n, m = system.B.shape
    samples = delay_s / sample_time_s
    whole = floor(samples + _SAME_TIME)
    late_s = max(samples - whole, 0.0) * sample_time_s
    if late_s < _SAME_TIME * sample_time_s:
        late_s = 0.0

    def held(time_s: float) -> tuple[FloatArray, FloatArray]:
        """Return exp(A t), and the integral of it times B."""
        block = expm(np.block([[system.A, system.B], [np.zeros((m, n + m))]]) * time_s)
        return block[:n, :n], block[:n, n:]

    decay_new, new = held(sample_time_s - late_s)
    decay_old, old = held(late_s)
    past = whole + (late_s > 0.0)  # inputs that are to be remembered
    A, B = np.zeros((n + past * m, n + past * m)), np.zeros((n + past * m, m))
    C = np.hstack([system.C, np.zeros((len(system.C), past * m))])
    D = np.zeros_like(system.D)
    A[:n, :n] = decay_new @ decay_old

    def act(age: int, effect: FloatArray, rows: slice) -> None:
        """Let the input of so many samples ago act."""
        if age == 0:
            B[rows] += effect
        else:
            A[rows, n + (age - 1) * m : n + age * m] += effect

    act(whole, new, slice(0, n))
    if late_s:
        act(whole + 1, decay_new @ old, slice(0, n))
    if past:
        act(0, np.eye(m), slice(n, n + m))
        C[:, n + (past - 1) * m :] += system.D
    else:
        D += system.D
    for age in range(1, past):
        act(age, np.eye(m), slice(n + age * m, n + (age + 1) * m))
    return replace(system, A=A, B=B, C=C, D=D, sample_time_s=sample_time_s)


def balanced(system: LinearSystem, states: int) -> tuple[LinearSystem, float]:
    """Return a model with fewer states, and a bound of its error at any frequency.

    The bound is of the largest gain of the difference, in output units per input unit: twice the
    sum of the Hankel singular values that are left out.
    """
    if states < 1:
        raise ModelError("a reduced model needs one state at least")
    if not system.is_stable:
        raise ModelError("only a stable linear model can be reduced")
    of_inputs = _factor(_gramian(system, system.A, system.B))
    of_outputs = _factor(_gramian(system, system.A.T, system.C.T))
    left, values, right = np.linalg.svd(of_outputs.T @ of_inputs)
    kept = min(states, int(np.sum(values > _LEAST_VALUE * values[0])))
    scale = 1.0 / np.sqrt(values[:kept])
    into = scale[:, None] * (left[:, :kept].T @ of_outputs.T)
    back = of_inputs @ right[:kept].T * scale
    reduced = replace(system, A=into @ system.A @ back, B=into @ system.B, C=system.C @ back)
    return reduced, 2.0 * float(np.sum(values[kept:]))


def _gramian(system: LinearSystem, A: FloatArray, B: FloatArray) -> FloatArray:
    from scipy.linalg import solve_continuous_lyapunov, solve_discrete_lyapunov

    if system.sample_time_s is None:
        return np.asarray(solve_continuous_lyapunov(A, -B @ B.T))
    return np.asarray(solve_discrete_lyapunov(A, B @ B.T))


def _factor(gramian: FloatArray) -> FloatArray:
    """Return L with L L^T = the Gramian, which rounding may have made slightly indefinite."""
    values, vectors = np.linalg.eigh(0.5 * (gramian + gramian.T))
    return np.asarray(vectors * np.sqrt(np.clip(values, 0.0, None)))


def _size(shape: tuple[int, ...]) -> str:
    return " x ".join(map(str, shape))
