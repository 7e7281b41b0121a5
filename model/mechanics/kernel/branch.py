"""The branch followed step by step, for problems that Newton does not solve at once."""

from __future__ import annotations

from typing import Any

import numpy as np

from model.jit import Array, jit, jit_inside
from model.mechanics.kernel.newton import newton
from model.mechanics.kernel.panel import Work, new_work
from model.mechanics.kernel.start import free_crossing, free_start

SOLVED, SLIPPED, FAILED = 0, 1, 2


@jit
def keep(psi: Array, x: Array, to_psi: Array, to_x: Array) -> None:
    """Copy a state; loops, for slices cost seconds of compiling."""
    for i in range(len(x)):
        to_x[i] = x[i]
    for p in range(psi.shape[0]):
        for j in range(psi.shape[1]):
            to_psi[p, j] = psi[p, j]


@jit
def march(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, start: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> tuple[int, float]:  # fmt: skip
    """Follow the branch from the equilibrium at `start` to `angle`, as fast as Newton likes."""
    kept, kept_x, before = np.empty_like(psi), np.empty_like(x), np.empty_like(x)
    keep(psi, x, kept, kept_x)
    at, last, step, determinant = start, 0.0, 0.1, 0.0
    while at != angle:
        step = min(step, 0.3)
        aim = angle if abs(angle - at) <= step else at + np.copysign(step, angle - at)
        if last > 0.0:  # secant predictor
            for i in range(2):
                x[i] += (kept_x[i] - before[i]) * abs(aim - at) / last
            x[1] = max(x[1], 0.98 * R)
        steps, found = newton(
            breaks=breaks, kappa=kappa, soft=soft, rule=rule, R=R, angle=aim, psi=psi, x=x,
            columns=columns, w=w,
        )  # fmt: skip
        turned = determinant != 0.0 and found * determinant <= 0.0
        if steps == 0 or turned or abs(x[1] - kept_x[1]) > 0.1 * R:
            keep(kept, kept_x, psi, x)
            step *= 0.4
            if step < 1e-4:
                return 0, 0.0
        else:
            for i in range(2):
                before[i] = kept_x[i]
            last = abs(aim - at)
            keep(psi, x, kept, kept_x)
            at, determinant = aim, found
            step *= 2.0 if steps <= 5 else 1.0
    return 1, determinant


@jit_inside
def from_free(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> int:  # fmt: skip
    """Follow the branch from the free shape to the position."""
    s_free, free = free_crossing(breaks, kappa, rule, R)
    x[0], x[1] = 0.0, s_free
    free_start(breaks, kappa, rule, s_free, psi)
    steps, _ = newton(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        R=R,
        angle=free,
        psi=psi,
        x=x,
        columns=columns,
        w=w,
    )
    if steps == 0:
        return 0
    return march(
        breaks=breaks,
        kappa=kappa,
        soft=soft,
        rule=rule,
        R=R,
        start=free,
        angle=angle,
        psi=psi,
        x=x,
        columns=columns,
        w=w,
    )[0]


@jit_inside
def from_straight(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: float, angle: float,
    psi: Array, x: Array, columns: Array, w: Work,
) -> int:  # fmt: skip
    """Bring a straight sheet to the position, then let its free curvature grow."""
    scaled, kept, kept_x = np.zeros_like(kappa), np.zeros_like(psi), np.zeros_like(x)
    keep(kept, kept_x, psi, x)
    x[1] = R * 1.0001
    if (
        march(
            breaks=breaks,
            kappa=scaled,
            soft=soft,
            rule=rule,
            R=R,
            start=0.0,
            angle=angle,
            psi=psi,
            x=x,
            columns=columns,
            w=w,
        )[0]
        == 0
    ):
        return 0
    keep(psi, x, kept, kept_x)
    at, step = 0.0, 0.25
    while at < 1.0:
        aim = min(at + step, 1.0)
        for p in range(kappa.shape[0]):
            for d in range(kappa.shape[1]):
                scaled[p, d] = aim * kappa[p, d]
        steps, _ = newton(
            breaks=breaks,
            kappa=scaled,
            soft=soft,
            rule=rule,
            R=R,
            angle=angle,
            psi=psi,
            x=x,
            columns=columns,
            w=w,
        )
        if steps == 0 or abs(x[1] - kept_x[1]) > 0.1 * R:
            keep(kept, kept_x, psi, x)
            step *= 0.4
            if step < 1e-3:
                return 0
        else:
            keep(psi, x, kept, kept_x)
            at = aim
            step *= 1.6 if steps <= 6 else 1.0
    return 1


@jit
def rescue_many(
    breaks: Array, kappa: Array, soft: Array, rule: Any, R: Array, reach: float, angles: Array,
    psi: Array, x: Array, status: Array,
) -> int:  # fmt: skip
    """Every problem that is still FAILED, step by step along its branch; returns what is left."""
    w = new_work(len(rule.c), 3)
    columns, left = np.zeros((len(breaks) - 1, len(rule.c), 3)), 0
    for k in range(len(angles)):
        if status[k] != FAILED:
            continue
        c, radius, ways = soft[min(k, len(soft) - 1)], R[min(k, len(R) - 1)], 0
        # curled away from the arc when free, a sheet may yet be held by the rolls: second way
        for way in range(2):
            if way == 0:
                found = from_free(
                    breaks=breaks,
                    kappa=kappa[k],
                    soft=c,
                    rule=rule,
                    R=radius,
                    angle=angles[k],
                    psi=psi[k],
                    x=x[k],
                    columns=columns,
                    w=w,
                )
            else:
                found = from_straight(
                    breaks=breaks,
                    kappa=kappa[k],
                    soft=c,
                    rule=rule,
                    R=radius,
                    angle=angles[k],
                    psi=psi[k],
                    x=x[k],
                    columns=columns,
                    w=w,
                )
            ways += found
            if found > 0 and x[k, 1] <= reach:
                status[k] = SOLVED
                break
        if status[k] == FAILED and ways > 0:
            status[k] = SLIPPED
        left += 1 if status[k] == FAILED else 0
    return left
