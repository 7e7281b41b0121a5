"""One step in time of a chain of links with masses, compiled. Import this where it is used.

Link 0, of length h/2, is the clamp's; links 1 to n of length h follow, the last one as far as the
sheet and its elongation go. Hinge i, at the start of link i, stands for the sheet between (i - 1) h
and i h: its spring, its loss and its mass. Two further masses on the last link are the elongation.

The equation of motion is taken at each grid time, with second differences of the positions in
space for the acceleration and a mean over three times, (b, 1 - 2 b, b), for what bends:

    J(q1)^T m (X2 - 2 X1 + X0) / dt^2 + <elastic, viscous, Prony>(q0, q1, q2) = Me(t1) - N1 J_c(q1)

For a linear chain this is Newmark's method with gamma = 1/2, beta = b; with the constraint at the
new time and its force at the present one, it is a variational integrator (Marsden & West 2001,
sections 2.3 and 3.5): second order, and without numerical damping. With b = 1/4 the springs would
not feel what changes its sign at every step, and the massless end of the sheet would do that.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from sim_hardware.jit import brief_jit
from sim_hardware.world.motion.touch import levers, touched

Floats = npt.NDArray[np.float64]

STEPPED, SLIPPED, LOST = 0, 1, 2
BETA = 0.3
_ROUNDS = 25
_ENOUGH_RAD = 1e-8  # Newton's last step; the error after it is about its square
_MOST_RAD = 1.0
_FIRST_LINKS = 4.0  # nearer to the clamp nothing touches


class Links(NamedTuple):
    """The chain; arrays (n + 1,) with one entry a hinge, 0 of them for the clamp's link."""

    h_m: float
    rest_rad: Floats  # turn of the hinge at rest: k0 h
    spring_Nm: Floats  # B/h, per radian, after all has relaxed
    mass_kg: Floats
    span_m: Floats  # length of sheet that the mass stands for
    bar_at_m: Floats  # (2,) from the last hinge, along the last link
    bar_kg: Floats  # (2,)
    bar_span_m: Floats  # (2,)
    viscous_s: float  # Kelvin-Voigt: viscous moment over elastic, per rate
    share: Floats  # (p,) of B, each with ...
    relax_s: Floats  # (p,) ... its time
    added_kg_per_m: float  # of the fluid, for movement along the normal
    normal_Ns_per_m2: float  # its drag along the normal, linear
    quadratic_Ns2_per_m3: float  # and quadratic
    tangential_Ns_per_m2: float  # and along the sheet
    load_N_per_m: float  # weight along y


@brief_jit
def lay(phi: Floats, h: float, towards: Floats, at: Floats) -> None:
    """Directions of the links and the places of their hinges, into `towards`, `at` (n + 1, 2)."""
    for i in range(phi.shape[0]):
        towards[i, 0] = math.cos(phi[i])
        towards[i, 1] = math.sin(phi[i])
    at[0] = 0.0
    for i in range(1, phi.shape[0]):
        length = 0.5 * h if i == 1 else h
        at[i, 0] = at[i - 1, 0] + length * towards[i - 1, 0]
        at[i, 1] = at[i - 1, 1] + length * towards[i - 1, 1]


@brief_jit
def _hinges(
    links: Links, stiff: float, dt: float, phi: Floats, lag: Floats, now: int, known: Floats
) -> float:
    """Fill what is known of the hinges' moments; return the factor of the new turn in them.

    `known` (n + 1,): moment but for that part. `phi` (3, n + 1), `lag` (2, p, n + 1): now, before.
    """
    factor, total = BETA + 0.5 * links.viscous_s / dt, 1.0
    for p in range(links.share.shape[0]):
        total += links.share[p]
        factor += BETA * links.share[p] / (1.0 + 0.5 * dt / links.relax_s[p])
    before = 1 - now
    for i in range(1, phi.shape[1]):
        old = phi[0, i] - phi[0, i - 1]
        mid = phi[1, i] - phi[1, i - 1]
        turn = total * (BETA * old + (1.0 - 2.0 * BETA) * mid - links.rest_rad[i])
        turn -= 0.5 * links.viscous_s / dt * old
        for p in range(links.share.shape[0]):
            x = 0.5 * dt / links.relax_s[p]
            strain = mid - 2.0 * links.rest_rad[i]
            new = ((1.0 - x) * lag[now, p, i] + x * strain) / (1.0 + x)
            mean = BETA * (new + lag[before, p, i]) + (1.0 - 2.0 * BETA) * lag[now, p, i]
            turn -= links.share[p] * mean
        known[i] = stiff * links.spring_Nm[i] * turn
    return factor


