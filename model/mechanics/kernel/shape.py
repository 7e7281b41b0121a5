"""Curves of solved problems at any s."""

# ruff: noqa: C901  (calls that numba does not inline cost more than they explain)
from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from model.jit import Array, jit, jit_inside
from model.mechanics.kernel.panel import polynomial


@jit
def legendre_weights(rule: Any, theta: float, out: Array, low: Array) -> None:
    """Weights on nodal values for the integral from 0 to theta (a share of the panel)."""
    n = len(rule.c)
    t = 2.0 * theta - 1.0
    before, now = 1.0, t
    low[0] = t + 1.0
    for k in range(1, n):
        after = ((2 * k + 1) * t * now - k * before) / (k + 1)
        low[k] = (after - before) / (2 * k + 1)
        before, now = now, after
    for j in range(n):
        total = 0.0
        for k in range(n):
            total += low[k] * rule.T[k, j]
        out[j] = 0.5 * total


class CurveBuffer(NamedTuple):
    """The sheet from the clamp on in ascending panels: one more where the contact cuts one."""

    edges: Array  # (P + 2,)
    of: Array  # (P + 1,) the panel of the problem each lies in
    phi: Array  # (P + 1, n) at ascending nodes
    cos: Array  # of phi
    sin: Array
    a: Array  # (P + 1, n) lever of the contact force; 0 in the tail
    push: Array  # (P + 1, n) c a
    x: Array  # (P + 2,) at the edges
    y: Array
    phi_edge: Array


@jit
def new_curve_buffer(P: int, n: int) -> CurveBuffer:
    """Room for a sheet of P panels."""
    return CurveBuffer(
        edges=np.zeros(P + 2), of=np.zeros(P + 1, dtype=np.int64), phi=np.zeros((P + 1, n)),
        cos=np.zeros((P + 1, n)), sin=np.zeros((P + 1, n)), a=np.zeros((P + 1, n)),
        push=np.zeros((P + 1, n)), x=np.zeros(P + 2), y=np.zeros(P + 2), phi_edge=np.zeros(P + 2),
    )  # fmt: skip


@jit
def cut(breaks: Array, top: float, strip: CurveBuffer) -> int:
    """Panels between the breaks and the contact; returns how many."""
    count = 0
    for p in range(len(breaks) - 1):
        strip.edges[count], strip.of[count] = breaks[p], p
        count += 1
        if breaks[p] < top < breaks[p + 1]:
            strip.edges[count], strip.of[count] = top, p
            count += 1
    strip.edges[count] = breaks[-1]
    return count


@jit_inside
def unroll(
    breaks: Array, kappa: Array, soft: Array, rule: Any, psi: Array, nu: float, top: float,
    phi_hat: float, a_clamp: float, strip: CurveBuffer,
) -> int:  # fmt: skip
    """Fill the strip from the clamp on; returns its number of panels."""
    n, count = len(rule.c), cut(breaks, top, strip)
    a_edge, cos_hat, sin_hat = a_clamp, np.cos(phi_hat), np.sin(phi_hat)
    strip.x[0] = strip.y[0] = strip.phi_edge[0] = 0.0
    for m in range(count):
        p, low, high = strip.of[m], strip.edges[m], strip.edges[m + 1]
        half, h, loaded = 0.5 * (breaks[p + 1] - breaks[p]), high - low, high <= top
        t_low, t_high = (low - breaks[p]) / half - 1.0, (high - breaks[p]) / half - 1.0
        _, K_low, _ = polynomial(kappa[p], t_low, half)
        _, K_high, _ = polynomial(kappa[p], t_high, half)
        run, rise, press = 0.0, 0.0, 0.0
        for j in range(n):
            if loaded:
                strip.phi[m, j] = phi_hat + psi[p, n - 1 - j]
            else:
                _, K, _ = polynomial(kappa[p], t_low + h * rule.c[j] / half, half)
                strip.phi[m, j] = strip.phi_edge[m] + K - K_low
            strip.cos[m, j], strip.sin[m, j] = np.cos(strip.phi[m, j]), np.sin(strip.phi[m, j])
            run += rule.b[j] * strip.cos[m, j]
            rise += rule.b[j] * strip.sin[m, j]
        for j in range(n):
            strip.a[m, j] = strip.push[m, j] = 0.0
            if loaded:
                a, c = a_edge, 1.0
                for k in range(n):
                    a -= h * rule.A[j, k] * (strip.cos[m, k] * cos_hat + strip.sin[m, k] * sin_hat)
                if soft.shape[1] > 0:
                    c, _, _ = polynomial(soft[p], t_low + h * rule.c[j] / half, half)
                strip.a[m, j], strip.push[m, j] = a, c * a
                press += rule.b[j] * c * a
        strip.x[m + 1] = strip.x[m] + h * run
        strip.y[m + 1] = strip.y[m] + h * rise
        strip.phi_edge[m + 1] = strip.phi_edge[m] + K_high - K_low - nu * h * press
        a_edge -= h * (run * cos_hat + rise * sin_hat)
    return count


