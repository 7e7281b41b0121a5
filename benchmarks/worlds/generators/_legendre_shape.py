"""How strips of the world `legendre` lie: curves, free strips, what the load cell feels, weight."""

from __future__ import annotations

import numpy as np
from numpy.polynomial import legendre
from scipy.interpolate import CubicSpline

from benchmarks.worlds.generators._legendre_ritz import (
    BASIS,
    DEGREES,
    FORCE,
    GRID,
    PLACE,
    POINTS,
    SERIES,
    UNKNOWNS,
    UPTO,
    Array,
    Bools,
    Cases,
    Law,
    Ritz,
)

STEP_M = 0.1e-3
TURNS = 14  # until weight and shape agree


def lies(
    ritz: Ritz, x: Array, cases: Cases, extra: Array | None = None, places: Array | None = None
) -> tuple[Array, ...]:
    """Return places (m,), fine ones where none are given, and x, y, phi of (n, m)."""
    one = ritz.strip
    whole = one.length_m + one.elongation_m
    inner = np.linspace(0.0, one.length_m, 1 + round(one.length_m / STEP_M))
    s = places
    if s is None:
        more = np.linspace(one.length_m, whole, 1 + round(one.elongation_m / STEP_M))
        s = np.concatenate([inner, more[1:]])
    phi = _directions(ritz, x, cases, inner, extra)
    parts = np.stack([np.cos(phi), np.sin(phi), phi], axis=-1)
    spline = CubicSpline(inner, parts, axis=1)
    at = np.minimum(s, one.length_m)
    path, turned = spline.antiderivative()(at)[..., :2], spline(at)[..., 2]
    beyond = np.maximum(s - one.length_m, 0.0)
    straight = phi[:, -1] + x[:, DEGREES + 1]
    t = np.stack([np.cos(straight), np.sin(straight)], axis=-1)
    path = path + beyond[:, None] * t[:, None]
    phi = np.where(beyond > 0.0, straight[:, None], turned)
    return s, path[..., 0], path[..., 1], phi


def _directions(ritz: Ritz, x: Array, cases: Cases, s_m: Array, extra: Array | None) -> Array:
    """Return phi (n, m) on the strip."""
    places = np.broadcast_to(s_m, (len(x), len(s_m)))
    turned, soft, driven = ritz.unloaded(places, cases)
    span = np.minimum(x[:, PLACE], ritz.strip.length_m)
    half = 0.5 * span[:, None]
    nodes = half * (1.0 + legendre.leggauss(POINTS)[0])
    own = ritz.unloaded(nodes, cases)[1] * np.einsum("qj,nj->nq", BASIS, x[:, :DEGREES])
    series = (half * own) @ UPTO.T @ SERIES.T
    inside = np.clip(s_m / np.maximum(half, 1e-12) - 1.0, -1.0, 1.0)
    added = np.einsum("nmj,nj->nm", legendre.legvander(inside, POINTS - 1), series)
    bare = _beyond(ritz.strip.law, driven, soft, _moment(ritz, extra, places))
    if bare is not None:  # beyond the contact, or of a free strip
        upto = CubicSpline(s_m, bare, axis=1).antiderivative()(s_m)
        there = [np.interp(end, s_m, one) for end, one in zip(span, upto, strict=True)]
        added += np.where(s_m >= span[:, None], upto - np.array(there)[:, None], 0.0)
    return np.asarray(turned + added + x[:, DEGREES, None])


def _moment(ritz: Ritz, extra: Array | None, places: Array) -> Array | None:
    return None if extra is None else ritz.on_grid(extra, places)


def _beyond(law: Law | None, driven: Array, soft: Array, moment: Array | None) -> Array | None:
    """Return the curvature that no load of the rolls adds, less the driven one of Hooke's law."""
    if law is None:
        return None if moment is None else soft * moment
    wanted = driven if moment is None else driven + soft * moment
    u = wanted.copy()
    for _ in range(40):
        u = u - np.clip((law.moment(u) - wanted) / law.slope(u), -10.0, 10.0)
    return np.asarray(u - driven)


def weights(ritz: Ritz, x: Array, cases: Cases, extra: Array | None) -> Array:
    """Return the weight's moment over B on the strip's grid, (n, GRID)."""
    s, px, _, _ = lies(ritz, x, cases, extra)
    spline = CubicSpline(s, px, axis=1)
    upto = spline.antiderivative()(s)
    lever = upto[:, -1:] - upto - px * (s[-1] - s)
    B = ritz.strip.stiffness_Nm2 * cases.stiffness[:, None]
    moment = -ritz.strip.weight_N_per_m * lever / B
    return np.asarray(CubicSpline(s, moment, axis=1)(ritz.strip.s_m))


def held(ritz: Ritz, cases: Cases, near: Array | None = None) -> tuple[Array, Bools, Array | None]:
    """Return unknowns (0 where none were found), which were, and the weight's moments if any."""
    x, ok = ritz.cold(cases) if near is None else ritz.newton(near, cases)
    if ritz.strip.weight_N_per_m == 0.0:
        return np.where(ok[:, None], x, 0.0), ok, None
    extra = np.zeros((len(x), GRID))
    for _ in range(TURNS):
        if not np.any(ok):
            break
        before = x[:, FORCE:PLACE].copy()
        extra[ok] = weights(ritz, x[ok], cases.take(ok), extra[ok])
        x, ok = ritz.newton(x, cases, extra=extra)
        if np.max(np.abs(x[ok, FORCE:PLACE] - before[ok]), initial=0.0) < 1e-5:
            break
    return np.where(ok[:, None], x, 0.0), ok, extra


def free(ritz: Ritz, cases: Cases) -> tuple[Array, Array | None]:
    """Return unknowns of strips that nothing touches, and the weight's moments."""
    x = np.zeros((len(cases.drive), UNKNOWNS))
    x[:, DEGREES] = ritz.strip.clamp_rad
    if ritz.strip.weight_N_per_m == 0.0:
        return x, None
    extra = np.zeros((len(x), GRID))
    for _ in range(2 * TURNS):  # a light strip: half a step each, or it would swing
        extra = 0.5 * (extra + weights(ritz, x, cases, extra))
        x[:, DEGREES : DEGREES + 2] = ritz.gives(cases, extra[:, [0, -1]])[0]
    return x, extra


def felt(ritz: Ritz, x: Array, cases: Cases) -> Array:
    """Return force along the arc, normal force over B, and lean gamma, (n, 3)."""
    lay = ritz.lay(x, cases)[0]
    c, s = lay.tip
    fx, fy = -x[:, FORCE], -x[:, FORCE + 1]
    beta = ritz.arc(cases, x[:, FORCE:PLACE])
    along = fy * np.cos(beta) - fx * np.sin(beta)
    lean = np.arctan2(s * np.cos(beta) - c * np.sin(beta), c * np.cos(beta) + s * np.sin(beta))
    return np.stack([along, fy * c - fx * s, lean], axis=1)
