"""The sheet held at a contact, by geometrically exact finite elements for its direction.

Unknown are the direction phi at the nodes of quadratic elements, the force on the sheet, and where
along the sheet the contact is. Virtual work of the moment, of the force at the contact and of the
weight gives the equations of the nodes; the force is the multiplier of the closure r(s_hat) =
p_hat. The mesh goes from the clamp to the contact and stretches with it; on a sheet with an
elongation it ends where the sheet does, and a rigid lever goes on. Newton's iteration is made for
many sheets at once: every array of `Cases` has shape (n,).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
ELEMENTS = 18
NODES = 2 * ELEMENTS + 1
_X, _W = np.polynomial.legendre.leggauss(3)
GAUSS, WEIGHTS = 0.5 * (1.0 + _X), 0.5 * _W / ELEMENTS  # within an element; of the whole mesh
MOST_STEPS = 60
CLOSED = 3e-7  # of the unknowns' last change, scaled; what is left is its square


def _forms(t: Array) -> tuple[Array, Array]:
    """Quadratic shape functions and their derivatives in the mesh's coordinate: (3, places)."""
    value = np.stack([(1 - t) * (1 - 2 * t), 4 * t * (1 - t), t * (2 * t - 1)])
    slope = np.stack([4 * t - 3, 4 - 8 * t, 4 * t - 1]) * ELEMENTS
    return value, slope


VALUE, SLOPE = _forms(GAUSS)
PLACE = ((np.arange(ELEMENTS)[:, None] + GAUSS) / ELEMENTS).ravel()  # of the Gauss points, 0 to 1
OF_ELEMENT = 2 * np.arange(ELEMENTS)[:, None] + np.arange(3)  # (ELEMENTS, 3) nodes
TO_POINT = np.zeros((PLACE.size, NODES))  # phi at the Gauss points from the nodes'
TO_SLOPE = np.zeros((PLACE.size, NODES))
for _e in range(ELEMENTS):
    _rows = slice(3 * _e, 3 * _e + 3)
    TO_POINT[_rows, OF_ELEMENT[_e]], TO_SLOPE[_rows, OF_ELEMENT[_e]] = VALUE.T, SLOPE.T
WEIGHT = np.tile(WEIGHTS, ELEMENTS)
# products of two nodes' shape functions, and of their slopes, at the Gauss points
VALUES, SLOPES = (
    (by[:, 1:, None] * by[:, None, 1:]).reshape(len(by), -1) for by in (TO_POINT, TO_SLOPE)
)


@dataclass(frozen=True, kw_only=True)
class Blade:
    """One configuration."""

    length_m: float
    elongation_m: float
    radius_m: float
    rest_per_m: Callable[[Array], Array]
    stiffness_Nm2: float


