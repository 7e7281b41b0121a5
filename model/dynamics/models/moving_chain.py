"""A free chain of rigid links in time, at any amplitude.

    sum_j a_ij [cos(t_i - t_j) t_j'' + sin(t_i - t_j) t_j'^2] + T_i - T_i+1 + drag_i = 0
    T_j = K_j [(t_j - t_j-1) - cell_j (k0 + Me/B) + eta (t_j' - t_j-1')]
t_j: direction of link j (rad); a_ij (kg m2) of uniform links; drag c |v_n| v_n on each link's
middle. Average acceleration (Newmark, gamma 1/2, beta 1/4): second order, no damping of its own.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit

LONGEST_STEP_S = 1e-3
ITERATIONS = 40
ENOUGH_RAD = 1e-10


@jit
def balance(c: Any, t: Array, v: Array, a: Array, spring: Array, drag: float, out: Array) -> None:
    """Write the left sides of the equations; c: (inertia (n, n), link length)."""
    inertia, h = c
    n = len(t)
    for i in range(n):
        total = spring[i] - (spring[i + 1] if i + 1 < n else 0.0)
        for j in range(n):
            apart = t[i] - t[j]
            total += inertia[i, j] * (np.cos(apart) * a[j] + np.sin(apart) * v[j] * v[j])
        out[i] = total
    for k in range(n):
        speed = 0.5 * h * v[k]
        for i in range(k):
            speed += h * np.cos(t[i] - t[k]) * v[i]
        force = h * drag * abs(speed) * speed
        out[k] += 0.5 * h * force
        for i in range(k):
            out[i] += h * np.cos(t[i] - t[k]) * force


@jit
def joints(stiffness: Array, free: Array, eta: float, t: Array, v: Array, out: Array) -> None:
    """Write the joints' moments T_j."""
    for j in range(len(t)):
        before, spun = (t[j - 1], v[j - 1]) if j else (0.0, 0.0)
        out[j] = stiffness[j] * (t[j] - before - free[j] + eta * (v[j] - spun))


@jit
def march(
    c: Any, stiffness: Array, cell: Array, rest: Array, charge: Any, steps: Array, loss: Any
) -> Array:
    """Return directions (T, n) of a chain from rest; steps (T - 1,), loss: eta, drag.

    charge: Me/B (T,), the values (T,) towards which it goes in each step, and its time constant.
    NaN from where the equations are not solved.
    """
    kappa, final, tau = charge
    inertia = c[0]
    eta, drag = loss
    n = len(cell)
    out = np.full((len(kappa), n), np.nan)
    t, v, a = np.cumsum(rest + cell * kappa[0]), np.zeros(n), np.zeros(n)
    spring, wrong, matrix = np.zeros(n), np.zeros(n), np.zeros((n, n))
    out[0] = t
    for m in range(len(steps)):
        parts = max(1, int(np.ceil(steps[m] / LONGEST_STEP_S - 1e-9)))
        dt = steps[m] / parts
        for part in range(parts):
            share = (part + 1.0) / parts
            left = np.exp(-share * steps[m] / tau)
            free = rest + cell * (final[m] + (kappa[m] - final[m]) * left)
            t0 = t + dt * v + 0.25 * dt * dt * a
            v0 = v + 0.5 * dt * a
            solved = False
            for _ in range(ITERATIONS):
                t = t0 + 0.25 * dt * dt * a
                v = v0 + 0.5 * dt * a
                joints(stiffness, free, eta, t, v, spring)
                balance(c, t, v, a, spring, drag, wrong)
                weight = 0.25 * dt * dt + 0.5 * dt * eta
                for i in range(n):
                    for j in range(n):
                        matrix[i, j] = inertia[i, j] * np.cos(t[i] - t[j])
                    after = stiffness[i + 1] if i + 1 < n else 0.0
                    matrix[i, i] += weight * (stiffness[i] + after)
                    if i:
                        matrix[i, i - 1] -= weight * stiffness[i]
                        matrix[i - 1, i] -= weight * stiffness[i]
                change = np.linalg.solve(matrix, wrong)
                a = a - change
                if np.max(np.abs(change)) * dt * dt < ENOUGH_RAD:
                    solved = True
                    break
            if not solved:
                return out
            t = t0 + 0.25 * dt * dt * a
            v = v0 + 0.5 * dt * a
        out[m + 1] = t
    return out


def inertia_of(links: int, link_m: float, mass_per_length: float) -> Array:
    """Return a_ij of uniform links."""
    reach = np.tril(np.full((links, links), link_m), -1) + 0.5 * link_m * np.eye(links)
    mass = mass_per_length * link_m
    return np.asarray(mass * (reach.T @ reach + np.eye(links) * link_m**2 / 12.0))
