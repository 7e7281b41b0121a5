"""The strip: a boundary-value problem, collocated on Chebyshev nodes and solved by Newton's method.

Unknown are the direction theta and the moment m of all loads over B (1/m) at nodes between clamp
and contact, the force f of the rolls on the strip over B (1/m^2), and how far away s_hat is:

    d theta/ds = k0 + C(s) g(m + Me/B),  d m/ds = -t x (f + what hangs beyond s),  r(s_hat) = p_hat
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt
from numpy.polynomial import chebyshev

A = npt.NDArray[np.float64]
Along = Callable[[A], A]  # of s (m)

ORDER = 26
SMALL = 1e-7  # of the difference quotients
FINE = 400  # intervals of the curve beyond the contact


def unchanged(value: A) -> A:
    """Return a linear material's bending (1/m) for moment over B (1/m)."""
    return value


def none(value: A) -> A:
    """Return nothing."""
    return np.zeros_like(value)


@dataclass(kw_only=True)
class Strip:
    """One configuration with its true values; lists are where something may be hidden."""

    name: str
    free_m: float
    bar_m: float
    arc_m: float
    B_Nm2: float
    bends_per_m: tuple[float, float]  # Me/B at +2 V and at -2 V
    k0: list[Along]  # 1/m, to be added up
    compliance: list[Along] = field(default_factory=list)  # factors of 1/B
    material: Along = unchanged
    eibm: list[Callable[[A, A], A]] = field(default_factory=list)  # factors, of s and alpha
    even: list[Along] = field(default_factory=list)  # moment over B (1/m), times alpha^2
    couple: list[Along] = field(default_factory=list)  # moment (N m)
    hangs: list[Along] = field(default_factory=list)  # force (N) along y on what is beyond s
    drawn: list[Along] = field(default_factory=list)  # the same, times alpha^2
    clamp_rad: float = 0.0
    clamp_gives: float = 0.0  # rad/(N m)
    joint: float = 0.0  # turn of the bar's joint, in units of free_m/B
    beside_m: float = 0.0  # of the arc's point from the strip, on the side that presses
    yields: Along = none  # m along the arc, of the force (N)
    arc_grows_m: float = 0.0

    def stated(self, s: A) -> A:
        """Return k0 (1/m)."""
        return np.sum([f(s) for f in self.k0], axis=0)

    def active(self, s: A, alpha: A) -> A:
        """Return what bends the strip but for loads, over B (1/m); alpha is voltage/2 V."""
        plus, minus = self.bends_per_m
        found = np.where(alpha < 0.0, minus, plus) * np.abs(alpha) * np.ones_like(s)
        for f in self.eibm:
            found = found * f(s, alpha)
        found = found + sum(alpha**2 * f(s) for f in self.even)
        return np.asarray(found + sum(f(s) / self.B_Nm2 for f in self.couple))

    def given(self, s: A) -> A:
        """Return nominal B over B."""
        found = np.ones_like(s)
        for f in self.compliance:
            found = found * f(s)
        return found

    def hanging(self, s: A, alpha: A) -> A:
        """Return dead loads beyond s over B (1/m^2), along y."""
        found = np.zeros_like(s) + sum(f(s) for f in self.hangs)
        return np.asarray((found + sum(alpha**2 * f(s) for f in self.drawn)) / self.B_Nm2)


@dataclass(frozen=True)
class Problem:
    """Conditions solved together, each (conditions,)."""

    place_m: A  # along the arc; nan: nothing touches
    alpha: A
    more_per_m: A  # of rest curvature
    rub_N: A  # force along the strip on it

    def only(self, i: int) -> Problem:
        """Return one of them."""
        return Problem(*(getattr(self, f.name)[i : i + 1] for f in fields(self)))


@dataclass(frozen=True)
class Solution:
    """Forces on the load cell over B (1/m^2) and curves (conditions, points)."""

    along_arc: A
    outwards: A
    gamma_rad: A
    contact_m: A
    x_m: A
    y_m: A


class _Nodes:
    """Chebyshev-Lobatto nodes on [0, 1]: differentiation and integration matrices."""

    def __init__(self, order: int) -> None:
        x = -np.cos(np.pi * np.arange(order + 1) / order)
        self.at: A = (x + 1.0) / 2.0
        to = chebyshev.chebvander(x, order)
        from_values = np.linalg.inv(to)
        unit = np.eye(order + 1)
        slope = np.array([np.pad(chebyshev.chebder(c), (0, 1)) for c in unit]).T
        grown = np.array([chebyshev.chebint(c, lbnd=-1.0) for c in unit]).T
        self.derive: A = 2.0 * to @ slope @ from_values
        self.integrate: A = chebyshev.chebvander(x, order + 1) @ grown @ from_values / 2.0
        self.weights: A = self.integrate[-1]
        self.coefficients: A = from_values


NODES = _Nodes(ORDER)
COUNT = ORDER + 1


