"""The equilibrium in NumPy: the same equations as `_kernel`, written another way.

One function gives the residuals of all nodes and of the closure for whole batches; derivatives
are taken by complex step, so none of the compiled engine's algebra is repeated here. It checks
that engine and stands in for it where numba is missing; it is some hundred times slower.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise
from typing import Any

import numpy as np

from model.mechanics.collocation import Rule, integrated_legendre

Numbers = np.ndarray[Any, Any]  # real, or complex where derivatives are taken

SOLVED, SLIPPED, FAILED = 0, 1, 2
SMALL_STEP = 1e-7
MOST_STEPS = 25
WAY = 60  # steps of a continuation
TINY = 1e-40  # of a complex step


@dataclass(frozen=True, kw_only=True)
class Case:
    """A batch of K problems, any of its numbers complex."""

    breaks: Numbers  # (P + 1,)
    kappa: Numbers  # (K, P, D)
    soft: Numbers  # (K, P, Dc)
    R: Numbers  # (K,)
    length: Numbers  # (K,)
    angle: Numbers  # (K,)

    def pick(self, rows: Numbers) -> Case:
        """Return some problems of the batch, or the same ones several times."""
        names = ("kappa", "soft", "R", "length", "angle")
        return replace(self, **{name: getattr(self, name)[rows] for name in names})


def _case(breaks: Numbers, kappa: Numbers, soft: Numbers, R: Numbers, angles: Numbers) -> Case:
    K = len(angles)
    soft = np.broadcast_to(soft, (K, *soft.shape[1:]))
    return Case(
        breaks=breaks, kappa=kappa, soft=soft, R=np.broadcast_to(R, K),
        length=np.full(K, breaks[-1]), angle=angles,
    )  # fmt: skip


def _polynomial(
    breaks: Numbers, rows: Numbers, panel: Numbers, s: Numbers
) -> tuple[Numbers, Numbers]:
    """Value, and integral from the clamp, of (K, P, D) at s (K, ...) in the panels `panel`."""
    half, degrees = 0.5 * np.diff(breaks), np.arange(rows.shape[2])
    anti = rows / (degrees + 1) * half[:, None]
    low = (anti * (-1.0) ** (degrees + 1)).sum(2)
    before = np.cumsum(anti.sum(2) - low, axis=1) - (anti.sum(2) - low) - low
    k = np.arange(len(rows)).reshape(-1, *[1] * (s.ndim - 1))
    t = ((s - breaks[panel]) / half[panel] - 1.0)[..., None]
    powers = t**degrees
    return (rows[k, panel] * powers).sum(-1), before[k, panel] + (anti[k, panel] * powers * t).sum(
        -1
    )


@dataclass(frozen=True, kw_only=True)
class Loaded:
    """The loaded part, nodes counted from the contact in each panel: arrays (K, P, n) and (K,)."""

    h: Numbers  # (K, P) widths, 0 beyond the contact
    top: Numbers  # (K,)
    panel: Numbers  # (K,) the contact's
    psi: Numbers
    a: Numbers
    push: Numbers  # c a
    residual: Numbers
    psi_end: Numbers
    a_end: Numbers
    b_end: Numbers


def _integrals(h: Numbers, f: Numbers, r: Rule) -> tuple[Numbers, Numbers]:
    """Return integral from the contact to each node (K, P, n), and to the clamp (K,)."""
    whole = h * (f @ r.b)
    later = np.cumsum(whole[:, ::-1], axis=1)[:, ::-1] - whole
    return h[:, :, None] * (f @ r.A.T) + later[:, :, None], whole.sum(1)


def _loaded(case: Case, psi: Numbers, nu: Numbers, s_hat: Numbers, r: Rule) -> Loaded:
    P = len(case.breaks) - 1
    top = np.where(s_hat.real < case.length.real, s_hat, case.length)
    panel = np.clip(np.searchsorted(case.breaks, top.real, side="left") - 1, 0, P - 1)
    every, low = np.arange(P), case.breaks[:-1]
    h = np.where(every < panel[:, None], np.diff(case.breaks), 0.0)
    h = np.where(every == panel[:, None], top[:, None] - low, h)
    s = low[:, None] + h[:, :, None] * (1.0 - r.c)
    _, turned = _polynomial(case.breaks, case.kappa, every[:, None], s)
    _, turned_top = _polynomial(case.breaks, case.kappa, panel, top)
    c = _polynomial(case.breaks, case.soft, every[:, None], s)[0] if case.soft.shape[2] else 1.0
    run, run_end = _integrals(h, np.cos(psi), r)
    a = (s_hat - top)[:, None, None] + run
    moment, moment_end = _integrals(h, c * a, r)
    residual = psi + (turned_top[:, None, None] - turned) - nu[:, None, None] * moment
    residual = np.where((every <= panel[:, None])[:, :, None], residual, psi)
    return Loaded(
        h=h, top=top, panel=panel, psi=psi, a=a, push=c * a, residual=residual,
        psi_end=nu * moment_end - turned_top, a_end=s_hat - top + run_end,
        b_end=_integrals(h, np.sin(psi), r)[1],
    )  # fmt: skip


def _residual(case: Case, u: Numbers, r: Rule) -> Numbers:
    """Return all equations (K, Pn + 2) for u = (psi, nu R^2, s_hat / R)."""
    K, P, n = len(u), len(case.breaks) - 1, len(r.c)
    on = _loaded(case, u[:, :-2].reshape(K, P, n), u[:, -2] / case.R**2, u[:, -1] * case.R, r)
    turn = case.angle + on.psi_end
    ends = [on.a_end / case.R - np.cos(turn), on.b_end / case.R - np.sin(turn)]
    return np.concatenate([on.residual.reshape(K, P * n), np.stack(ends, axis=1)], axis=1)


def _jacobian(case: Case, u: Numbers, r: Rule) -> Numbers:
    K, m = u.shape
    rows = np.repeat(np.arange(K), m)
    stepped = u[rows] + 1j * TINY * np.tile(np.eye(m), (K, 1))
    return (_residual(case.pick(rows), stepped, r).imag / TINY).reshape(K, m, m).transpose(0, 2, 1)


def _newton(case: Case, u: Numbers, r: Rule) -> tuple[Numbers, Numbers]:
    """Improved u, and which of the batch converged."""
    u, done, alive = u.copy(), np.zeros(len(u), dtype=bool), np.arange(len(u))
    for _ in range(MOST_STEPS):
        if not len(alive):
            break
        here = case.pick(alive)
        J, value = _jacobian(here, u[alive], r), _residual(here, u[alive], r)
        good = np.isfinite(J).all((1, 2)) & np.isfinite(value).all(1)
        alive, J, value = alive[good], J[good], value[good]
        sane = np.abs(np.linalg.det(J)) > 1e-300
        alive, J, value = alive[sane], J[sane], value[sane]
        step = np.linalg.solve(J, -value[:, :, None])[:, :, 0]
        weight = np.concatenate([np.ones(u.shape[1] - 2), [1 / 8.0, 4.0]])
        size = np.max(np.abs(step * weight), axis=1, initial=0.0)
        u[alive] += step / np.maximum(size, 1.0)[:, None]
        u[alive, -1] = np.maximum(u[alive, -1], 0.98)
        done[alive[size < SMALL_STEP]] = True
        alive = alive[size >= SMALL_STEP]
    return u, done


def _free(case: Case, r: Rule) -> tuple[Numbers, Numbers]:
    """Unknowns of the free shapes, and the polar angles at which they meet the arc."""
    K, P, n = len(case.angle), len(case.breaks) - 1, len(r.c)
    u, polar = np.zeros((K, P * n + 2)), np.zeros(K)
    for k in range(K):
        one, length, R = case.pick(np.array([k])), case.length[k], case.R[k]
        s = np.linspace(0.0, max(length, 1.0001 * R), 2001)
        inside = np.minimum(s, length)
        panel = np.clip(np.searchsorted(case.breaks, inside) - 1, 0, P - 1)
        phi = _polynomial(one.breaks, one.kappa, panel[None], inside[None])[1][0]
        middle = 0.5 * (phi[1:] + phi[:-1])
        x = np.concatenate([[0.0], np.cumsum(np.diff(s) * np.cos(middle))])
        y = np.concatenate([[0.0], np.cumsum(np.diff(s) * np.sin(middle))])
        outside = np.hypot(x, y) >= R
        i = int(np.argmax(outside)) if outside.any() else len(s) - 1
        ahead = x[i] * np.cos(phi[i]) + y[i] * np.sin(phi[i])
        missing = R * R - x[i] ** 2 - y[i] ** 2
        step = 0.0 if outside.any() else -ahead + np.sqrt(ahead**2 + missing)
        polar[k] = np.arctan2(y[i] + step * np.sin(phi[i]), x[i] + step * np.cos(phi[i]))
        s_hat = s[i] + step
        on = _loaded(one, np.zeros((1, P, n)), np.zeros(1), np.array([s_hat]), r)
        u[k, :-2], u[k, -1] = -on.residual.ravel(), s_hat / R
    return u, polar


def _follow(case: Case, u: Numbers, start: Case, r: Rule) -> tuple[Numbers, Numbers]:
    """Continuation in equal steps from the solution u of `start` to `case`."""
    good = np.ones(len(u), dtype=bool)
    for share in np.linspace(0.0, 1.0, WAY + 1):
        angle = start.angle + share * (case.angle - start.angle)
        kappa = start.kappa + share * (case.kappa - start.kappa)
        u, done = _newton(replace(case, angle=angle, kappa=kappa), u, r)
        good &= done
    return u, good


def solve_many(
    breaks: Numbers, kappa: Numbers, soft: Numbers, rule: Rule, R: Numbers, reach: float,
    angles: Numbers, warm: Numbers, psi: Numbers, x: Numbers, status: Numbers,
) -> int:  # fmt: skip
    """As `kernel.solve_many`."""
    case = _case(breaks, kappa, soft, R, angles)
    free, polar = _free(case, rule)
    u = free.copy()
    share, each = 1.0 - np.maximum(0.0, 1.0 - breaks[-1] / R) ** 3, case.R[:, None]
    u[:, -2] = 3.0 * (polar - angles) / share
    started = np.concatenate(
        [psi.reshape(len(psi), -1), x[:, :1] * each**2, x[:, 1:2] / each], axis=1
    )
    u[warm] = started[warm]
    u, done = _newton(case, u, rule)
    sure = done & ((u[:, -1] * case.R <= breaks[-1]) | (np.abs(polar - angles) < 1.0))
    status[:] = np.where(sure & (u[:, -1] * case.R <= reach), SOLVED, FAILED)
    _store(case, u, rule, psi, x, np.arange(len(u)), status == SOLVED)
    return int(np.count_nonzero(status == FAILED))


def rescue_many(
    breaks: Numbers, kappa: Numbers, soft: Numbers, rule: Rule, R: Numbers, reach: float,
    angles: Numbers, psi: Numbers, x: Numbers, status: Numbers,
) -> int:  # fmt: skip
    """As `kernel.rescue_many`."""
    for attempt in range(2):
        left = np.flatnonzero(status == FAILED if attempt == 0 else status != SOLVED)
        if not len(left):
            break
        case = _case(breaks, kappa, soft, R, angles).pick(left)
        free, polar = _free(case, rule)
        if attempt == 0:
            v, done = _follow(case, free, replace(case, angle=polar), rule)
        else:
            straight = np.zeros_like(free)
            straight[:, -1] = 1.0001
            flat = replace(case, kappa=0.0 * case.kappa, angle=0.0 * case.angle)
            there = replace(flat, angle=case.angle)
            v, one = _follow(there, straight, flat, rule)
            v, done = _follow(case, v, there, rule)
            done &= one
        found = np.where(v[:, -1] * case.R <= reach, SOLVED, SLIPPED)
        status[left] = np.where(done, found, status[left])
        _store(case, v, rule, psi, x, left, done)
    return int(np.count_nonzero(status == FAILED))


def _store(
    case: Case, u: Numbers, r: Rule, psi: Numbers, x: Numbers, rows: Numbers, done: Numbers
) -> None:
    """Write unknowns where they belong, for the problems that are done."""
    shaped = u[:, :-2].reshape(len(u), *psi.shape[1:])
    nu, s_hat = u[:, -2] / case.R**2, u[:, -1] * case.R
    phi_hat = -_loaded(case, shaped, nu, s_hat, r).psi_end
    psi[rows[done]] = shaped[done]
    x[rows[done]] = np.stack([nu, s_hat, phi_hat], axis=1)[done]


def _points(case: Case, u: Numbers, s: Numbers, r: Rule) -> tuple[Numbers, Numbers]:
    """x, y, phi, k at s (S,) for one problem (4, S), and the integral of the lever."""
    P, n = len(case.breaks) - 1, len(r.c)
    nu = u[:, -2] / case.R**2
    on = _loaded(case, u[:, :-2].reshape(1, P, n), nu, u[:, -1] * case.R, r)
    phi_hat, top, m = -on.psi_end, on.top[0], on.panel[0]
    # the panels of the loaded part, ascending, each seen from its clamp side
    phi, push, h = (phi_hat + on.psi)[0, :, ::-1], on.push[0, :, ::-1], on.h[0]
    steps = np.stack([h * (np.cos(phi) @ r.b), h * (np.sin(phi) @ r.b), h * (push @ r.b)])
    start = np.concatenate([np.zeros((3, 1)), np.cumsum(steps, axis=1)], axis=1)
    x_hat, y_hat = case.R[0] * np.cos(case.angle[0]), case.R[0] * np.sin(case.angle[0])
    out = np.zeros((4, len(s)), dtype=np.result_type(u, case.kappa, case.angle, case.length))
    for i, place in enumerate(s):
        at = min(place, top.real)
        p = min(int(np.clip(np.searchsorted(case.breaks, at, side="right") - 1, 0, P - 1)), int(m))
        at = top if place > top.real else place
        theta = (at - case.breaks[p]) / h[p]
        w = 0.5 * h[p] * (integrated_legendre(np.array([2.0 * theta - 1.0]), n) @ r.T)[0]
        x, y = start[0, p] + w @ np.cos(phi[p]), start[1, p] + w @ np.sin(phi[p])
        k, turned = _polynomial(case.breaks, case.kappa, np.array([p]), np.array([at]))
        angle = turned[0] - nu[0] * (start[2, p] + w @ push[p])
        lever = (x_hat - x) * np.cos(phi_hat[0]) + (y_hat - y) * np.sin(phi_hat[0])
        if case.soft.shape[2]:
            lever *= _polynomial(case.breaks, case.soft, np.array([p]), np.array([at]))[0][0]
        k = k[0] - nu[0] * lever
        if place > top.real:
            x, y, angle, k = _tail(case, x, y, angle, top, place, r)
        out[:, i] = x, y, angle, k
    return out, (h * (on.a[0] @ r.b)).sum()


def _tail(case: Case, x: Any, y: Any, phi: Any, top: Any, place: float, r: Rule) -> tuple[Any, ...]:
    """Beyond the contact: the free sheet, then the elongation's straight line."""
    inner = [b for b in case.breaks if top.real < b < min(place, case.length[0].real)]
    end = case.length[0] if place > case.length[0].real else place
    edges = [top, *inner, end]
    k: Any = np.zeros(1)
    for low, high in pairwise(edges):
        s = low + (high - low) * np.concatenate([[0.0], r.c, [1.0]])
        last = len(case.breaks) - 2
        middle = 0.5 * (low + high).real
        p = np.full(len(s), np.clip(np.searchsorted(case.breaks, middle) - 1, 0, last))
        k, turned = _polynomial(case.breaks, case.kappa, p[None], s[None])
        k, angles = k[0], phi + turned[0] - turned[0, 0]
        x = x + (high - low) * (np.cos(angles[1:-1]) @ r.b)
        y = y + (high - low) * (np.sin(angles[1:-1]) @ r.b)
        phi = angles[-1]
    if place > case.length[0].real:
        beyond = place - case.length[0]
        return x + beyond * np.cos(phi), y + beyond * np.sin(phi), phi, 0.0
    return x, y, phi, k[-1]


