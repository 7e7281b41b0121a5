"""Linear systems under voltages that are held from sample to sample: exact in time."""

from __future__ import annotations

import numpy as np

from model.measurements import FloatArray

WELL_CONDITIONED = 1e8  # of the matrix of eigenvectors


def held_states(A: FloatArray, B: FloatArray, time_s: FloatArray, drive: FloatArray) -> FloatArray:
    """Return x (n, states) of x' = A x + B u from rest; each u (n,) is held until the next."""
    steps = np.diff(time_s)
    if np.ptp(steps) <= 1e-6 * steps[0]:
        rates, modes = np.linalg.eig(A)
        if np.linalg.cond(modes) < WELL_CONDITIONED:
            return _by_modes(rates, modes, B, float(np.mean(steps)), drive)
    return _step_by_step(A, B, steps, drive)


def lag(time_constant_s: float, time_s: FloatArray, drive: FloatArray) -> FloatArray:
    """Return u (n,) of tau u' = drive - u from rest."""
    rate = np.array([1.0 / time_constant_s])
    return held_states(-rate[:, None], rate, time_s, drive)[:, 0]


def _by_modes(
    rates: FloatArray, modes: FloatArray, B: FloatArray, step: float, drive: FloatArray
) -> FloatArray:
    from scipy.signal import lfilter  # slow to import

    push = np.linalg.solve(modes, B.astype(modes.dtype))
    total = np.zeros((len(drive), len(B)), dtype=modes.dtype)
    for i, rate in enumerate(rates):
        gain = np.expm1(rate * step) / rate if rate != 0.0 else step
        mode = lfilter([0.0, gain * push[i]], [1.0, -np.exp(rate * step)], drive)
        total += np.outer(mode, modes[:, i])
    return np.asarray(np.real(total))


def _step_by_step(A: FloatArray, B: FloatArray, steps: FloatArray, drive: FloatArray) -> FloatArray:
    from scipy.linalg import expm  # slow to import

    n = len(B)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = A, B
    known: dict[float, FloatArray] = {}
    out = np.zeros((len(drive), n))
    for i, step in enumerate(steps.tolist()):
        if step not in known:
            known[step] = expm(whole * step)
        E = known[step]
        out[i + 1] = E[:n, :n] @ out[i] + E[:n, n] * drive[i]
    return out
