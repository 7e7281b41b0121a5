"""The sheet: its direction angle as a B-spline whose elastic energy is least.

theta(u), u = s/L in [0, 1], is a B-spline; L is the part of the sheet between clamp and contact.
The contact is a constraint: what is touched lies on the arc, and its Lagrange multiplier is the
force on the load cell. Many cases (positions, voltages) are solved at once.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt
from scipy.interpolate import BSpline, CubicHermiteSpline

A = npt.NDArray[np.float64]
Along = Callable[[A], A]  # of s (m)

DEGREE, SPANS, POINTS = 5, 12, 6
TAIL = 16  # intervals beyond the contact
STEP = 1e-7  # of the difference quotients; unknowns are of order one


def rigid(moment_Nm: A) -> A:
    """Return the turn (rad) of a clamp that holds."""
    return np.zeros_like(moment_Nm)


def hooke(bend_per_m: A) -> A:
    """Return moment over B of a linear sheet."""
    return bend_per_m


@dataclass(kw_only=True)
class Sheet:
    """One configuration: geometry, true values, and the places where something may be hidden."""

    name: str
    length_m: float
    elongation_m: float
    radius_m: float
    origin_rad: float
    B_Nm2: float
    driven_per_m: dict[int, float]  # Me/B at +2 V (1) and -2 V (-1), magnitudes
    rest: list[Along]  # their sum is k0 (1/m)
    stiffness: list[Along] = field(default_factory=list)  # factors of B
    law: Along = hooke  # moment over B (1/m) of the change of curvature (1/m)
    profile: list[Callable[[A, A], A]] = field(default_factory=list)  # factors of Me, (s, sign)
    bowing: list[Along] = field(default_factory=list)  # moment over B (1/m), times (V/2 V)^2
    coupled: list[Along] = field(default_factory=list)  # factors of Me, of the curvature (1/m)
    dead_load: list[Along] = field(default_factory=list)  # force (N) along y on what is beyond s
    clamp_rad: float = 0.0
    clamp_turns: Along = rigid  # rad, of the moment (N m)
    elongation_gives: float = 0.0  # B over the bending stiffness of the elongation
    beside_m: float = 0.0  # of the rolls' point from the sheet, along its normal
    gives_m_per_N: float = 0.0  # of what is touched, along the arc
    centre_m: tuple[float, float] = (0.0, 0.0)  # of the arc

    def rest_per_m(self, s: A) -> A:
        """Return k0 (1/m)."""
        return np.sum([f(s) for f in self.rest], axis=0)

    def driven(self, s: A, alpha: A) -> A:
        """Return Me/B (1/m); `alpha` is voltage over 2 V, as far as the sheet follows it."""
        sign = np.where(alpha < 0.0, -1.0, 1.0)
        size = np.where(alpha < 0.0, self.driven_per_m[-1], self.driven_per_m[1])
        found = alpha * size * np.ones_like(s)
        for f in self.profile:
            found = found * f(s, sign)
        return found + sum(alpha**2 * f(s) for f in self.bowing)

    def flexural(self, s: A) -> A:
        """Return B over its nominal value."""
        found = np.ones_like(s)
        for f in self.stiffness:
            found = found * f(s)
        return found

    def loaded_N(self, s: A) -> A:
        """Return the dead load (N) on what lies beyond s."""
        return np.zeros_like(s) + sum(f(s) for f in self.dead_load)


@dataclass(frozen=True)
class Cases:
    """What is solved at once, each of shape (cases,)."""

    position_m: A  # nan: nothing touches
    alpha: A
    rest_per_m: A  # added evenly to k0
    rubbing: A  # friction coefficient, with the sign of the force along the sheet


@dataclass(frozen=True)
class Shapes:
    """Solutions: forces over B (1/m^2), of shape (cases,), and curves (cases, points)."""

    tangential: A
    radial: A
    gamma_rad: A  # between the sheet's normal at the contact and the arc's tangent
    contact_m: A
    x_m: A
    y_m: A


class _Basis:
    """Values at Gauss points in u and integrals over u, made once."""

    def __init__(self) -> None:
        inner = np.linspace(0.0, 1.0, SPANS + 1)
        knots = np.concatenate([np.zeros(DEGREE), inner, np.ones(DEGREE)])
        node, weight = np.polynomial.legendre.leggauss(POINTS)
        self.u: A = (inner[:-1, None] + (node + 1.0) / 2.0 / SPANS).ravel()
        self.w: A = np.tile(weight / 2.0 / SPANS, SPANS)
        self.size = SPANS + DEGREE
        spline = BSpline(knots, np.eye(self.size), DEGREE)
        self.at: A = spline(self.u)  # (points, size)
        self.slope: A = spline.derivative()(self.u)
        self.inner = inner
        self.at_inner: A = spline(inner)
        self.fit: A = np.linalg.pinv(self.at)


BASIS = _Basis()
TAIL_NODE, TAIL_WEIGHT = np.polynomial.legendre.leggauss(6)


def solve(sheet: Sheet, cases: Cases, points_m: A) -> Shapes:
    """Return equilibria; raises ValueError where the sheet does not reach the load cell."""
    z = _free_start(sheet, cases)
    touched = np.isfinite(cases.position_m)
    goal = np.where(touched, cases.position_m / sheet.radius_m + sheet.origin_rad, 0.0)
    begin = z[:, -1].copy()
    z[:, -1] = _crossing_m(sheet, z, begin) / sheet.radius_m
    start = _polar_rad(sheet, z)
    for part, rounds in ((0.34, 4), (0.67, 4), (1.0, 25)):
        z = _newton(sheet, cases, z, start + part * (goal - start), touched, rounds)
    return _shapes(sheet, cases, z, goal, touched, points_m)


# ---------------------------------------------------------------------------- residual


def _residual(sheet: Sheet, cases: Cases, z: A, angle: A, touched: A) -> A:
    """Return the gradient of the energy, the gap at the contact and the force along the sheet.

    z: (cases, size + 3): coefficients, force on the load cell times R^2/B (x, y), s_hat/R.
    """
    c, radius, basis = z[:, :-3], sheet.radius_m, BASIS
    force = z[:, -3:-1] / radius**2
    reached = np.where(touched, z[:, -1] * radius, sheet.length_m)
    length = np.minimum(reached, sheet.length_m)[:, None]
    lever = (reached - length[:, 0])[:, None]
    s, theta = length * basis.u, c @ basis.at.T
    curvature = (c @ basis.slope.T) / length
    moment = _internal(sheet, cases, s, curvature)
    cos, sin = np.cos(theta), np.sin(theta)
    across = sheet.loaded_N(s) / sheet.B_Nm2 * cos  # moment rate of dead loads
    pull = force[:, 1:] * cos - force[:, :1] * sin
    gradient = (basis.w * moment) @ basis.slope + length * ((basis.w * (pull - across)) @ basis.at)
    end = c[:, -1:]
    turn = _along_end(sheet, force, end, lever) - _tail_moment(sheet, cases, end, length)
    gradient[:, -1:] += turn
    clamp = -gradient[:, :1] * sheet.B_Nm2
    gradient[:, 0] = (c[:, :1] - sheet.clamp_rad - sheet.clamp_turns(clamp))[:, 0]
    tip = length * np.stack([cos @ basis.w, sin @ basis.w], axis=1)
    gap, slide = _contact(sheet, cases, tip, end, lever, force, angle)
    gap = np.where(touched[:, None], gap / radius, z[:, -3:-1])
    slide = np.where(touched, slide * radius**2, z[:, -1] - sheet.length_m / radius)
    gradient[:, 1:] *= radius
    return np.concatenate([gradient, gap, slide[:, None]], axis=1)


def _internal(sheet: Sheet, cases: Cases, s: A, curvature: A) -> A:
    """Return the sheet's own moment over B (1/m)."""
    bend = curvature - sheet.rest_per_m(s) - cases.rest_per_m[:, None]
    driven = sheet.driven(s, cases.alpha[:, None])
    for f in sheet.coupled:
        driven = driven * f(curvature)
    return sheet.flexural(s) * sheet.law(bend) - driven


