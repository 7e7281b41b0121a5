"""How solved problems answer to their parameters, by the implicit function theorem."""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from model.jit import Array, jit, jit_inside
from model.mechanics.kernel.newton import closure, sweep
from model.mechanics.kernel.panel import Work, is_nonzero, new_work, panel_of, polynomial
from model.mechanics.kernel.shape import (
    CurveBuffer,
    lever_integral,
    new_curve_buffer,
    points,
    unroll,
)


class Moves(NamedTuple):
    """Parameters to differentiate by, Q of them."""

    kappa: Array  # (Q, P, D) change of k*(s)
    soft: Array  # (Q, P, Dc) change of c(s)
    angle: Array  # (Q,) change of the contact's polar angle
    radius: Array  # (Q,) of R
    length: Array  # (Q,) of l


@jit_inside
def answers(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float, psi: Array,
    x: Array, to: Moves, columns: Array, w: Work, dx: Array,
) -> None:  # fmt: skip
    """How nu, s_hat, phi_hat answer to the parameters: dx (Q, 3); `columns` as by sweep."""
    ends = sweep(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        psi=psi,
        nu=x[0],
        s_hat=x[1],
        dkappa=to.kappa,
        dsoft=to.soft,
        dlength=to.length,
        columns=columns,
        w=w,
    )
    n1, n2 = closure(R, angle, ends, w, 0)
    s1, s2 = closure(R, angle, ends, w, 1)
    determinant = n1 * s2 - n2 * s1
    cos, sin = np.cos(angle + ends[0]), np.sin(angle + ends[0])
    for q in range(len(dx)):
        r1, r2 = closure(R, angle, ends, w, 2 + q)
        r1 += R * sin * to.angle[q] - cos * to.radius[q]
        r2 -= R * cos * to.angle[q] + sin * to.radius[q]
        dx[q, 0] = -(r1 * s2 - r2 * s1) / determinant
        dx[q, 1] = -(n1 * r2 - n2 * r1) / determinant
        dx[q, 2] = -(w.ends[0, 2 + q] + w.ends[0, 0] * dx[q, 0] + w.ends[0, 1] * dx[q, 1])


@jit_inside
def turning(
    breaks: Array, kappa: Array, rule: Any, x: Array, to: Moves, columns: Array, dx: Array,
    strip: CurveBuffer, count: int, dphi: Array,
) -> None:  # fmt: skip
    """How phi at the strip's nodes answers to the parameters, at fixed s: dphi (P + 1, Q, n)."""
    n, length = len(rule.c), breaks[-1]
    on_sheet = x[1] < length
    top = min(x[1], length)
    contact = panel_of(breaks, top)
    half = 0.5 * (breaks[contact + 1] - breaks[contact])
    k_top, _, _ = polynomial(kappa[contact], (top - breaks[contact]) / half - 1.0, half)
    for q in range(len(dx)):
        rate = dx[q, 1] if on_sheet else to.length[q]
        tail = dx[q, 2] - k_top * rate
        for m in range(count):
            p, low, high = strip.of[m], strip.edges[m], strip.edges[m + 1]
            half, h = 0.5 * (breaks[p + 1] - breaks[p]), high - low
            t_low = (low - breaks[p]) / half - 1.0
            moves = high > top and is_nonzero(to.kappa[q, p])  # beyond the contact
            K_low = polynomial(to.kappa[q, p], t_low, half)[1] if moves else 0.0
            for j in range(n):
                t, i = t_low + h * rule.c[j] / half, n - 1 - j
                if high > top:
                    K = polynomial(to.kappa[q, p], t, half)[1] if moves else 0.0
                    dphi[m, q, j] = tail + K - K_low
                    continue
                change = columns[p, i, 2 + q]
                change += columns[p, i, 0] * dx[q, 0] + columns[p, i, 1] * dx[q, 1]
                if p == contact:  # its nodes move with the contact
                    k, _, _ = polynomial(kappa[p], t, half)
                    change -= (k - x[0] * strip.push[m, j]) * rule.c[j] * rate
                dphi[m, q, j] = dx[q, 2] + change
            if moves:
                tail += polynomial(to.kappa[q, p], t_low + h / half, half)[1] - K_low


@jit
def describe_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: Array, angles: Array, psi: Array,
    x: Array, good: Array, s: Array, to: Any, out: Array, lever: Array, dx: Array, dout: Array,
) -> None:  # fmt: skip
    """Shapes of solved problems at s (K, S), and the answers of all to Q parameters.

    `to` holds `Moves` whose arrays lead with K (or with 1: the same for all). Filled are
    out (K, S, 4) = x, y, phi, k; lever (K,) the integral of a; dx (K, Q, 3); dout (K, Q, S, 2).
    """
    n, P, Q = len(rule.c), len(breaks) - 1, dx.shape[1]
    w = new_work(n, 2 + Q)
    columns = np.zeros((P, n, 2 + Q))
    strip, weights, dphi = new_curve_buffer(P, n), np.zeros((3, n)), np.zeros((P + 1, Q, n))
    for k in range(len(x)):
        if not good[k]:
            continue
        c, radius = soft[min(k, len(soft) - 1)], R[min(k, len(R) - 1)]
        nu, top = x[k, 0], min(x[k, 1], breaks[-1])
        a_clamp = radius * np.cos(angles[k] - x[k, 2])
        count = unroll(
            breaks=breaks,
            kappa=kappa[k],
            soft=c,
            rule=rule,
            psi=psi[k],
            nu=nu,
            top=top,
            phi_hat=x[k, 2],
            a_clamp=a_clamp,
            strip=strip,
        )
        lever[k] = lever_integral(rule, strip, count)
        if Q > 0:
            g = min(k, len(to.kappa) - 1)
            here = Moves(to.kappa[g], to.softness[g], to.angle[g], to.radius[g], to.length[g])
            answers(
                breaks=breaks,
                kappa=kappa[k],
                soft=c,
                rule=rule,
                R=radius,
                angle=angles[k],
                psi=psi[k],
                x=x[k],
                to=here,
                columns=columns,
                w=w,
                dx=dx[k],
            )
            turning(
                breaks=breaks,
                kappa=kappa[k],
                rule=rule,
                x=x[k],
                to=here,
                columns=columns,
                dx=dx[k],
                strip=strip,
                count=count,
                dphi=dphi,
            )
        points(
            breaks=breaks, kappa=kappa[k], soft=c, rule=rule, nu=nu, top=top, phi_hat=x[k, 2],
            x_hat=radius * np.cos(angles[k]), y_hat=radius * np.sin(angles[k]), strip=strip,
            count=count, s=s[min(k, len(s) - 1)], dphi=dphi, dphi_hat=dx[k, :, 2], out=out[k],
            dout=dout[k], weights=weights,
        )  # fmt: skip
