"""Equilibria with what lies beyond the contact, and shapes between the nodes."""

from __future__ import annotations

from dataclasses import dataclass, fields

import numpy as np

from benchmarks.worlds.generators._relaxation_grid import (
    CELLS,
    Relaxing,
    Solution,
    along_N,
    arm_rad,
    barred,
    extrapolated,
    ramped,
)
from benchmarks.worlds.generators._relaxation_strip import (
    Array,
    Lanes,
    Mask,
    Setting,
    Strip,
    curvature,
)

TAIL_CELLS = 16
WEIGHT_ROUNDS = 3  # until the weight of what lies beyond the contact has settled
CHUNK = 400  # lanes that are relaxed together
CLOSED_RAD = 1e-6
LEAN_RAD = 1.45  # beyond, the sheet slips out of the rolls
NEAR_PER_M, NEAR_RAD = 12.0, 0.03  # lanes so much alike are started from one solution


@dataclass
class Held:
    """Equilibria of lanes, (n,) each, and their nodes."""

    at: Solution
    ok: Mask

    def force_N(self, lanes: Lanes) -> Array:
        """Return the force on the cell along its arc."""
        return along_N(self.at, arm_rad(lanes, self.at))

    def outward_N(self, lanes: Lanes) -> Array:
        """Return the force on the cell away from its pivot."""
        beta = arm_rad(lanes, self.at)
        return np.asarray(-self.at.fx_N * np.cos(beta) - self.at.fy_N * np.sin(beta))

    def lean_rad(self, lanes: Lanes) -> Array:
        """Return gamma."""
        return np.asarray(self.at.phi_rad[-1] - arm_rad(lanes, self.at))


def contact_m(strip: Strip, lanes: Lanes, at: Solution) -> Array:
    """Return the arc length from the clamp to the contact."""
    return at.span_m + (strip.length_m + lanes.slipped_m) * barred(strip)


# ------------------------------------------------------------------------------- equilibria