def _along_end(sheet: Sheet, force: A, end: A, lever: A) -> A:
    """Return what the contact's force turns at the end of the bent part, over B."""
    along = np.concatenate([np.cos(end), np.sin(end)], axis=1)
    across = np.concatenate([-np.sin(end), np.cos(end)], axis=1)
    normal = np.sum(force * across, axis=1, keepdims=True)
    return lever * normal - sheet.beside_m * np.sum(force * along, axis=1, keepdims=True)


def _contact(
    sheet: Sheet, cases: Cases, tip: A, end: A, lever: A, force: A, angle: A
) -> tuple[A, A]:
    """Return the gap (m) and the force along the sheet that friction does not take (1/m^2)."""
    across = np.concatenate([-np.sin(end), np.cos(end)], axis=1)
    along = np.concatenate([np.cos(end), np.sin(end)], axis=1)
    normal = np.sum(force * across, axis=1, keepdims=True)
    sag = -normal * sheet.elongation_gives * lever**3 / 3.0
    sagged = end[:, 0] - (normal * sheet.elongation_gives * lever**2 / 2.0)[:, 0]
    touched = tip + lever * along + (sag + sheet.beside_m) * across
    tangent = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    more = sheet.gives_m_per_N * sheet.B_Nm2 * np.sum(force * tangent, axis=1)
    beta = angle + more / sheet.radius_m
    arc = sheet.radius_m * np.stack([np.cos(beta), np.sin(beta)], axis=1) + sheet.centre_m
    here = np.stack([np.cos(sagged), np.sin(sagged)], axis=1)
    slide = np.sum(force * here, axis=1) - cases.rubbing * np.abs(normal[:, 0])
    return touched - arc, slide


