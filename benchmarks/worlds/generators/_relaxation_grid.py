"""Equilibria by relaxation: Keller's box scheme on three grids, all nodes corrected at once.

Unknowns at the nodes are the angle phi and the moment m of all that acts beyond,
    phi' = k0 + u(EIBM + m),    m' = -(fy cos phi - fx sin phi),
and beside them the force at the contact and the length up to it. A cell is centred, so that errors
are even powers of the step; the solutions of n, 2n and 4n cells are extrapolated to none.
"""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from benchmarks.worlds.generators._relaxation_strip import (
    Array,
    Lanes,
    Mask,
    Rows,
    Setting,
    Strip,
    curvature,
)

CELLS, BAR_CELLS = 16, 2  # of the coarsest grid
RAMP = (0.2, 0.4, 0.6, 0.8, 1.0)  # from the sheet at rest to what is wanted
TURN_RAD = 0.6  # the most that a step may turn
CLOSE_RAD = 2e-7  # of the last correction; what is left is its square
NOTHING = 1e-14  # added to matrices, so that none is singular
YIELD_ROUNDS = 3  # until the arm's angle and the force along its arc agree
WEIGHTS = np.array([1.0, -20.0, 64.0]) / 45.0  # of the grids: no h^2, no h^4


@dataclass
class Solution:
    """Nodes (nodes, n); the rest (n,)."""

    phi_rad: Array
    moment_Nm: Array
    x_m: Array
    y_m: Array
    fx_N: Array  # of the cell on the sheet
    fy_N: Array
    span_m: Array  # clamp to contact; of a sheet with elongation from its end on
    away_rad: Array  # the last correction
    tail: Array  # (3, n) weight (N, N) and moment about the contact (N m) of what lies beyond

    def take(self, rows: Rows | Mask) -> Solution:
        """Return some lanes."""
        return Solution(**{f.name: getattr(self, f.name)[..., rows] for f in fields(self)})

    def put(self, rows: Rows | Mask, other: Solution) -> None:
        """Replace some lanes."""
        for f in fields(self):
            getattr(self, f.name)[..., rows] = getattr(other, f.name)


def barred(strip: Strip) -> bool:
    """Return whether the contact is on an elongation."""
    return strip.elongation_m > 0.0


def shares(strip: Strip, finer: int) -> tuple[Array, Array]:
    """Return where nodes are: shares (nodes, 1) of the sheet's length, and of the span."""
    n = CELLS * finer
    sheet = np.arange(n + 1) / n
    if not barred(strip):
        return np.zeros((n + 1, 1)), sheet[:, None]
    bar = np.arange(1, BAR_CELLS * finer + 1) / (BAR_CELLS * finer)
    one, none = np.ones(len(bar)), np.zeros(n + 1)
    return np.concatenate([sheet, one])[:, None], np.concatenate([none, bar])[:, None]