@brief_jit
def _relax(links: Links, dt: float, phi: Floats, lag: Floats, now: int) -> None:
    """Move the Prony terms on, over those before: they lag behind the turns (trapezoidal)."""
    before = 1 - now
    for p in range(links.share.shape[0]):
        x = 0.5 * dt / links.relax_s[p]
        for i in range(1, phi.shape[1]):
            turns = phi[1, i] - phi[1, i - 1] + phi[2, i] - phi[2, i - 1]
            strain = turns - 2.0 * links.rest_rad[i]
            lag[before, p, i] = ((1.0 - x) * lag[now, p, i] + x * strain) / (1.0 + x)


@brief_jit
def _pull(
    links: Links, dt: float, mass: float, span: float, nx: float, ny: float,
    x: Floats, out: Floats,
) -> None:  # fmt: skip
    """Force that a mass and the fluid about it ask for, and its derivative by the new place.

    `x` (3, 2): its places at three times; (nx, ny): the sheet's normal. Into `out` (5,): the force,
    then xx, xy, yy of the derivative.
    """
    ax = (x[2, 0] - 2.0 * x[1, 0] + x[0, 0]) / (dt * dt)
    ay = (x[2, 1] - 2.0 * x[1, 1] + x[0, 1]) / (dt * dt)
    vx, vy = (x[2, 0] - x[0, 0]) / (2.0 * dt), (x[2, 1] - x[0, 1]) / (2.0 * dt)
    vn, vt = vx * nx + vy * ny, vx * ny - vy * nx
    added = span * links.added_kg_per_m
    along = span * links.tangential_Ns_per_m2 * vt
    drag = span * (links.normal_Ns_per_m2 + links.quadratic_Ns2_per_m3 * abs(vn)) * vn
    normal = added * (ax * nx + ay * ny) + drag
    out[0] = mass * ax + normal * nx + along * ny
    out[1] = mass * ay + normal * ny - along * nx - links.load_N_per_m * span
    slope = links.normal_Ns_per_m2 + 2.0 * links.quadratic_Ns2_per_m3 * abs(vn)
    nn = added / (dt * dt) + 0.5 * span * slope / dt
    tt = 0.5 * span * links.tangential_Ns_per_m2 / dt
    inert = mass / (dt * dt)
    out[2] = inert + nn * nx * nx + tt * ny * ny
    out[3] = (nn - tt) * nx * ny
    out[4] = inert + nn * ny * ny + tt * nx * nx


@brief_jit
def _pulls(links: Links, dt: float, towards: Floats, at: Floats, pull: Floats) -> None:
    """Fill `pull` (n + 3, 5) of the masses at the hinges, and, in the last two rows, of the bar."""
    last = at.shape[1] - 1
    x = np.empty((3, 2))
    for i in range(2, last + 1):
        tx = towards[1, i - 1, 0] + towards[1, i, 0]
        ty = towards[1, i - 1, 1] + towards[1, i, 1]
        size = math.hypot(tx, ty)
        for k in range(3):
            x[k, 0], x[k, 1] = at[k, i, 0], at[k, i, 1]
        nx, ny = -ty / size, tx / size
        _pull(
            links, dt, mass=links.mass_kg[i], span=links.span_m[i], nx=nx, ny=ny, x=x, out=pull[i]
        )
    for b in range(2):
        for k in range(3):
            for c in range(2):
                x[k, c] = at[k, last, c] + links.bar_at_m[b] * towards[k, last, c]
        nx, ny = -towards[1, last, 1], towards[1, last, 0]
        _pull(
            links, dt, mass=links.bar_kg[b], span=links.bar_span_m[b], nx=nx, ny=ny, x=x,
            out=pull[last + 1 + b],
        )  # fmt: skip