def _tail_moment(sheet: Sheet, cases: Cases, end: A, length: A) -> A:
    """Return the moment over B of dead loads on what is beyond the bent part."""
    if not sheet.dead_load:
        return np.zeros_like(end)
    whole = sheet.length_m + sheet.elongation_m
    half = (whole - length) / 2.0
    s = length + half * (TAIL_NODE + 1.0)
    free = np.where(length < sheet.length_m, _free_curvature(sheet, cases, length), 0.0)
    theta = end + free * (s - length)
    moment: A = np.sum(
        half * TAIL_WEIGHT * sheet.loaded_N(s) * np.cos(theta), axis=1, keepdims=True
    )
    return moment / sheet.B_Nm2


def _free_curvature(sheet: Sheet, cases: Cases, s: A) -> A:
    """Return the curvature of a part without load, by a damped fixed point."""
    rest = sheet.rest_per_m(s) + cases.rest_per_m[:, None]
    driven = sheet.driven(s, cases.alpha[:, None])
    bend = driven / sheet.flexural(s)
    for _ in range(40):
        more = driven
        for f in sheet.coupled:
            more = more * f(rest + bend)
        step = 0.7 * (more / sheet.flexural(s) - sheet.law(bend))
        bend = bend + step
        if np.max(np.abs(step)) < 1e-9:
            break
    return np.asarray(rest + bend)


# ------------------------------------------------------------------------------ Newton


def _newton(sheet: Sheet, cases: Cases, z: A, angle: A, touched: A, rounds: int) -> A:
    """Return the solution, at most `rounds` steps on; the last part of the way must converge."""
    for _ in range(rounds):
        here = _residual(sheet, cases, z, angle, touched)
        if np.max(np.abs(here)) < 1e-10:
            return z
        jacobian = np.empty((*z.shape, z.shape[1]))
        for j in range(z.shape[1]):
            moved = z.copy()
            moved[:, j] += STEP
            there = _residual(sheet, cases, moved, angle, touched)
            jacobian[:, :, j] = (there - here) / STEP
        step = np.linalg.solve(jacobian, here[:, :, None])[:, :, 0]
        theta = np.max(np.abs(step[:, :-3]), axis=1, keepdims=True)
        z = z - step * np.minimum(1.0, 0.6 / np.maximum(theta, 1e-12))
    if rounds > 10 and np.max(np.abs(_residual(sheet, cases, z, angle, touched))) > 1e-8:
        raise ValueError(f"the {sheet.name} sheet does not reach the load cell at some position")
    return z


def _free_start(sheet: Sheet, cases: Cases) -> A:
    """Return the free curve, over the whole free length, without force."""
    s = np.tile(sheet.length_m * BASIS.u, (len(cases.alpha), 1))
    k = _free_curvature(sheet, cases, s)
    panels = (k * BASIS.w).reshape(len(k), SPANS, POINTS).sum(axis=2) * sheet.length_m
    ends = np.concatenate([np.zeros((len(k), 1)), np.cumsum(panels, axis=1)], axis=1)
    theta = np.array([np.interp(BASIS.u, BASIS.inner, row) for row in ends])
    c = sheet.clamp_rad + theta @ BASIS.fit.T
    return np.concatenate([c, np.zeros((len(c), 2)), np.ones((len(c), 1))], axis=1)


