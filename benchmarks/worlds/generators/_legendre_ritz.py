"""A clamped strip by the method of Ritz: the curvature that the load adds is a Legendre series.

Between clamp and contact, or the strip's end where the contact is on the elongation, the curvature
is that of the unloaded strip and softness times a sum of Legendre polynomials. Stationary is the
elastic energy less the work of the contact force, both by Gauss quadrature: the force is the
multiplier of the constraint that the sheet passes the rolls. Two hinges, at the clamp and where
the elongation begins, are further unknowns; without a give they stay as they are. Newton's method
finds all unknowns at once, from the strip at rest along a path of voltage and position.

Moments and forces are over the nominal stiffness B times the case's factor.
"""

from __future__ import annotations

from dataclasses import dataclass, fields, replace
from functools import cached_property
from typing import Protocol

import numpy as np
import numpy.typing as npt
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline

Array = npt.NDArray[np.float64]
Bools = npt.NDArray[np.bool_]

DEGREES, POINTS = 13, 36
HINGES = 2
FORCE, PLACE = DEGREES + HINGES, DEGREES + HINGES + 2  # first columns of the unknowns
UNKNOWNS = PLACE + 1
PATH, ROUNDS = 6, 25
LOOSE, ENOUGH = 1e-3, 1e-10
NUDGE_M = 1e-8  # of the derivative by the place of the contact
GRID = 1001
YIELDS = 12  # until a cell that gives way agrees with its force
PLAY_Nm = 2e-5  # load's moment that takes up three quarters of a clamp's play


def _gauss() -> tuple[Array, Array, Array, Array]:
    """Return nodes, weights, polynomials at them (POINTS, DEGREES), integrals up to them."""
    nodes, weights = legendre.leggauss(POINTS)
    whole = legendre.legvander(nodes, POINTS - 1)
    ends = legendre.legvander(nodes, POINTS)
    upto = np.empty_like(whole)
    upto[:, 0] = nodes + 1.0
    for j in range(1, POINTS):
        upto[:, j] = (ends[:, j + 1] - ends[:, j - 1]) / (2 * j + 1)
    return nodes, weights, whole[:, :DEGREES], upto @ np.linalg.inv(whole)


NODES, WEIGHTS, BASIS, UPTO = _gauss()
SERIES = np.linalg.inv(legendre.legvander(NODES, POINTS - 1))  # values at nodes -> coefficients


class Law(Protocol):
    """Moment over B of a strip bent by u (1/m) from its rest curvature."""

    def moment(self, u: Array) -> Array:
        """Return the moment over B."""

    def slope(self, u: Array) -> Array:
        """Return its derivative."""


@dataclass(frozen=True, kw_only=True)
class Strip:
    """What bends and holds. Functions of s on a grid from the clamp to the strip's end."""

    s_m: Array  # (GRID,)
    rest_per_m: Array
    driven_per_m: Array  # EIBM over B at +2 V
    even_per_m: Array  # moment over B that goes with the voltage squared, at 2 V
    soft: Array  # B over the local stiffness
    stiffness_Nm2: float
    radius_m: float
    elongation_m: float
    law: Law | None = None
    clamp_rad: float = 0.0
    clamp_rad_per_Nm: float = 0.0
    clamp_play_rad: float = 0.0
    joint_rad_per_Nm: float = 0.0
    beside_m: float = 0.0  # from the neutral curve to the arc's point, along the normal
    eccentric_m: float = 0.0  # by which that swings as the roll turns
    roll_m: float = 2.5e-3  # radius of the roll
    arc_x_m: float = 0.0  # centre of the arc
    arc_y_m: float = 0.0
    cell_m_per_N: float = 0.0
    weight_N_per_m: float = 0.0  # along -y
    friction: float = 0.0

    @property
    def length_m(self) -> float:
        """Return the free length."""
        return float(self.s_m[-1])


@dataclass(frozen=True, kw_only=True)
class Cases:
    """One equilibrium each; (n,)."""

    drive: Array  # EIBM over that at +2 V
    even: Array
    rest_per_m: Array  # more than the strip's, everywhere
    stiffness: Array  # factor of B
    place_m: Array  # of the arc's point; NaN: free
    way: Array  # of the rolls' friction on the sheet, along its tangent

    def take(self, rows: npt.NDArray[np.intp] | Bools) -> Cases:
        """Return some of them."""
        return Cases(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})

    def at(self, share: float, begin_m: float) -> Cases:
        """Return what is so far on the way from rest."""
        place = begin_m + share * (self.place_m - begin_m)
        parts = {n: share * getattr(self, n) for n in ("drive", "even", "rest_per_m", "way")}
        return replace(self, place_m=place, **parts)