@brief_jit
def _solve(
    links: Links, spring: Floats, towards: Floats, pull: Floats, work: Floats, right: Floats
) -> None:
    """Replace `right` (n + 1, 2) by the turns of the links that it asks for; O(n).

    From the end towards the clamp, the force and the moment at each hinge are eliminated as linear
    functions of the hinge's displacement and the turn of the link before it. `spring` (n + 1,):
    derivative of a hinge's moment; `work` (n + 1, 5).
    """
    h, last = links.h_m, right.shape[0] - 1
    exx = exy = eyx = eyy = ex = ey = fx = fy = g = 0.0
    t0x = t0y = t1x = t1y = m0 = m1 = 0.0
    for i in range(last, 0, -1):
        ax, ay = -towards[1, i, 1], towards[1, i, 0]  # what a force does to the link
        bx, by = -towards[2, i, 1], towards[2, i, 0]  # where its end goes
        c = spring[i]
        if i == last:  # nothing beyond but the bar
            ux = uy = vx = vy = across = 0.0
            for b in range(2):
                d = links.bar_at_m[b]
                xx, xy, yy = pull[last + 1 + b, 2], pull[last + 1 + b, 3], pull[last + 1 + b, 4]
                exx += xx
                exy += xy
                eyx += xy
                eyy += yy
                ux += d * (xx * ax + xy * ay)
                uy += d * (xy * ax + yy * ay)
                vx += d * (xx * bx + xy * by)
                vy += d * (xy * bx + yy * by)
                across += d * d * (ax * (xx * bx + xy * by) + ay * (xy * bx + yy * by))
            pivot = across + c
            q0, q1 = right[i, 0], right[i, 1]
        else:
            vx, vy = h * (exx * bx + exy * by) + ex, h * (eyx * bx + eyy * by) + ey
            ux, uy = h * (exx * ax + eyx * ay) - fx, h * (exy * ax + eyy * ay) - fy
            pivot = h * (ax * vx + ay * vy) + c - h * (fx * bx + fy * by) - g
            q0 = right[i, 0] - h * (ax * t0x + ay * t0y) + m0
            q1 = right[i, 1] - h * (ax * t1x + ay * t1y) + m1
        over = 1.0 / pivot
        work[i, 0], work[i, 1], work[i, 2] = ux * over, uy * over, c * over
        work[i, 3], work[i, 4] = q0 * over, q1 * over
        vx, vy = vx * over, vy * over
        exx += pull[i, 2] - vx * ux
        exy += pull[i, 3] - vx * uy
        eyx += pull[i, 3] - vy * ux
        eyy += pull[i, 4] - vy * uy
        ex, ey = vx * c, vy * c
        t0x, t0y, t1x, t1y = t0x + vx * q0, t0y + vy * q0, t1x + vx * q1, t1y + vy * q1
        fx, fy, g = -c * ux * over, -c * uy * over, c * (c * over - 1.0)
        m0, m1 = c * q0 * over, c * q1 * over
    x0 = y0 = x1 = y1 = d0 = d1 = 0.0
    for i in range(1, last + 1):
        ux, uy, back = work[i, 0], work[i, 1], work[i, 2]
        d0 = work[i, 3] + back * d0 - ux * x0 - uy * y0
        d1 = work[i, 4] + back * d1 - ux * x1 - uy * y1
        right[i, 0], right[i, 1] = d0, d1
        bx, by = -h * towards[2, i, 1], h * towards[2, i, 0]
        x0, y0, x1, y1 = x0 + bx * d0, y0 + by * d0, x1 + bx * d1, y1 + by * d1


@brief_jit
def _residual(links: Links, towards: Floats, pull: Floats, bending: Floats, right: Floats) -> None:
    """Unbalanced moment of each link, without the contact, into the first column of `right`."""
    last = right.shape[0] - 1
    x = y = 0.0
    for i in range(last, 0, -1):
        nx, ny = -towards[1, i, 1], towards[1, i, 0]
        value = bending[i]
        if i < last:
            value += links.h_m * (nx * x + ny * y) - bending[i + 1]
        else:
            for b in range(2):
                px, py = pull[last + 1 + b, 0], pull[last + 1 + b, 1]
                value += links.bar_at_m[b] * (nx * px + ny * py)
                x += px
                y += py
        x += pull[i, 0]
        y += pull[i, 1]
        right[i, 0] = value


class Room(NamedTuple):
    """Memory that a chain's steps work in; see `room`."""

    towards: Floats  # (3, n + 1, 2)
    at: Floats  # (3, n + 1, 2)
    pull: Floats  # (n + 3, 5)
    right: Floats  # (n + 1, 2)
    work: Floats  # (n + 1, 5)
    line: Floats  # (5, n + 1): known moments, springs, moments, levers at the old, new contact