class Relaxing:
    """Newton's method for all nodes of all lanes on one grid."""

    def __init__(self, strip: Strip, setting: Setting, lanes: Lanes, finer: int) -> None:
        self.strip, self.setting, self.lanes = strip, setting, lanes
        self.of_length, self.of_span = shares(strip, finer)
        self.bar = self.of_span[1:, 0] > 0.0 if barred(strip) else np.zeros(CELLS * finer, bool)
        self.length_m = strip.length_m + lanes.slipped_m

    def relax(self, at: Solution, rounds: int, close: float = CLOSE_RAD) -> Solution:
        """Return a solution after so many corrections at most."""
        for _ in range(rounds):
            at = self.corrected(at)
            if not np.max(at.away_rad, initial=0.0) > close:
                break
        return at

    # ----------------------------------------------------------------------------- one cell

    def edges(self, span_m: Array) -> Array:
        """Return where the nodes are, (nodes, n) in m."""
        return self.of_length * self.length_m + self.of_span * span_m

    def _curved(self, edges: Array, middle: Array, m: Array) -> tuple[Array, Array]:
        """Return the mean curvature of cells and its derivative by the moment."""
        strip, lanes, on = self.strip, self.lanes, ~self.bar
        u, soft = curvature(strip, self.setting, lanes, middle[on], m[on])
        turn = strip.turn(edges - lanes.slipped_m)
        k = np.empty_like(m)
        slope = np.empty_like(m)
        h = np.diff(edges, axis=0)
        k[on], slope[on] = np.diff(turn, axis=0)[on] / h[on] + u, soft
        give = self.setting.bar_softness / (strip.stiffness_Nm2 * lanes.stiffness)
        k[self.bar], slope[self.bar] = give * m[self.bar], give
        return k, slope

    def _weights(self, h: Array) -> Array:
        """Return the weight of what lies between the middle of a cell and the contact, in m."""
        heavy = h * np.where(self.bar, self.setting.bar_weight, 1.0)[:, None]
        beyond = np.cumsum(heavy[::-1], axis=0)[::-1]
        return beyond - 0.5 * heavy

    # ------------------------------------------------------------------------ one correction

    def corrected(self, at: Solution) -> Solution:
        """Return all unknowns after one step."""
        lanes = self.lanes
        edges = self.edges(at.span_m)
        h, middle = np.diff(edges, axis=0), 0.5 * (edges[1:] + edges[:-1])
        phi = 0.5 * (at.phi_rad[1:] + at.phi_rad[:-1])
        m = 0.5 * (at.moment_Nm[1:] + at.moment_Nm[:-1])
        k, soft = self._curved(edges, middle, m)
        long = self._weights(h)
        fx = at.fx_N + at.tail[0] + lanes.load_x_N_per_m * long
        fy = at.fy_N + at.tail[1] + lanes.load_y_N_per_m * long
        c, s = np.cos(phi), np.sin(phi)
        across = fy * c - fx * s
        grows = np.diff(self.of_span, axis=0)  # of h with the span
        mid_grows = 0.5 * (self.of_span[1:] + self.of_span[:-1])
        partly = (_slope(k, middle) + soft * across) * mid_grows * (~self.bar)[:, None]
        a, b = np.zeros((2, 5, *h.shape))
        a[0] = -(np.diff(at.phi_rad, axis=0) - h * k)
        a[4] = grows * k + h * partly
        b[0] = -(np.diff(at.moment_Nm, axis=0) + h * across)
        b[2], b[3], b[4] = h * s, -h * c, -grows * across
        e, w = 0.5 * h * soft, 0.5 * h * (fy * s + fx * c)
        turn, slack = self.setting.hinge(at.moment_Nm[0])
        first = np.zeros((2, 5, len(at.span_m)))
        first[0, 0] = lanes.root_rad + turn - at.phi_rad[0]
        first[0, 1], first[1, 1] = slack, 1.0
        dphi, dm = _marched(first, a, b, e, w)
        moved = dphi[1:] + dphi[:-1]
        dx = np.sum(-0.5 * h[:, None] * s[:, None] * moved, axis=0)
        dy = np.sum(0.5 * h[:, None] * c[:, None] * moved, axis=0)
        dx[4] += np.sum(grows * c, axis=0)
        dy[4] += np.sum(grows * s, axis=0)
        x, y = (_summed(h * v) for v in (c, s))
        step = self._closed(at, (x[-1], y[-1]), dphi[-1], dm[-1], dx, dy)
        return self._stepped(at, step, dphi, dm)

    def _closed(
        self, at: Solution, end: tuple[Array, Array], dphi: Array, dm: Array, dx: Array, dy: Array
    ) -> Array:
        """Return the changes of m(0), fx, fy and the span that meet the conditions at the end."""
        q, n = self.lanes, len(at.span_m)
        c, s = np.cos(at.phi_rad[-1]), np.sin(at.phi_rad[-1])
        beta = arm_rad(q, at)
        tx, ty = -np.sin(beta), np.cos(beta)  # of the arc
        radial = -(at.fx_N * ty - at.fy_N * tx)
        reach = q.radius_m + q.stretch_m_per_N * radial
        dfx, dfy = np.zeros((2, 5, n))
        dfx[2], dfy[3] = 1.0, 1.0
        dforce, dradial = -(dfx * tx + dfy * ty), -(dfx * ty - dfy * tx)
        along, normal = at.fx_N * c + at.fy_N * s, at.fx_N * s - at.fy_N * c
        dalong = dfx * c + dfy * s - normal * dphi
        dnormal = dfx * s - dfy * c + along * dphi
        rows = np.empty((n, 4, 5))
        lean = at.phi_rad[-1] - beta
        # each: what is left of the condition in column 0, its derivatives in the others
        conditions = (
            (at.moment_Nm[-1] - at.tail[2] + q.offset_m * along + q.swivel_Nm * lean,
             dm + q.offset_m * dalong + q.swivel_Nm * dphi),
            (end[0] - q.offset_m * s - q.pivot_x_m - reach * ty,
             dx - q.offset_m * c * dphi - q.give_m_per_N * dforce * tx
             - q.stretch_m_per_N * dradial * ty),
            (end[1] + q.offset_m * c - q.pivot_y_m + reach * tx,
             dy - q.offset_m * s * dphi - q.give_m_per_N * dforce * ty
             + q.stretch_m_per_N * dradial * tx),
            (along - q.rub * np.abs(normal) - q.drag_N,
             dalong - q.rub * np.sign(normal) * dnormal),
        )  # fmt: skip
        for i, (left, derivative) in enumerate(conditions):
            rows[:, i] = derivative.T
            rows[:, i, 0] += left
        loose = q.free > 0.0
        rows[loose, 1:] = 0.0
        rows[loose, 1:, 2:] = np.eye(3)
        rows[loose, 0, 0] = at.moment_Nm[-1][loose] + dm[0][loose]
        good = np.all(np.isfinite(rows), axis=(1, 2))
        rows[~good] = 0.0
        rows[~good, :, 1:] = np.eye(4)
        scale = np.array([1e-4, 1e-3, 1e-3, 1e-2])  # N m, N, N, m
        found = np.linalg.solve(rows[:, :, 1:] * scale + NOTHING * np.eye(4), -rows[:, :, :1])[
            :, :, 0
        ]
        return np.asarray((found * scale).T)

    def _stepped(self, at: Solution, step: Array, dphi: Array, dm: Array) -> Solution:
        turn = dphi[:, 0] + np.einsum("jkn,kn->jn", dphi[:, 1:], step)
        more = dm[:, 0] + np.einsum("jkn,kn->jn", dm[:, 1:], step)
        largest = np.max(np.abs(turn), axis=0)
        largest = np.maximum(largest, np.abs(step[3]) / (0.1 * self.strip.radius_m))
        part = np.minimum(1.0, TURN_RAD / np.maximum(largest, 1e-12))
        part = np.where(np.isfinite(part), part, 0.0)
        phi = at.phi_rad + part * np.nan_to_num(turn)
        span = at.span_m + part * step[3]
        h = np.diff(self.edges(span), axis=0)
        middle = 0.5 * (phi[1:] + phi[:-1])
        return Solution(
            phi_rad=phi, moment_Nm=at.moment_Nm + part * np.nan_to_num(more),
            x_m=_summed(h * np.cos(middle)), y_m=_summed(h * np.sin(middle)),
            fx_N=at.fx_N + part * step[1], fy_N=at.fy_N + part * step[2], span_m=span,
            away_rad=np.where(np.isfinite(largest), largest, 1.0), tail=at.tail,
        )  # fmt: skip


