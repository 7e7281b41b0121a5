"""Where a sheet can be held, whether it stays there by itself, and where else it could be."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from model.measurements import FloatArray
from model.mechanics.collocation import rule
from model.mechanics.equilibrium import Equilibria, Problems, SolverStatus, solve

WIDEST_RAD = 2.4  # positions beyond are never meant
SAME = 1e-3
LARGEST = 50.0  # N R^2/B of any force that a sheet could meet


def _at(batch: Problems, angles: FloatArray) -> Problems:
    """Return the batch's first problem, with its radius, at other positions."""
    K = len(angles)
    kappa = np.repeat(batch.kappa[:1], K, axis=0)  # a read-only view would be compiled for anew
    return replace(
        batch, kappa=kappa, softness=batch.softness[:1], angle_rad=angles,
        radius_m=float(batch.each_radius_m[0]), radii_m=None,
    )  # fmt: skip


def limit_m(batch: Problems) -> tuple[float, bool]:
    """Return the last reachable place on the path to an unreachable one, and whether the end slips.

    Places are arc lengths from polar angle 0; NaN where none is reachable. The flag is true where
    the sheet's end slips out there.
    """
    # not farther than half a turn: the way to a place in a wrong unit has millions of steps
    asked = float(np.clip(batch.angle_rad[0], -np.pi, np.pi))
    angles = np.linspace(-WIDEST_RAD, WIDEST_RAD, 193)
    tried = _at(batch, angles)
    found = solve(tried)
    good = found.status == SolverStatus.SOLVED
    if not good.any():
        return np.nan, False
    inside = float(angles[good][np.argmin(np.abs(angles[good] - asked))])
    outside, s_hat = asked, np.nan
    for _ in range(5):
        between = np.linspace(inside, outside, 12)
        found = solve(_at(batch, between))
        bad = found.status != SolverStatus.SOLVED
        bad[0] = False
        if not bad.any():
            break
        first = int(np.argmax(bad))
        inside, outside = float(between[first - 1]), float(between[first])
        s_hat = float(found.s_hat_m[first - 1])
    R = tried.radius_m
    return inside * R, bool(s_hat > batch.reach_m - 0.02 * R)


def stable(found: Equilibria, index: int = 0) -> bool:
    """Return whether the energy is a minimum among all shapes that run through the contact.

    Second variation, over B, in eta = d(phi) and sigma = d(s_hat), with n_hat.t = sin psi:
        int eta'^2/c - nu int sin(psi) eta^2 + 2 nu eta(s_hat) sigma + nu k(s_hat) sigma^2
    under int cos(psi) eta = 0, and sigma = int sin(psi) eta.
    """
    p, r = found.problems, rule(found.nodes)
    nu, s_hat = float(found.nu[index]), float(found.s_hat_m[index])
    top = min(s_hat, p.length_m)
    edges = np.append(p.breaks_m[p.breaks_m < top], top)
    h, n = np.diff(edges), len(r.c)
    P = len(h)
    psi = found.psi[index, :P, ::-1].ravel()
    w = (h[:, None] * r.b).ravel()
    Q = np.zeros((P * n, P * n))  # integral from the clamp to each node
    for m in range(P):
        Q[m * n : (m + 1) * n, m * n : (m + 1) * n] = h[m] * r.A
        Q[m * n : (m + 1) * n, : m * n] = w[: m * n]
    beyond = s_hat - top
    along = (w * np.sin(psi)) @ Q  # sigma
    across = (w * np.cos(psi)) @ Q + beyond * w
    end = w  # eta at the contact
    s = np.concatenate([low + d * r.c for low, d in zip(edges[:-1], h, strict=True)])
    k_end = 0.0 if beyond > 0.0 else float(found.shapes(np.array([top])).curvature_per_m[index, 0])
    H = np.diag(w / _softness(p, index, s)) - nu * Q.T @ ((w * np.sin(psi))[:, None] * Q)
    H += nu * (np.outer(end, along) + np.outer(along, end)) + nu * k_end * np.outer(along, along)
    scale = 1.0 / np.sqrt(w)
    H, g = H * scale[:, None] * scale[None, :], across * scale
    g /= np.linalg.norm(g)
    Hg = H @ g  # only shapes with g.eta = 0 count: H is projected, g itself given the value 1
    projected = H - np.outer(g, Hg) - np.outer(Hg, g) + (g @ Hg + 1.0) * np.outer(g, g)
    return bool(np.min(np.linalg.eigvalsh(projected)) > 0.0)


def _softness(p: Problems, index: int, s: FloatArray) -> FloatArray:
    if not p.softness.shape[2]:
        return np.ones_like(s)
    from model.mechanics.field import Field

    return Field(p.breaks_m, p.softness[min(index, len(p.softness) - 1)])(s)


def other_solutions(found: Equilibria) -> list[float]:
    """N/B of further equilibria of the first problem; there are none without an elongation."""
    p = found.problems
    if p.reach_m <= p.length_m * (1.0 + 1e-9):
        return []
    R = float(p.each_radius_m[0])
    nus = np.linspace(-10.0, 10.0, 9) / R**2
    contacts = np.linspace(1.01 * R, max(p.reach_m, 1.02 * R), 4)
    starts = np.array([(nu, s) for nu in nus for s in contacts])
    many = _at(p, np.full(len(starts), p.angle_rad[0]))
    psi = np.repeat(found.psi[:1], len(starts), axis=0)
    begin = Equilibria(
        problems=many, status=np.zeros(len(starts), dtype=np.int64), nu=starts[:, 0],
        s_hat_m=starts[:, 1], phi_hat_rad=np.zeros(len(starts)), psi=psi, nodes=found.nodes,
    )  # fmt: skip
    again = solve(many, begin)
    known = [float(found.nu[0])]
    for nu in again.nu[again.status == SolverStatus.SOLVED]:
        if abs(nu) * R**2 > LARGEST:
            continue  # wound up: no sheet gets there
        if all(abs(nu - other) > SAME * (abs(other) + 1.0 / R**2) for other in known):
            known.append(float(nu))
    return known[1:]