def _crossing_m(sheet: Sheet, z: A, begin: A) -> A:
    """Shorten the spline to where the free curve crosses the arc; returns s_hat (m)."""
    theta = z[:, :-3] @ BASIS.at.T
    x = np.cumsum(BASIS.w * np.cos(theta), axis=1) * sheet.length_m
    y = np.cumsum(BASIS.w * np.sin(theta), axis=1) * sheet.length_m
    reached = begin * sheet.radius_m
    for i, far in enumerate(np.hypot(x, y)):
        beyond = np.flatnonzero(far >= sheet.radius_m)
        if len(beyond):
            reached[i] = sheet.length_m * BASIS.u[beyond[0]]
            part = reached[i] / sheet.length_m
            z[i, :-3] = BASIS.fit @ np.interp(part * BASIS.u, BASIS.u, theta[i])
        else:
            inside = x[i, -1] * np.cos(theta[i, -1]) + y[i, -1] * np.sin(theta[i, -1])
            more = -inside + np.sqrt(inside**2 + sheet.radius_m**2 - far[-1] ** 2)
            reached[i] = sheet.length_m + more
    return reached


def _polar_rad(sheet: Sheet, z: A) -> A:
    """Return the polar angle of the contact of a starting curve."""
    reached = z[:, -1] * sheet.radius_m
    length = np.minimum(reached, sheet.length_m)
    theta = z[:, :-3] @ BASIS.at.T
    lever = reached - length
    x = length * (np.cos(theta) @ BASIS.w) + lever * np.cos(z[:, -4])
    y = length * (np.sin(theta) @ BASIS.w) + lever * np.sin(z[:, -4])
    return np.asarray(np.arctan2(y, x))


# ------------------------------------------------------------------------------ shapes


def _shapes(sheet: Sheet, cases: Cases, z: A, angle: A, touched: A, points_m: A) -> Shapes:
    force = z[:, -3:-1] / sheet.radius_m**2
    tangent = np.stack([-np.sin(angle), np.cos(angle)], axis=1)
    outward = np.stack([np.cos(angle), np.sin(angle)], axis=1)
    reached = np.where(touched, z[:, -1] * sheet.radius_m, sheet.length_m)
    curves = [
        _curve(sheet, Cases(*(v[i : i + 1] for v in vars(cases).values())), z[i], length, points_m)
        for i, length in enumerate(np.minimum(reached, sheet.length_m))
    ]
    return Shapes(
        np.sum(force * tangent, axis=1),
        np.sum(force * outward, axis=1),
        z[:, -4] - angle,
        reached,
        np.array([x for x, _ in curves]),
        np.array([y for _, y in curves]),
    )


def _curve(sheet: Sheet, case: Cases, z: A, length: float, points_m: A) -> tuple[A, A]:
    """Return x and y at the points along sheet and elongation."""
    c, basis = z[:-3], BASIS
    theta = (basis.at @ c).reshape(SPANS, POINTS)
    weight = basis.w.reshape(SPANS, POINTS) * length
    s, angle = [length * basis.inner], [basis.at_inner @ c]
    x = [np.concatenate([[0.0], np.cumsum(np.sum(weight * np.cos(theta), axis=1))])]
    y = [np.concatenate([[0.0], np.cumsum(np.sum(weight * np.sin(theta), axis=1))])]
    whole = sheet.length_m + sheet.elongation_m
    for begin, end in ((length, sheet.length_m), (sheet.length_m, whole)):
        if end - begin < 1e-9:
            continue
        h = (end - begin) / TAIL
        middle = begin + h * (np.arange(TAIL) + 0.5)
        k = _free_curvature(sheet, case, middle[None])[0] * (begin < sheet.length_m)
        turned = angle[-1][-1] + np.concatenate([[0.0], np.cumsum(k * h)])
        half = (turned[1:] + turned[:-1]) / 2.0
        share = 1.0 - (k * h) ** 2 / 24.0
        s.append(begin + h * np.arange(1, TAIL + 1))
        angle.append(turned[1:])
        x.append(x[-1][-1] + np.cumsum(h * share * np.cos(half)))
        y.append(y[-1][-1] + np.cumsum(h * share * np.sin(half)))
    at, way = np.concatenate(s), np.concatenate(angle)
    xs = CubicHermiteSpline(at, np.concatenate(x), np.cos(way))
    ys = CubicHermiteSpline(at, np.concatenate(y), np.sin(way))
    return xs(points_m), ys(points_m)