def _marched(first: Array, a: Array, b: Array, e: Array, w: Array) -> tuple[Array, Array]:
    """Return how phi and m change at all nodes, (nodes, 5, n) each.

    In each cell dphi1 - dphi0 = e (dm0 + dm1) + a and dm1 - dm0 = w (dphi0 + dphi1) + b.
    """
    count = len(e)
    dphi, dm = np.empty((2, count + 1, *first.shape[1:]))
    dphi[0], dm[0] = first
    a, b = np.moveaxis(a, 1, 0), np.moveaxis(b, 1, 0)
    under = 1.0 / (1.0 - e * w)
    more, twice = (1.0 + e * w) * under, 2.0 * e * under
    given = (a + e[:, None] * b) * under[:, None]
    for j in range(count):
        dphi[j + 1] = more[j] * dphi[j] + twice[j] * dm[j] + given[j]
        dm[j + 1] = dm[j] + w[j] * (dphi[j] + dphi[j + 1]) + b[j]
    return dphi, dm


def _slope(k: Array, middle: Array) -> Array:
    """Return dk/ds between cells, of values at their middles."""
    d = np.diff(k, axis=0) / np.maximum(np.diff(middle, axis=0), 1e-9)
    return np.concatenate([d[:1], 0.5 * (d[1:] + d[:-1]), d[-1:]])