@jit
def lever_integral(rule: Any, strip: CurveBuffer, count: int) -> float:
    """Integral of a over the loaded part."""
    total = 0.0
    for m in range(count):
        for j in range(len(rule.c)):
            total += (strip.edges[m + 1] - strip.edges[m]) * rule.b[j] * strip.a[m, j]
    return total


@jit_inside
def points(
    breaks: Array, kappa: Array, soft: Array, rule: Any, nu: float, top: float, phi_hat: float,
    x_hat: float, y_hat: float, strip: CurveBuffer, count: int, s: Array, dphi: Array,
    dphi_hat: Array, out: Array, dout: Array, weights: Array,
) -> None:  # fmt: skip
    """x, y, phi, k at each s into out (S, 4), answers of x, y into dout (Q, S, 2).

    dphi (P + 1, Q, n) is how phi at the strip's nodes answers, at fixed s; weights (3, n) is
    scratch.
    """
    n, Q, length = len(rule.c), dphi.shape[1], breaks[-1]
    cos_hat, sin_hat = np.cos(phi_hat), np.sin(phi_hat)
    dr = np.zeros((count + 1, Q, 2))
    for m in range(count):
        h = strip.edges[m + 1] - strip.edges[m]
        for q in range(Q):
            dx, dy = 0.0, 0.0
            for j in range(n):
                turn = h * rule.b[j] * dphi[m, q, j]
                dx -= turn * strip.sin[m, j]
                dy += turn * strip.cos[m, j]
            dr[m + 1, q, 0], dr[m + 1, q, 1] = dr[m, q, 0] + dx, dr[m, q, 1] + dy
    for i in range(len(s)):
        if s[i] > length:
            beyond, phi = s[i] - length, strip.phi_edge[count]
            out[i, 0] = strip.x[count] + beyond * np.cos(phi)
            out[i, 1] = strip.y[count] + beyond * np.sin(phi)
            out[i, 2], out[i, 3] = phi, 0.0
            for q in range(Q):
                dout[q, i, 0] = dr[count, q, 0] - beyond * np.sin(phi) * dphi_hat[q]
                dout[q, i, 1] = dr[count, q, 1] + beyond * np.cos(phi) * dphi_hat[q]
            continue
        m = count - 1
        while m > 0 and strip.edges[m] > s[i]:
            m -= 1
        p, low, h = strip.of[m], strip.edges[m], strip.edges[m + 1] - strip.edges[m]
        half = 0.5 * (breaks[p + 1] - breaks[p])
        t_low, t = (low - breaks[p]) / half - 1.0, (s[i] - breaks[p]) / half - 1.0
        legendre_weights(rule, (s[i] - low) / h, weights[0], weights[1])
        x, y, press = strip.x[m], strip.y[m], 0.0
        for j in range(n):
            weight = h * weights[0, j]
            weights[1, j], weights[2, j] = weight * strip.cos[m, j], weight * strip.sin[m, j]
            x += weights[1, j]
            y += weights[2, j]
            press += weight * strip.push[m, j]
        _, K_low, _ = polynomial(kappa[p], t_low, half)
        k, K, _ = polynomial(kappa[p], t, half)
        if s[i] <= top:
            lever = (x_hat - x) * cos_hat + (y_hat - y) * sin_hat
            if soft.shape[1] > 0:
                c, _, _ = polynomial(soft[p], t, half)
                lever *= c
            k -= nu * lever
        out[i, 0], out[i, 1] = x, y
        out[i, 2], out[i, 3] = strip.phi_edge[m] + K - K_low - nu * press, k
        for q in range(Q):
            dx, dy = dr[m, q, 0], dr[m, q, 1]
            for j in range(n):
                dx -= weights[2, j] * dphi[m, q, j]
                dy += weights[1, j] * dphi[m, q, j]
            dout[q, i, 0], dout[q, i, 1] = dx, dy