def room(n: int) -> Room:
    """Memory for a chain of n links."""
    return Room(
        np.zeros((3, n + 1, 2)), np.zeros((3, n + 1, 2)), np.zeros((n + 3, 5)),
        np.zeros((n + 1, 2)), np.zeros((n + 1, 5)), np.zeros((5, n + 1)),
    )  # fmt: skip


@brief_jit
def _hold(
    towards: Floats, h: float, contact: Floats, roll_x: float, roll_y: float,
    lever: Floats, old: Floats, right: Floats,
) -> float:  # fmt: skip
    """Correct the turns so that the sheet passes through the rolls; return how far they slid, m.

    `contact` (2,): s, which moves along, and N, which is found. `right` (n + 1, 2): the turns
    without a contact, and per unit of its force.
    """
    x, y, tx, ty = touched(towards, contact[0], h)
    size = math.hypot(tx, ty)
    nx, ny = -ty / size, tx / size
    levers(towards, contact[0], h, nx, ny, lever)
    gap = nx * (roll_x - x) + ny * (roll_y - y)
    free = force = 0.0
    for i in range(1, right.shape[0]):
        free += lever[i] * right[i, 0]
        force += lever[i] * right[i, 1]
    contact[1] = -(gap + free) / force
    levers(towards, contact[0], h, tx / size, ty / size, old)
    slid = (tx * (roll_x - x) + ty * (roll_y - y)) / size
    for i in range(1, right.shape[0]):
        right[i, 0] += contact[1] * right[i, 1]
        slid += old[i] * right[i, 0]
    slid /= size
    contact[0] += slid
    return slid


@brief_jit
def step(
    links: Links, stiff: float, dt: float, phi: Floats, lag: Floats, now: int, moment: Floats,
    contact: Floats, held: bool, roll_x: float, roll_y: float, end_m: float, space: Room,
) -> int:  # fmt: skip
    """Find the links' angles at the next time.

    `phi` (3, n + 1): angles before, now, and then, the clamp's (0) given for all three; the last
    row is a guess and becomes the answer. `stiff`: all of B over that of `links`. `lag` (2, p,
    n + 1): the Prony terms now and before, `now` says which is which; the other becomes the next.
    `moment` (n + 1,): Me now. `contact` (3,): where along the sheet it is held now, and what for is
    found: the force N now, where it is held then. (roll_x, roll_y): where it must pass then.
    """
    h, last = links.h_m, phi.shape[1] - 1
    towards, at, right = space.towards, space.at, space.right
    known, spring, bending, lever, other = (
        space.line[0], space.line[1], space.line[2], space.line[3], space.line[4],
    )  # fmt: skip
    for k in range(2):
        lay(phi[k], h, towards[k], at[k])
    factor = _hinges(links, stiff, dt, phi, lag, now, known)
    for i in range(1, last + 1):
        spring[i] = factor * stiff * links.spring_Nm[i]
        known[i] -= moment[i]
    pushed, place = np.zeros(last + 1), np.empty(2)
    if held:
        _, _, tx, ty = touched(towards[1], contact[0], h)
        size = math.hypot(tx, ty)
        levers(towards[1], contact[0], h, -ty / size, tx / size, pushed)
    place[0], place[1] = contact[2], contact[1]
    for _ in range(_ROUNDS):
        lay(phi[2], h, towards[2], at[2])
        _pulls(links, dt, towards, at, space.pull)
        for i in range(1, last + 1):
            bending[i] = known[i] + spring[i] * (phi[2, i] - phi[2, i - 1])
        _residual(links, towards, space.pull, bending, right)
        for i in range(last + 1):
            right[i, 1] = pushed[i]
        _solve(links, spring, towards, space.pull, space.work, right)
        largest = 0.0
        if held:
            slid = _hold(towards[2], h, place, roll_x, roll_y, lever=lever, old=other, right=right)
            largest = abs(slid) / h * 1e-3
        for i in range(1, last + 1):
            phi[2, i] -= right[i, 0]
            largest = max(largest, abs(right[i, 0]))
        if not largest < _MOST_RAD:
            return LOST
        if held and not _FIRST_LINKS * h < place[0] < end_m:
            return SLIPPED
        if largest < _ENOUGH_RAD:
            contact[1], contact[2] = place[1], place[0]
            _relax(links, dt, phi, lag, now)
            return STEPPED
    return LOST