@dataclass
class Cases:
    """What differs from one equilibrium to the next."""

    position_m: Array
    moment_Nm: Array  # EIBM
    stiffness_Nm2: Array
    root_rad: Array
    offset_m: Array
    rubbing: Array  # force along the sheet over the normal one
    bow_per_m: Array  # added to the curvature at rest

    @staticmethod
    def of(position_m: Array, moment_Nm: Array, stiffness_Nm2: Array) -> Cases:
        """Return cases of which nothing else is known."""
        rest = [np.zeros(len(position_m)) for _ in range(4)]
        return Cases(position_m + 0.0, moment_Nm + 0.0, stiffness_Nm2 + 0.0, *rest)

    def table(self) -> Array:
        """All of them, (n, fields)."""
        return np.stack([getattr(self, f.name) for f in fields(self)], axis=1)

    def take(self, rows: npt.NDArray[np.intp]) -> Cases:
        """Return some of them."""
        return Cases(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass
class Point:
    """Points of the sheets, (n, points) each; a law changes what a moment follows from."""

    s_m: Array
    length_m: float
    curvature_per_m: Array
    contact_m: Array  # (n, 1); far away where nothing touches
    rest_per_m: Array
    eibm_Nm: Array
    stiffness_Nm2: Array


Law = Callable[[Point], None]


@dataclass(frozen=True)
class Setting:
    """What acts beside the contact."""

    laws: Sequence[Law] = ()
    clamp_rad_per_Nm: float = 0.0
    give_m_per_N: float = 0.0
    hinge_rad_per_Nm: float = 0.0  # where the elongation begins
    weight_N_per_m: float = 0.0
    bead_N: float = 0.0  # weight of a bead at the end
    pressed_offset_m: float = 0.0
    radius_error: float = 0.0  # of the arc


@dataclass
class Found:
    """Equilibria, (n,) each; the shape at `s_m` (n, places)."""

    phi: Array  # (n, NODES)
    force_N: Array  # (n, 2) on the sheet
    contact_m: Array
    angle_rad: Array  # of the sheet, or elongation, at the contact
    beta_rad: Array
    held: npt.NDArray[np.bool_]
    s_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    x_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    y_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    phi_rad: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def shown(self) -> tuple[Array, Array]:
        """Return the force on the load cell along the arc's tangent and outward."""
        c, s = np.cos(self.beta_rad), np.sin(self.beta_rad)
        x, y = -self.force_N.T
        return y * c - x * s, x * c + y * s

    def normal_N(self) -> Array:
        """Return N, of the sheet on the object."""
        x, y = -self.force_N.T
        return np.asarray(y * np.cos(self.angle_rad) - x * np.sin(self.angle_rad))


class Beam:
    """The equilibria of one blade."""

    def __init__(self, blade: Blade, setting: Setting) -> None:
        self.blade, self.setting = blade, setting
        self.bar = blade.elongation_m > 0.0
        self.whole_m = blade.length_m + blade.elongation_m

    # -- material

    def moment(self, cases: Cases, s: Array, k: Array, contact: Array) -> Array:
        """Return the moment of curvatures: (n, points)."""
        one = np.ones_like(s)
        at = Point(
            s, self.blade.length_m, k, contact,
            self.blade.rest_per_m(s) + cases.bow_per_m[:, None],
            cases.moment_Nm[:, None] * one, cases.stiffness_Nm2[:, None] * one,
        )  # fmt: skip
        for law in self.setting.laws:
            law(at)
        return at.stiffness_Nm2 * (k - at.rest_per_m) - at.eibm_Nm

    def tangent(self, cases: Cases, s: Array, k: Array, contact: Array) -> Array:
        """Return the derivative of the moment with respect to the curvature."""
        h = 1e-3
        above, below = (self.moment(cases, s, k + d, contact) for d in (h, -h))
        return (above - below) / (2.0 * h)

    def unloaded(self, cases: Cases, s: Array, contact: Array) -> Array:
        """Return the curvature at which there is no moment."""
        k = self.blade.rest_per_m(s) + (cases.moment_Nm / cases.stiffness_Nm2)[:, None]
        for _ in range(8):
            slope = self.tangent(cases, s, k, contact)
            k = k - self.moment(cases, s, k, contact) / slope
        return k

    # -- Newton's iteration

    def solve(self, cases: Cases, guess: Found | None = None) -> Found:
        """Return the held equilibria."""
        now = self._cold(cases) if guess is None else guess
        open_ = np.arange(len(cases.position_m))
        phi, force, contact = now.phi.copy(), now.force_N.copy(), now.contact_m.copy()
        beta, angle = now.beta_rad.copy(), now.angle_rad.copy()
        held = np.zeros(len(open_), dtype=np.bool_)
        for _ in range(MOST_STEPS):
            own = Found(phi[open_], force[open_], contact[open_], angle[open_], beta[open_], held)
            change = _Step(self, cases.take(open_), own).change()
            phi[open_], force[open_], contact[open_] = own.phi, own.force_N, own.contact_m
            angle[open_], beta[open_] = own.angle_rad, own.beta_rad
            done = change < CLOSED
            held[open_[done]] = True
            open_ = open_[~done]
            if not len(open_):
                break
        held &= contact <= self.whole_m
        return Found(phi, force, contact, angle, beta, held)

    def _cold(self, cases: Cases) -> Found:
        n, R = len(cases.position_m), self.blade.radius_m
        mesh = min(self.blade.length_m, R)
        s = np.tile(mesh * PLACE, (n, 1))
        k = self.unloaded(cases, s, np.full((n, 1), R))
        sigma = np.linspace(0.0, 1.0, NODES)
        inner = mesh * np.cumsum(k * WEIGHT, axis=1)
        free = cases.root_rad[:, None] + np.stack(
            [np.interp(sigma, np.r_[0.0, PLACE, 1.0], np.r_[0.0, row, row[-1]]) for row in inner]
        )
        path = mesh * np.stack([np.cos(free), np.sin(free)]).mean(axis=2)
        lever = max(0.0, R - mesh)
        x, y = path + lever * np.stack([np.cos(free[:, -1]), np.sin(free[:, -1])])
        beta = cases.position_m / R
        gap = beta - np.arctan2(y, x)
        soft = 1.0 - max(0.0, 1.0 - self.blade.length_m / R) ** 3
        phi = free + 1.5 * gap[:, None] * (2.0 * sigma - sigma**2)
        N = -3.0 * gap / soft * cases.stiffness_Nm2 / R**2
        end = phi[:, -1]
        force = -N[:, None] * np.stack([-np.sin(end), np.cos(end)], axis=1)
        held = np.zeros(n, dtype=np.bool_)
        return Found(phi, force, np.full(n, 1.01 * R), end.copy(), beta, held)

    def free(self, cases: Cases) -> Found:
        """Return the shapes that nothing touches."""
        n = len(cases.position_m)
        zero = np.zeros(n)
        found = self._cold(cases)
        found.force_N[:] = 0.0
        found.contact_m[:] = self.blade.length_m
        found.held[:] = True
        for _ in range(MOST_STEPS):
            step = _Step(self, cases, found)
            if np.max(step.change(free=True)) < CLOSED:
                break
        found.beta_rad = zero
        return found


class _Step:
    """One step of Newton's iteration; changes what it is given."""

    def __init__(self, beam: Beam, cases: Cases, at: Found) -> None:
        self.beam, self.cases, self.at = beam, cases, at
        self.n = len(cases.position_m)
        self.R = beam.blade.radius_m
        self.mesh = at.contact_m if not beam.bar else np.full(self.n, beam.blade.length_m)

    def change(self, free: bool = False) -> Array:
        """Take the step; return the largest change of each case, scaled."""
        bent = self._slow(free)
        rows, matrix = self._equations(bent, free)
        size = NODES - 1 if free else NODES + 2
        scale = self._scale()[:, :size]
        step = -np.linalg.solve(
            matrix[:, :size, :size] * scale[:, None, :], rows[:, :size, None]
        )[:, :, 0]  # fmt: skip
        longest = np.max(np.abs(step), axis=1)
        step /= np.maximum(1.0, longest / 0.4)[:, None]
        step *= scale
        self.at.phi[:, 1:] += step[:, : NODES - 1]
        if not free:
            self.at.force_N += step[:, NODES - 1 : NODES + 1]
            self.at.contact_m += step[:, NODES + 1]
        self.at.angle_rad = self.at.phi[:, -1] + bent
        return np.maximum(longest, self.moved)

    def _scale(self) -> Array:
        force = (self.cases.stiffness_Nm2 / self.R**2)[:, None]
        return np.concatenate(
            [np.ones((self.n, NODES - 1)), force, force, np.full((self.n, 1), self.R)], axis=1
        )

    def _slow(self, free: bool) -> Array:
        """Renew what changes little: clamp, hinge, give, from the step before; return the hinge."""
        at, set_ = self.at, self.beam.setting
        before = np.stack([at.phi[:, 0], at.angle_rad, at.beta_rad])
        beta = self.cases.position_m / self.R
        bent = np.zeros(self.n)
        root = self.cases.root_rad
        if not free:
            along, _ = at.shown()
            beta = beta + set_.give_m_per_N * along / self.R
            lever = at.contact_m - self.mesh
            f = at.force_N
            across = f[:, 1] * np.cos(at.angle_rad) - f[:, 0] * np.sin(at.angle_rad)
            bent = set_.hinge_rad_per_Nm * lever * across
            arm = self.R * (np.cos(beta) * f[:, 1] - np.sin(beta) * f[:, 0])
            root = root + set_.clamp_rad_per_Nm * arm
        at.phi[:, 0], at.beta_rad, at.angle_rad = root, beta, at.phi[:, -1] + bent
        after = np.stack([root, at.angle_rad, beta])
        self.moved = np.max(np.abs(after - before), axis=0)
        return bent

    def _equations(self, bent: Array, free: bool) -> tuple[Array, Array]:
        """Residuals (n, NODES + 2) and their derivatives: nodes 1 on, force, contact."""
        n, at, mesh = self.n, self.at, self.mesh[:, None]
        s, phi = mesh * PLACE, at.phi @ TO_POINT.T
        k = at.phi @ TO_SLOPE.T / mesh
        far = np.full((n, 1), 1.0) if free else at.contact_m[:, None]
        M = self.beam.moment(self.cases, s, k, far)
        C = self.beam.tangent(self.cases, s, k, far)
        c, d = np.cos(phi), np.sin(phi)
        fx, fy = at.force_N[:, :1], at.force_N[:, 1:]
        across, beyond = fy * c - fx * d, self._weight_beyond(s)
        rows = np.zeros((n, NODES + 2))
        matrix = np.zeros((n, NODES + 2, NODES + 2))
        w, last = WEIGHT, NODES - 2
        rows[:, : NODES - 1] = self._nodes(M, across - beyond * c)
        turn = mesh * (fx * c + fy * d - beyond * d) * w
        stiff = (C / mesh * w) @ SLOPES + turn @ VALUES
        stiff = stiff.reshape(n, NODES - 1, NODES - 1)
        matrix[:, : NODES - 1, : NODES - 1] = stiff
        couple = self._end_couple(free)
        rows[:, last] -= couple
        if free:
            return rows, matrix
        n_s = mesh * w
        by_x, by_y = (-d * n_s) @ TO_POINT[:, 1:], (c * n_s) @ TO_POINT[:, 1:]
        X, Y, S = NODES - 1, NODES, NODES + 1
        matrix[:, : NODES - 1, X], matrix[:, : NODES - 1, Y] = -by_x, -by_y
        matrix[:, X, : NODES - 1], matrix[:, Y, : NODES - 1] = by_x, by_y
        end = at.phi[:, -1] + bent
        tc, ts = np.cos(end), np.sin(end)
        t, normal = np.stack([tc, ts], axis=1), np.stack([-ts, tc], axis=1)
        lever, f = at.contact_m - self.mesh, at.force_N
        f_n, f_t = np.sum(f * normal, axis=1), np.sum(f * t, axis=1)
        if self.beam.bar:
            rows[:, last] -= lever * f_n
            matrix[:, last, last] += lever * f_t
            matrix[:, last, X : Y + 1] -= lever[:, None] * normal
            matrix[:, last, S] = -f_n
            matrix[:, X, S], matrix[:, Y, S] = tc, ts
        else:
            h = 1e-7
            by_s = (self.beam.moment(self.cases, s + h, k, far + h) - M) / h
            slope = (by_s * PLACE - C * k / mesh) * w
            matrix[:, : NODES - 1, S] = slope @ TO_SLOPE[:, 1:] - (across * w) @ TO_POINT[:, 1:]
            matrix[:, X, S], matrix[:, Y, S] = np.sum(c * w, axis=1), np.sum(d * w, axis=1)
        offset = self.cases.offset_m - self.beam.setting.pressed_offset_m * np.tanh(f_n / 0.3e-3)
        R = self.R * (1.0 + self.beam.setting.radius_error)
        hold = R * np.stack([np.cos(at.beta_rad), np.sin(at.beta_rad)], axis=1)
        path = np.stack([np.sum(c * n_s, axis=1), np.sum(d * n_s, axis=1)], axis=1)
        rows[:, X : Y + 1] = path + lever[:, None] * t + offset[:, None] * normal - hold
        matrix[:, X : Y + 1, last] += lever[:, None] * normal - offset[:, None] * t
        rub = self.cases.rubbing
        rows[:, S] = f_t + rub * f_n
        matrix[:, S, last] += f_n - rub * f_t
        matrix[:, S, X : Y + 1] = t + rub[:, None] * normal
        return rows, matrix

    def _nodes(self, M: Array, across: Array) -> Array:
        inner = (M * WEIGHT) @ TO_SLOPE[:, 1:]
        return inner - (self.mesh[:, None] * across * WEIGHT) @ TO_POINT[:, 1:]

    def _weight_beyond(self, s: Array) -> Array:
        set_ = self.beam.setting
        return set_.weight_N_per_m * (self.beam.whole_m - s) + set_.bead_N

    def _end_couple(self, free: bool) -> Array:
        """Moment on the mesh's end, of the weight of what lies beyond it."""
        set_, at = self.beam.setting, self.at
        if not (set_.weight_N_per_m or set_.bead_N) or (free and not self.beam.bar):
            return np.zeros(self.n)
        if self.beam.bar:
            left = self.beam.blade.elongation_m
            load = left * (0.5 * set_.weight_N_per_m * left + set_.bead_N)
            return np.asarray(-load * np.cos(at.angle_rad))
        left, phi = tail(self.beam, self.cases, at, 9)
        c = np.cos(phi)
        ds = left[:, None] / 8.0
        x = np.concatenate([np.zeros((self.n, 1)), np.cumsum(0.5 * (c[:, 1:] + c[:, :-1]), 1)], 1)
        x = x * ds
        mean = np.mean(0.5 * (x[:, 1:] + x[:, :-1]), axis=1)
        return np.asarray(-set_.weight_N_per_m * left * mean - set_.bead_N * x[:, -1])


def tail(beam: Beam, cases: Cases, at: Found, places: int) -> tuple[Array, Array]:
    """Return length and direction (n, places) of what lies beyond the contact, without load."""
    left = np.maximum(beam.blade.length_m - at.contact_m, 0.0)
    t = np.linspace(0.0, 1.0, 2 * places - 1)
    s = at.contact_m[:, None] + left[:, None] * t
    k = beam.unloaded(cases, s, at.contact_m[:, None])
    third = (k[:, :-2:2] + 4.0 * k[:, 1::2] + k[:, 2::2]) / 6.0 * left[:, None] / (places - 1)
    turned = np.concatenate([np.zeros((len(left), 1)), np.cumsum(third, axis=1)], axis=1)
    return left, at.phi[:, -1:] + turned
