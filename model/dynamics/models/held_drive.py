"""Linear systems under voltages that are held from sample to sample: exact in time."""

from __future__ import annotations

from itertools import pairwise

import numpy as np

from model.measurements import FloatArray, ModelError

GROWS = 1e-9  # a rate so much above 0, relative to the fastest, is no rounding
WELL_CONDITIONED = 1e8  # of the matrix of eigenvectors


def held_states(A: FloatArray, B: FloatArray, time_s: FloatArray, drive: FloatArray) -> FloatArray:
    """Return x (n, states) of x' = A x + B u from rest; each u (n,) is held until the next.

    `ModelError` where a state grows by itself.
    """
    rates, modes = np.linalg.eig(A)
    if np.max(np.real(rates)) > GROWS * np.max(np.abs(rates)):
        raise ModelError("with these values the model is unstable")
    rates = np.where(np.real(rates) > 0.0, rates - np.real(rates), rates)
    if np.linalg.cond(modes) < WELL_CONDITIONED:
        return _by_modes(rates, modes, B, time_s, drive)
    return _step_by_step(A, B, np.diff(time_s), drive)


def lag(time_constant_s: float, time_s: FloatArray, drive: FloatArray) -> FloatArray:
    """Return u (n,) of tau u' = drive - u from rest."""
    rate = np.array([1.0 / time_constant_s])
    return held_states(-rate[:, None], rate, time_s, drive)[:, 0]


def _by_modes(
    rates: FloatArray, modes: FloatArray, B: FloatArray, time_s: FloatArray, drive: FloatArray
) -> FloatArray:
    """Follow each mode by itself from one change of the voltage to the next."""
    push = np.linalg.solve(modes, B.astype(modes.dtype))
    fast = np.where(rates == 0.0, 1.0, rates)
    out = np.zeros((len(drive), len(B)), dtype=modes.dtype)
    edges = (np.flatnonzero(np.diff(drive[:-1])) + 1).tolist()
    for first, last in pairwise([0, *edges, len(drive) - 1]):
        passed = (time_s[first + 1 : last + 1] - time_s[first])[:, None]
        grown = np.expm1(passed * rates)
        gain = np.where(rates == 0.0, passed, grown / fast)
        out[first + 1 : last + 1] = (grown + 1.0) * out[first] + gain * (push * drive[first])
    return np.asarray(np.real(out @ modes.T))


def _step_by_step(A: FloatArray, B: FloatArray, steps: FloatArray, drive: FloatArray) -> FloatArray:
    from scipy.linalg import expm  # slow to import

    n = len(B)
    whole = np.zeros((n + 1, n + 1))
    whole[:n, :n], whole[:n, n] = A, B
    known: dict[float, FloatArray] = {}
    out = np.zeros((len(drive), n))
    for i, step in enumerate(np.round(steps, 12).tolist()):
        if step not in known:
            known[step] = expm(whole * step)
        E = known[step]
        out[i + 1] = E[:n, :n] @ out[i] + E[:n, n] * drive[i]
    return out