def _summed(parts: Array) -> Array:
    return np.concatenate([np.zeros((1, parts.shape[1])), np.cumsum(parts, axis=0)])


def along_N(at: Solution, beta: Array) -> Array:
    """Return the force on the cell along a direction beta + 90 degrees."""
    return np.asarray(at.fx_N * np.sin(beta) - at.fy_N * np.cos(beta))


def arm_rad(lanes: Lanes, at: Solution) -> Array:
    """Return the angle of the cell's arm, which yields along its arc."""
    beta = lanes.beta_rad
    for _ in range(YIELD_ROUNDS if np.any(lanes.give_m_per_N) else 0):
        beta = lanes.beta_rad + lanes.give_m_per_N * along_N(at, beta) / lanes.radius_m
    return beta


# ------------------------------------------------------------------------------ the three grids


def extrapolated(strip: Strip, setting: Setting, lanes: Lanes, coarse: Solution) -> Solution:
    """Return what the solutions of three grids tend to."""
    found, at = [coarse], coarse
    for finer in (2, 4):
        at = Relaxing(strip, setting, lanes, finer).relax(_refined(at), 4)
        found.append(at)
    every = {
        f.name: sum(
            weight * getattr(one, f.name)[:: 2**i]
            if getattr(one, f.name).ndim == 2 and f.name != "tail"
            else weight * getattr(one, f.name)
            for i, (weight, one) in enumerate(zip(WEIGHTS, found, strict=True))
        )
        for f in fields(Solution)
    }
    every["away_rad"] = np.max([one.away_rad for one in found], axis=0)
    return Solution(**every)


def _refined(at: Solution) -> Solution:
    """Return a start with twice as many cells."""

    def finer(v: Array) -> Array:
        result = np.empty((2 * len(v) - 1, v.shape[1]))
        result[::2], result[1::2] = v, 0.5 * (v[1:] + v[:-1])
        inner = 0.5625 * (v[1:-2] + v[2:-1]) - 0.0625 * (v[:-3] + v[3:])
        result[3:-3:2] = inner
        return result

    return Solution(
        phi_rad=finer(at.phi_rad), moment_Nm=finer(at.moment_Nm), x_m=finer(at.x_m),
        y_m=finer(at.y_m), fx_N=at.fx_N, fy_N=at.fy_N, span_m=at.span_m, away_rad=at.away_rad,
        tail=at.tail,
    )  # fmt: skip


def ramped(strip: Strip, setting: Setting, lanes: Lanes) -> Solution:
    """Return a start: from the sheet at rest, EIBM and position grow to what is wanted."""
    at, beta = _at_rest(strip, lanes)
    for share in RAMP:
        part = lanes.take(np.arange(len(beta)))
        part.beta_rad = beta + share * (lanes.beta_rad - beta)
        part.eibm_Nm = share * lanes.eibm_Nm
        at = Relaxing(strip, setting, part, 1).relax(at, 3)
    return at


def _at_rest(strip: Strip, lanes: Lanes) -> tuple[Solution, Array]:
    """Return the stated shape up to the arc, and where it crosses it."""
    n, held = len(lanes.free), lanes.free == 0.0
    s = np.linspace(0.0, strip.length_m + strip.elongation_m, 201)
    phi = strip.turn(np.minimum(s, strip.length_m))
    middle, h = 0.5 * (phi[1:] + phi[:-1]), s[1]
    x, y = (np.concatenate([[0.0], np.cumsum(h * f(middle))]) for f in (np.cos, np.sin))
    far = np.hypot(x, y)
    over = np.flatnonzero(far >= strip.radius_m)
    j = int(over[0]) if len(over) else len(s) - 1
    whole = strip.elongation_m if barred(strip) else strip.length_m + lanes.slipped_m
    before = strip.length_m if barred(strip) else 0.0
    span = np.where(held, s[j] - before, whole)
    edges = Relaxing(strip, Setting(), lanes, 1).edges(span)
    nodes = np.interp(edges, s, phi)
    zero = np.zeros_like(nodes)
    at = Solution(
        phi_rad=nodes, moment_Nm=zero, x_m=zero, y_m=zero, fx_N=np.zeros(n), fy_N=np.zeros(n),
        span_m=span, away_rad=np.ones(n), tail=np.zeros((3, n)),
    )  # fmt: skip
    return at, np.full(n, np.arctan2(y[j], x[j]))