def equilibria(strip: Strip, setting: Setting, lanes: Lanes) -> Held:
    """Return the equilibria of lanes, each different one found once."""
    first, back = lanes.alike()
    one = lanes.take(first)
    start = _starts(strip, setting, one)
    chunks = np.array_split(np.arange(len(first)), len(first) // CHUNK + 1)
    parts = [_weighed(strip, setting, one.take(rows), start.take(rows)) for rows in chunks]
    at = Solution(
        **{
            f.name: np.concatenate([getattr(p, f.name) for p in parts], axis=-1)
            for f in fields(Solution)
        }
    )
    lost = np.flatnonzero(at.away_rad > CLOSED_RAD)
    if len(lost):
        some = one.take(lost)
        at.put(lost, _weighed(strip, setting, some, ramped(strip, setting, some)))
    found = at.take(back)
    return Held(found, _reachable(strip, lanes, found))


def _starts(strip: Strip, setting: Setting, lanes: Lanes) -> Solution:
    """Return solutions of similar lanes: one of each cluster is relaxed from the sheet at rest."""
    about = np.stack(
        [
            np.round(lanes.eibm_Nm / (strip.stiffness_Nm2 * lanes.stiffness * NEAR_PER_M)),
            np.round(lanes.beta_rad / NEAR_RAD),
            lanes.free,
        ],
        axis=1,
    )
    _, first, back = np.unique(about, axis=0, return_index=True, return_inverse=True)
    some = lanes.take(first)
    found = Relaxing(strip, setting, some, 1).relax(ramped(strip, setting, some), 12)
    at = found.take(back.ravel())
    if not barred(strip):  # a free sheet ends where it ends
        at.span_m = np.where(lanes.free > 0.0, strip.length_m + lanes.slipped_m, at.span_m)
    return at


def _weighed(strip: Strip, setting: Setting, lanes: Lanes, start: Solution) -> Solution:
    """Return equilibria together with the weight of what lies beyond their contacts."""
    coarse = Relaxing(strip, setting, lanes, 1).relax(start, 12)
    found = extrapolated(strip, setting, lanes, coarse)
    loaded = np.any(lanes.load_x_N_per_m) or np.any(lanes.load_y_N_per_m)
    for _ in range(WEIGHT_ROUNDS if loaded else 0):
        coarse.tail = beyond(strip, setting, lanes, found).resultant
        coarse = Relaxing(strip, setting, lanes, 1).relax(coarse, 12)
        found = extrapolated(strip, setting, lanes, coarse)
    return found


def _reachable(strip: Strip, lanes: Lanes, at: Solution) -> Mask:
    end = strip.elongation_m if barred(strip) else strip.length_m + lanes.slipped_m
    squarely = np.abs(at.phi_rad[-1] - lanes.beta_rad) < LEAN_RAD
    inside = (at.span_m > 0.0) & (at.span_m <= end + 1e-9)
    closed = (at.away_rad < CLOSED_RAD) & inside
    return np.asarray(closed & (squarely | (lanes.free > 0.0)))


# ------------------------------------------------------------------- what lies beyond the contact


@dataclass
class Tail:
    """Nodes beyond the contact, (nodes, n), and their weight with its moment about it, (3, n)."""

    s_m: Array
    x_m: Array
    y_m: Array
    phi_rad: Array
    k_per_m: Array
    resultant: Array


def beyond(strip: Strip, setting: Setting, lanes: Lanes, at: Solution) -> Tail:
    """Return the sheet, or the elongation, from the contact to its end: cells that are arcs."""
    whole = strip.length_m + lanes.slipped_m
    begin = contact_m(strip, lanes, at)
    rest = whole + strip.elongation_m - begin
    s = begin + rest * (np.arange(TAIL_CELLS + 1) / TAIL_CELLS)[:, None]
    h, moment = np.diff(s, axis=0), np.zeros((TAIL_CELLS, len(rest)))
    heavy = setting.bar_weight if barred(strip) else 1.0
    loaded = np.any(lanes.load_x_N_per_m) or np.any(lanes.load_y_N_per_m)
    for _ in range(2 if loaded else 1):
        k = _loose(strip, setting, lanes, s, moment)
        phi = at.phi_rad[-1] + _summed(h * k)
        middle, chord = 0.5 * (phi[1:] + phi[:-1]), h * np.sinc(h * k / (2.0 * np.pi))
        x, y = at.x_m[-1] + _summed(chord * np.cos(middle)), _summed(chord * np.sin(middle))
        y = at.y_m[-1] + y
        px, py = (heavy * h * load for load in (lanes.load_x_N_per_m, lanes.load_y_N_per_m))
        cx, cy = 0.5 * (x[1:] + x[:-1]), 0.5 * (y[1:] + y[:-1])
        moment = _after(cx * py - cy * px) - cx * _after(py) + cy * _after(px)
    about = np.sum((cx - x[0]) * py - (cy - y[0]) * px, axis=0)
    nodes = np.concatenate([k[:1], 0.5 * (k[1:] + k[:-1]), k[-1:]])
    weight = np.stack([np.sum(px, axis=0), np.sum(py, axis=0), about])
    return Tail(s, x, y, phi, nodes, weight)


def _loose(strip: Strip, setting: Setting, lanes: Lanes, s: Array, moment: Array) -> Array:
    """Return the curvature of cells that no force of the cell bends."""
    if barred(strip):
        return np.zeros_like(moment)
    middle, h = 0.5 * (s[1:] + s[:-1]), np.maximum(np.diff(s, axis=0), 1e-12)
    u, _ = curvature(strip, setting, lanes, middle, moment, setting.beyond)
    return np.diff(strip.turn(s - lanes.slipped_m), axis=0) / h + u


def _after(parts: Array) -> Array:
    """Return the sum from the middle of each cell on."""
    return np.asarray(np.cumsum(parts[::-1], axis=0)[::-1] - 0.5 * parts)


def _summed(parts: Array) -> Array:
    return np.concatenate([np.zeros((1, parts.shape[1])), np.cumsum(parts, axis=0)])


# ------------------------------------------------------------------------------------ shapes


def drawn(
    strip: Strip, setting: Setting, lanes: Lanes, at: Solution, places_m: Array
) -> tuple[Array, Array, Array]:
    """Return x, y and phi at places along the sheet, (n, places) each."""
    edges = Relaxing(strip, setting, lanes, 1).edges(at.span_m)
    sheet, bar = slice(0, CELLS + 1), slice(CELLS, None)
    u, _ = curvature(strip, setting, lanes, edges[sheet], at.moment_Nm[sheet])
    k = strip.rest(edges[sheet] - lanes.slipped_m) + u
    tail = beyond(strip, setting, lanes, at)
    pieces = [(edges[sheet], at.x_m[sheet], at.y_m[sheet], at.phi_rad[sheet], k)]
    if barred(strip):
        give = setting.bar_softness / (strip.stiffness_Nm2 * lanes.stiffness)
        bent = give * at.moment_Nm[bar]
        pieces.append((edges[bar], at.x_m[bar], at.y_m[bar], at.phi_rad[bar], bent))
    pieces.append((tail.s_m, tail.x_m, tail.y_m, tail.phi_rad, tail.k_per_m))
    found = _between(*pieces[0], places_m)
    for piece in pieces[1:]:
        later = piece[0][0][:, None] < places_m
        found = np.where(later, _between(*piece, places_m), found)
    return found[0], found[1], found[2]


def _between(s: Array, x: Array, y: Array, phi: Array, k: Array, places_m: Array) -> Array:
    """Return x, y (quintic) and phi (cubic) between evenly spaced nodes, (3, n, places)."""
    n, cells = s.shape[1], len(s) - 1
    h = np.maximum((s[-1] - s[0]) / cells, 1e-12)[:, None]
    away = np.clip(np.nan_to_num((places_m - s[0][:, None]) / h), 0.0, cells)
    j = np.minimum(away.astype(int), cells - 1)
    u, lane = away - j, np.arange(n)[:, None]
    a, b = (j, lane), (j + 1, lane)
    c, sn = np.cos(phi), np.sin(phi)
    places = [
        _quintic(u, h, v[a], v[b], d[a], d[b], (way * k)[a], (way * k)[b])
        for v, d, way in ((x, c, -sn), (y, sn, c))
    ]
    return np.stack([*places, _cubic(u, h, phi[a], phi[b], k[a], k[b])])


def _cubic(u: Array, h: Array, f: Array, g: Array, df: Array, dg: Array) -> Array:
    t = 1.0 - u
    whole = f * t**2 * (1.0 + 2.0 * u) + g * u**2 * (1.0 + 2.0 * t)
    return np.asarray(whole + h * u * t * (df * t - dg * u))


def _quintic(
    u: Array, h: Array, f: Array, g: Array, df: Array, dg: Array, ddf: Array, ddg: Array
) -> Array:
    t = 1.0 - u
    whole = f * t**3 * (1.0 + 3.0 * u + 6.0 * u**2) + g * u**3 * (1.0 + 3.0 * t + 6.0 * t**2)
    slope = df * u * t**3 * (1.0 + 3.0 * u) - dg * t * u**3 * (1.0 + 3.0 * t)
    bend = ddf * u**2 * t**3 + ddg * t**2 * u**3
    return np.asarray(whole + h * slope + 0.5 * h**2 * bend)