def solved(strip: Strip, problem: Problem, points_m: A) -> Solution:
    """Return equilibria and their curves; ValueError where the strip slips out of the rolls."""
    held = np.isfinite(problem.place_m)
    goal = np.where(held, problem.place_m / strip.arc_m, 0.0)
    v, here = _unloaded(strip, problem)
    for share in (0.25, 0.5, 0.75):
        v = _steps(strip, problem, v, here + share * (goal - here), held, 3)
    v = _steps(strip, problem, v, goal, held, 30)
    if np.max(np.abs(_equations(strip, problem, v, goal, held))) > 1e-7:
        raise ValueError(f"the {strip.name} strip slips out of the rolls at some position")
    return _read(strip, problem, v, goal, held, points_m)


def _parts(strip: Strip, v: A, held: A) -> tuple[A, A, A, A, A]:
    """Return theta, m, f, the length between clamp and contact, and the bar's lever."""
    theta, moment = v[:, :COUNT], v[:, COUNT : 2 * COUNT] / strip.arc_m
    force = v[:, -3:-1] / strip.arc_m**2
    reach = np.where(held, v[:, -1] * strip.arc_m, strip.free_m)
    length = np.minimum(reach, strip.free_m)
    return theta, moment, force, length[:, None], (reach - length)[:, None]


def _equations(strip: Strip, problem: Problem, v: A, angle: A, held: A) -> A:
    """Return the residuals (conditions, 2 COUNT + 3), all without dimension."""
    theta, m, f, length, lever = _parts(strip, v, held)
    alpha = problem.alpha[:, None]
    s = length * NODES.at
    bend = strip.stated(s) + problem.more_per_m[:, None]
    bend = bend + strip.given(s) * strip.material(m + strip.active(s, alpha))
    turns = theta @ NODES.derive.T - length * bend
    cos, sin = np.cos(theta), np.sin(theta)
    crossed = cos * (f[:, 1:] + strip.hanging(s, alpha)) - sin * f[:, :1]
    loads = (m @ NODES.derive.T + length * crossed) * strip.arc_m
    turns[:, 0] = theta[:, 0] - strip.clamp_rad - strip.clamp_gives * strip.B_Nm2 * m[:, 0]
    end = theta[:, -1:] + strip.joint * strip.free_m * m[:, -1:] * (lever > 0.0)
    offset = _offset(strip, end, f)
    moment = lever * _cross(end, f) - offset * _dot(end, f)
    moment = moment + _beyond(strip, problem, end, length)
    loads[:, -1] = ((m[:, -1:] - moment) * strip.arc_m)[:, 0]
    tip = length * np.stack([cos @ NODES.weights, sin @ NODES.weights], axis=1)
    along = np.concatenate([np.cos(end), np.sin(end)], axis=1)
    across = np.concatenate([-np.sin(end), np.cos(end)], axis=1)
    gap = tip + lever * along + offset * across - _on_arc(strip, angle, f)
    slide = _dot(end, f)[:, 0] - problem.rub_N / strip.B_Nm2
    gap = np.where(held[:, None], gap / strip.arc_m, v[:, -3:-1])
    slide = np.where(held, slide * strip.arc_m**2, v[:, -1] - strip.free_m / strip.arc_m)
    return np.concatenate([turns, loads, gap, slide[:, None]], axis=1)


def _cross(angle: A, f: A) -> A:
    return np.asarray(np.cos(angle) * f[:, 1:] - np.sin(angle) * f[:, :1])


def _dot(angle: A, f: A) -> A:
    return np.asarray(np.cos(angle) * f[:, :1] + np.sin(angle) * f[:, 1:])


def _offset(strip: Strip, end: A, f: A) -> A:
    """Return how far beside the strip the arc's point is: it goes over where nothing presses."""
    normal = -_cross(end, f) * strip.B_Nm2
    return np.asarray(strip.beside_m * normal / np.hypot(normal, 1e-4))


def _on_arc(strip: Strip, angle: A, f: A) -> A:
    shown = -(f[:, 1] * np.cos(angle) - f[:, 0] * np.sin(angle)) * strip.B_Nm2
    beta = angle + strip.yields(shown) / strip.arc_m
    return (strip.arc_m + strip.arc_grows_m) * np.stack([np.cos(beta), np.sin(beta)], axis=1)


def _beyond(strip: Strip, problem: Problem, end: A, length: A) -> A:
    """Return the moment over B of what hangs on the part beyond the contact."""
    if not strip.hangs and not strip.drawn:
        return np.zeros_like(end)
    rest = strip.free_m + strip.bar_m - length
    s = length + rest * NODES.at
    k = np.where(length < strip.free_m, _loose(strip, problem, length), 0.0)
    lever = np.cos(end + k * (s - length)) * strip.hanging(s, problem.alpha[:, None])
    return np.asarray(rest * (lever @ NODES.weights)[:, None])


def _loose(strip: Strip, problem: Problem, s: A) -> A:
    """Return the curvature (1/m) of a part without load."""
    active = strip.active(s, problem.alpha[:, None])
    bend = strip.given(s) * strip.material(active)
    return np.asarray(strip.stated(s) + problem.more_per_m[:, None] + bend)