@dataclass(frozen=True)
class Lay:
    """How strips lie with given unknowns."""

    span: Array  # (n,) from clamp to contact or strip's end
    beyond: Array  # (n,) of the elongation up to the contact
    weighed: Array  # (n, POINTS, DEGREES) softness times polynomials
    turn: Array  # (n, POINTS, DEGREES + HINGES) derivative of the direction by coefficients
    end: Array  # (n, DEGREES + HINGES) the same at the contact
    cos: Array  # (n, POINTS)
    sin: Array
    tip: tuple[Array, Array]  # cosine and sine of the direction at the contact
    beside: Array  # (n,)
    touch: tuple[Array, Array]  # where the arc's point is
    moves: Array  # (n, 2, DEGREES + HINGES) derivative of that


class Ritz:
    """Strips of one kind, in any number of cases."""

    def __init__(self, strip: Strip) -> None:
        self.strip = strip

    @cached_property
    def _along(self) -> CubicSpline:
        """Directions by rest, voltage, square of it, and softness, over s."""
        one = self.strip
        parts = [one.rest_per_m, one.driven_per_m * one.soft, one.even_per_m * one.soft]
        turned = CubicSpline(one.s_m, np.stack(parts, axis=-1)).antiderivative()(one.s_m)
        values = np.stack([parts[1], parts[2]], axis=-1)
        return CubicSpline(one.s_m, np.concatenate([turned, one.soft[:, None], values], axis=-1))

    def unloaded(self, s_m: Array, cases: Cases) -> tuple[Array, Array, Array]:
        """Return direction (Hooke's law), softness and driven curvature at (n, m) places."""
        at = np.minimum(s_m, self.strip.length_m)
        found = self._along(at)
        drive, even = (v[:, None] / cases.stiffness[:, None] for v in (cases.drive, cases.even))
        turned = found[..., 0] + drive * found[..., 1] + even * found[..., 2]
        turned = turned + cases.rest_per_m[:, None] * at
        return turned, found[..., 3], drive * found[..., 4] + even * found[..., 5]

    # ------------------------------------------------------------------------- out of balance

    def lay(self, x: Array, cases: Cases) -> tuple[Lay, Array, Array]:
        one, place = self.strip, x[:, PLACE]
        span = np.minimum(place, one.length_m)
        beyond = np.maximum(place - one.length_m, 0.0)
        half = 0.5 * span[:, None]
        s = half * (1.0 + NODES)
        turned, soft, driven = self.unloaded(np.concatenate([s, span[:, None]], axis=1), cases)
        weighed = soft[:, :-1, None] * BASIS
        turn, end = np.empty((len(x), POINTS, FORCE)), np.empty((len(x), FORCE))
        turn[:, :, :DEGREES] = half[..., None] * (UPTO @ weighed)
        end[:, :DEGREES] = half * np.einsum("q,nqj->nj", WEIGHTS, weighed)
        turn[:, :, DEGREES], turn[:, :, DEGREES + 1] = 1.0, 0.0
        end[:, DEGREES], end[:, DEGREES + 1] = 1.0, beyond > 0.0
        phi = turned[:, :-1] + np.einsum("nqj,nj->nq", turn, x[:, :FORCE])
        last = turned[:, -1] + np.einsum("nj,nj->n", end, x[:, :FORCE])
        c, s_ = np.cos(phi), np.sin(phi)
        ce, se = np.cos(last), np.sin(last)
        beside = one.beside_m + one.eccentric_m * np.sin(place / one.roll_m)
        weights = half * WEIGHTS
        touch = (
            np.sum(weights * c, axis=1) + beyond * ce - beside * se,
            np.sum(weights * s_, axis=1) + beyond * se + beside * ce,
        )
        moves = np.stack([
            np.einsum("nq,nqj->nj", -weights * s_, turn)
            + (-beyond * se - beside * ce)[:, None] * end,
            np.einsum("nq,nqj->nj", weights * c, turn) + (beyond * ce - beside * se)[:, None] * end,
        ], axis=1)  # fmt: skip
        lay = Lay(span, beyond, weighed, turn, end, c, s_, (ce, se), beside, touch, moves)
        return lay, soft[:, :-1], driven[:, :-1]

    def gives(self, cases: Cases, moment: Array) -> tuple[Array, Array]:
        """Return what a hinge turns by, (n, 2), under moments over B, and its derivative."""
        one = self.strip
        B = one.stiffness_Nm2 * cases.stiffness
        give = np.stack([B * one.clamp_rad_per_Nm, B * one.joint_rad_per_Nm], axis=1)
        turned = give * moment
        play = np.tanh(B * moment[:, 0] / PLAY_Nm)
        turned[:, 0] += one.clamp_rad + one.clamp_play_rad * play
        give[:, 0] += one.clamp_play_rad * (1.0 - play**2) * B / PLAY_Nm
        return turned, give

    def arc(self, cases: Cases, force: Array) -> Array:
        """Return the angle of the arc's point, where the cell gives way along the arc."""
        beta = cases.place_m / self.strip.radius_m
        angle, give = beta, self._way(cases)
        for _ in range(YIELDS if self.strip.cell_m_per_N else 0):
            along = force[:, 1] * np.cos(angle) - force[:, 0] * np.sin(angle)
            angle = beta - give * along / self.strip.radius_m
        return np.asarray(angle)

    def _way(self, cases: Cases) -> Array:
        """Return how far the cell goes for a force over B."""
        return self.strip.cell_m_per_N * self.strip.stiffness_Nm2 * cases.stiffness

    def _yields(self, cases: Cases, force: Array) -> Array:
        """Return minus the derivative (n, 2, 2) of the arc's point by the force."""
        angle, give = self.arc(cases, force), self._way(cases)
        c, s = np.cos(angle), np.sin(angle)
        turns = 1.0 - give * (force[:, 0] * c + force[:, 1] * s) / self.strip.radius_m
        tangent = np.stack([-s, c], axis=1)
        return (give / turns)[:, None, None] * tangent[:, :, None] * tangent[:, None, :]

    def _balance(
        self, x: Array, cases: Cases, extra: Array | None = None
    ) -> tuple[Array, Lay, Array, Array]:
        """Return what is out of balance (n, UNKNOWNS), how the strips lie, what their slopes need.

        That is the law's slope at the nodes, and the hinges' gives. `extra`: the weight's moment
        over B on the strip's grid.
        """
        lay, soft, driven = self.lay(x, cases)
        force, half = x[:, FORCE:PLACE], 0.5 * lay.span[:, None]
        own = np.einsum("qj,nj->nq", BASIS, x[:, :DEGREES])
        stress, stiff = own, np.ones_like(own)
        if self.strip.law is not None:
            bent = driven + soft * own
            stress = (self.strip.law.moment(bent) - driven) / soft
            stiff = self.strip.law.slope(bent)
        work = np.einsum("nij,ni->nj", lay.moves, force)
        hinged = work[:, DEGREES:].copy()
        if extra is not None:
            stress = stress - self.on_grid(extra, half * (1.0 + NODES))
            hinged += extra[:, [0, -1]]
        turned, give = self.gives(cases, hinged)
        out = np.empty_like(x)
        out[:, :DEGREES] = np.einsum("nq,nqj->nj", half * WEIGHTS * stress, lay.weighed)
        out[:, :DEGREES] -= work[:, :DEGREES]
        out[:, DEGREES:FORCE] = x[:, DEGREES:FORCE] - turned
        angle, one = self.arc(cases, force), self.strip
        out[:, FORCE] = lay.touch[0] - one.arc_x_m - one.radius_m * np.cos(angle)
        out[:, FORCE + 1] = lay.touch[1] - one.arc_y_m - one.radius_m * np.sin(angle)
        along, across = _split(force, lay.tip)
        out[:, PLACE] = along - self.strip.friction * cases.way * np.abs(across)
        return out, lay, stiff, give

    def _slopes(self, x: Array, cases: Cases, lay: Lay, stiff: Array, give: Array) -> Array:
        """Return derivatives (n, UNKNOWNS, UNKNOWNS) of `_balance`, without that by the place."""
        force, weights = x[:, FORCE:PLACE], 0.5 * lay.span[:, None] * WEIGHTS
        along, across = _split(force, lay.tip)
        pull = weights * (lay.cos * force[:, :1] + lay.sin * force[:, 1:])
        tense = np.matmul(np.swapaxes(lay.turn, 1, 2), pull[..., None] * lay.turn)
        last = lay.beyond * along + lay.beside * across
        tense += last[:, None, None] * lay.end[:, :, None] * lay.end[:, None, :]
        scale = np.concatenate([np.ones((len(x), DEGREES)), give], axis=1)[..., None]
        J = np.zeros((len(x), UNKNOWNS, UNKNOWNS))
        J[:, :FORCE, :FORCE] = scale * tense
        J[:, :DEGREES, :DEGREES] += np.matmul(
            np.swapaxes((weights * stiff)[..., None] * lay.weighed, 1, 2), BASIS
        )
        J[:, range(DEGREES, FORCE), range(DEGREES, FORCE)] += 1.0
        J[:, :FORCE, FORCE:PLACE] = -scale * np.swapaxes(lay.moves, 1, 2)
        J[:, FORCE:PLACE, :FORCE] = lay.moves
        J[:, FORCE:PLACE, FORCE:PLACE] = self._yields(cases, force)
        rubbed = self.strip.friction * cases.way * np.sign(across)
        J[:, PLACE, :FORCE] = (across + rubbed * along)[:, None] * lay.end
        J[:, PLACE, FORCE] = lay.tip[0] + rubbed * lay.tip[1]
        J[:, PLACE, FORCE + 1] = lay.tip[1] - rubbed * lay.tip[0]
        return J

    def on_grid(self, values: Array, s_m: Array) -> Array:
        """Return values of the grid, (n, GRID), at places (n, m)."""
        at = np.minimum(s_m / self.strip.length_m, 1.0) * (GRID - 1)
        low = np.minimum(at.astype(int), GRID - 2)
        rows = np.arange(len(values))[:, None]
        below, above = values[rows, low], values[rows, low + 1]
        return np.asarray(below + (at - low) * (above - below))

    # ------------------------------------------------------------------------- equilibrium

    def newton(
        self, x: Array, cases: Cases, enough: float = ENOUGH, extra: Array | None = None
    ) -> tuple[Array, Bools]:
        """Return the equilibria near `x`, and which were found."""
        x, ok = x.copy(), np.zeros(len(x), dtype=bool)
        for _ in range(ROUNDS):
            open_ = np.flatnonzero(~ok & np.all(np.isfinite(x), axis=1))
            if not len(open_):
                break
            load = None if extra is None else extra[open_]
            step = self._step(x[open_], cases.take(open_), load)
            x[open_] -= step
            ok[open_] = self._size(step) < enough
        return x, ok

    def _step(self, x: Array, cases: Cases, extra: Array | None) -> Array:
        out, *parts = self._balance(x, cases, extra)
        J = self._slopes(x, cases, *parts)
        moved = x.copy()
        moved[:, PLACE] -= NUDGE_M
        J[:, :, PLACE] = (out - self._balance(moved, cases, extra)[0]) / NUDGE_M
        try:
            step = np.linalg.solve(J, out[..., None])[..., 0]
        except np.linalg.LinAlgError:
            return np.full_like(x, np.nan)
        size = self._size(step)[:, None]
        return np.asarray(step * np.minimum(1.0, 0.6 / np.maximum(size, 1e-300)))

    def _size(self, step: Array) -> Array:
        """Return a step's length: radians, forces in B/R^2, places in R/4."""
        R = self.strip.radius_m
        bent = np.max(np.abs(step[:, :DEGREES]), axis=1) * self.strip.length_m
        turned = np.max(np.abs(step[:, DEGREES:FORCE]), axis=1)
        force = np.max(np.abs(step[:, FORCE:PLACE]), axis=1) * R**2 / 10.0
        return np.asarray(np.max([bent, turned, force, np.abs(step[:, PLACE]) * 4.0 / R], axis=0))

    def cold(self, cases: Cases) -> tuple[Array, Bools]:
        """Return equilibria (n, UNKNOWNS) from the strip at rest, and which were found."""
        place, begin = self._crossing()
        x = np.zeros((len(cases.drive), UNKNOWNS))
        x[:, DEGREES], x[:, PLACE] = self.strip.clamp_rad, place
        ok = np.ones(len(x), dtype=bool)
        for share in np.arange(1, PATH + 1) / PATH:
            last = share == 1.0
            x, ok = self.newton(x, cases.at(share, begin), ENOUGH if last else LOOSE)
        return x, ok

    def _crossing(self) -> tuple[float, float]:
        """Return where along it the strip at rest crosses the arc, and where on the arc."""
        one = self.strip
        s = np.linspace(0.0, 2.0 * one.radius_m, 4001)
        turned = self._along(np.minimum(s, one.length_m))[:, 0] + one.clamp_rad
        step = s[1]
        x, y = (np.cumsum(f(turned)) * step - f(turned[0]) * step for f in (np.cos, np.sin))
        far = np.hypot(x - one.arc_x_m, y - one.arc_y_m) >= one.radius_m
        k = int(np.argmax(far))
        return float(s[k]), one.radius_m * float(np.arctan2(y[k] - one.arc_y_m, x[k] - one.arc_x_m))


def _split(force: Array, tip: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the parts of a force along and across the direction `tip`."""
    c, s = tip
    return force[:, 0] * c + force[:, 1] * s, force[:, 1] * c - force[:, 0] * s