def describe_many(
    breaks: Numbers, kappa: Numbers, soft: Numbers, rule: Rule, R: Numbers, angles: Numbers,
    psi: Numbers, x: Numbers, good: Numbers, s: Numbers, to: Any,
    out: Numbers, lever: Numbers, dx: Numbers, dout: Numbers,
) -> None:  # fmt: skip
    """As `kernel.describe_many`; derivatives by a complex step along solution and parameter."""
    case = _case(breaks, kappa, soft, R, angles)
    each = case.R[:, None]
    u = np.concatenate([psi.reshape(len(psi), -1), x[:, :1] * each**2, x[:, 1:2] / each], axis=1)
    for k in np.flatnonzero(good).tolist():
        rows, places = np.array([k]), s[min(k, len(s) - 1)]
        one = case.pick(rows)
        values, lever[k] = _points(one, u[rows], places, rule)
        out[k] = values.T
        for q in range(dx.shape[1]):
            moved = _moved(one, to, min(k, len(to.kappa) - 1), q)
            push = _residual(moved, u[rows].astype(complex), rule).imag[0]
            du = -np.linalg.solve(_jacobian(one, u[rows], rule)[0], push)
            v = u[rows] + 1j * du
            shape = _points(moved, v, places, rule)[0].imag / TINY
            P, n = len(breaks) - 1, len(rule.c)
            on = _loaded(
                moved, v[:, :-2].reshape(1, P, n), v[:, -2] / moved.R**2, v[:, -1] * moved.R, rule
            )
            dx[k, q] = [
                (v[0, -2] / moved.R[0] ** 2).imag / TINY,
                (v[0, -1] * moved.R[0]).imag / TINY,
                -on.psi_end[0].imag / TINY,
            ]
            dout[k, q] = shape[:2].T


def _moved(case: Case, to: Any, g: int, q: int) -> Case:
    """Return the problem with parameter q moved by an imaginary step."""
    i = 1j * TINY
    soft = case.soft + i * to.softness[g, q] if to.softness.shape[3] else case.soft
    return replace(
        case, kappa=case.kappa + i * to.kappa[g, q], soft=soft, R=case.R + i * to.radius[g, q],
        length=case.length + i * to.length[g, q], angle=case.angle + i * to.angle[g, q],
    )  # fmt: skip