def _steps(strip: Strip, problem: Problem, v: A, angle: A, held: A, most: int) -> A:
    """Return the unknowns after Newton steps."""
    for _ in range(most):
        now = _equations(strip, problem, v, angle, held)
        if np.max(np.abs(now)) < 1e-10:
            break
        jacobian = np.empty((*v.shape, v.shape[1]))
        for j in range(v.shape[1]):
            v[:, j] += SMALL
            jacobian[:, :, j] = (_equations(strip, problem, v, angle, held) - now) / SMALL
            v[:, j] -= SMALL
        step = np.linalg.solve(jacobian, now[:, :, None])[:, :, 0]
        turned = np.max(np.abs(step[:, :COUNT]), axis=1, keepdims=True)
        v = v - step / np.maximum(1.0, turned / 0.5)
    return v


def _unloaded(strip: Strip, problem: Problem) -> tuple[A, A]:
    """Return unknowns without a force, where the loose strip crosses the arc, and that angle."""
    count = len(problem.alpha)
    reach = np.full(count, strip.free_m)
    for _ in range(12):  # along the strip until it is as far from the clamp as the arc
        theta, x, y = _loose_curve(strip, problem, np.minimum(reach, strip.free_m))
        along = x[:, -1] * np.cos(theta[:, -1]) + y[:, -1] * np.sin(theta[:, -1])
        lever = np.maximum(reach - strip.free_m, 0.0)
        far2 = x[:, -1] ** 2 + y[:, -1] ** 2 + 2 * along * lever + lever**2
        slope = 2.0 * np.maximum(along + lever, 0.2 * strip.arc_m)
        change = (strip.arc_m**2 - far2) / slope
        reach = np.clip(reach + change, 0.5 * strip.free_m, strip.arc_m * 2.0)
    held = np.isfinite(problem.place_m)
    reach = np.where(held, reach, strip.free_m)
    theta, x, y = _loose_curve(strip, problem, np.minimum(reach, strip.free_m))
    lever = np.maximum(reach - strip.free_m, 0.0)
    x_end = x[:, -1] + lever * np.cos(theta[:, -1])
    y_end = y[:, -1] + lever * np.sin(theta[:, -1])
    start = np.zeros((count, 2 * COUNT + 3))
    start[:, :COUNT], start[:, -1] = theta, reach / strip.arc_m
    return start, np.arctan2(y_end, x_end)


def _loose_curve(strip: Strip, problem: Problem, length: A) -> tuple[A, A, A]:
    long = length[:, None]
    k = _loose(strip, problem, long * NODES.at)
    theta = strip.clamp_rad + long * (k @ NODES.integrate.T)
    x, y = (long * (f(theta) @ NODES.integrate.T) for f in (np.cos, np.sin))
    return theta, x, y


# ------------------------------------------------------------------------------ what is read


def _read(strip: Strip, problem: Problem, v: A, angle: A, held: A, points_m: A) -> Solution:
    theta, m, f, length, lever = _parts(strip, v, held)
    ends = theta[:, -1] + strip.joint * strip.free_m * m[:, -1] * (lever[:, 0] > 0.0)
    curves = [
        _drawn_curve(
            strip, problem.only(i), theta[i], float(length[i, 0]), float(ends[i]), points_m
        )
        for i in range(len(theta))
    ]
    return Solution(
        -(f[:, 1] * np.cos(angle) - f[:, 0] * np.sin(angle)),
        -(f[:, 0] * np.cos(angle) + f[:, 1] * np.sin(angle)),
        ends - angle,
        (length + lever)[:, 0],
        np.array([x for x, _ in curves]),
        np.array([y for _, y in curves]),
    )


def _drawn_curve(
    strip: Strip, problem: Problem, theta: A, length: float, end_rad: float, points_m: A
) -> tuple[A, A]:
    """Return x, y at points along strip and bar."""
    inside = points_m <= length
    xy = []
    for f in (np.cos, np.sin):
        integral = NODES.coefficients @ (NODES.integrate @ f(theta)) * length
        xy.append(chebyshev.chebval(2.0 * points_m[inside] / length - 1.0, integral))
    tip = [length * float(NODES.weights @ f(theta)) for f in (np.cos, np.sin)]
    whole = strip.free_m + strip.bar_m
    if whole - length < 1e-9:
        return xy[0], xy[1]
    s = np.linspace(length, whole, FINE + 1)
    h, middle = s[1] - s[0], (s[1:] + s[:-1]) / 2.0
    k = _loose(strip, problem, middle[None])[0] * (middle < strip.free_m)
    begin = float(theta[-1]) if length < strip.free_m else end_rad
    turned = begin + np.cumsum(k) * h - k * h / 2.0
    outside = points_m[~inside]
    for i, f in enumerate((np.cos, np.sin)):
        way = tip[i] + np.concatenate([[0.0], np.cumsum(f(turned)) * h])
        xy[i] = np.concatenate([xy[i], np.interp(outside, s, way)])
    return xy[0], xy[1]
