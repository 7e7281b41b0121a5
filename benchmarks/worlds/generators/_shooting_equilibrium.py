"""The sheet held at a contact, by shooting from the clamp with an adaptive Runge-Kutta method.

Many sheets are shot at once: every array of `Lanes` has shape (n,). Unknown are the force on the
sheet, two components, and where along the sheet the contact is; to be met are the contact's place,
two components, and the law of the force along the sheet (none, or friction).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, fields, replace

import numpy as np
import numpy.typing as npt
from scipy.integrate import solve_ivp

Array = npt.NDArray[np.float64]
RTOL, ATOL = 1e-9, 1e-10
PLACES = 49  # of a solved shape, over each of its parts
MOST_STEPS = 40
LONGEST = np.array([[1.0], [1.0], [0.15]])  # step of the unknowns
CLOSED = 1e-7  # of the scaled residuals


@dataclass(frozen=True, kw_only=True)
class Strip:
    """One configuration."""

    length_m: float
    elongation_m: float  # 0: none; where there is one, the contact is on it
    radius_m: float  # of the arc
    rest_per_m: Callable[[Array], Array]  # k0(s)
    stiffness_Nm2: float


@dataclass
class Lanes:
    """What differs from one equilibrium to the next; each of shape (n,)."""

    position_m: Array  # along the arc
    moment_Nm: Array  # EIBM at the clamp's end
    stiffness_Nm2: Array
    root_rad: Array  # direction at the clamp
    offset_m: Array  # from the sheet to the point on the arc, along the sheet's normal
    friction: Array  # force along the sheet over the normal one, signed
    bow_per_m: Array  # added to k0
    front_m: Array  # a place that moves along the sheet

    @staticmethod
    def of(position_m: Array, moment_Nm: Array, stiffness_Nm2: Array) -> Lanes:
        """Return lanes of which nothing else is known."""
        zeros = {f.name: np.zeros(len(position_m)) for f in fields(Lanes)}
        zeros["position_m"], zeros["moment_Nm"] = position_m, moment_Nm
        zeros["stiffness_Nm2"] = stiffness_Nm2 + 0.0
        return Lanes(**zeros)

    def table(self) -> Array:
        """All of them, (n, fields)."""
        return np.stack([getattr(self, f.name) for f in fields(self)], axis=1)

    def take(self, rows: npt.NDArray[np.intp]) -> Lanes:
        """Return some of them."""
        return Lanes(**{f.name: getattr(self, f.name)[rows] for f in fields(self)})


@dataclass
class Section:
    """The sheet's cross sections at one arc length of each lane, before they are bent."""

    s_m: Array
    length_m: float
    rest_per_m: Array  # k0
    eibm_Nm: Array  # Me
    load_Nm: Array  # M
    stiffness_Nm2: Array  # B
    lanes: Lanes


Law = Callable[[Section], None]  # changes a section in place


@dataclass(frozen=True)
class Surroundings:
    """What acts on the sheet beside the contact; sizes of what is hidden, 0 where it is not."""

    laws: Sequence[Law] = ()
    clamp_rad_per_Nm: float = 0.0  # turn of the clamp, limited to `clamp_most_rad`
    clamp_most_rad: float = 0.03
    give_m_per_N: float = 0.0  # of the load cell
    give_from_N: float = 8e-3  # where it is half as compliant
    backlash_m: float = 0.0
    backlash_N: float = 0.4e-3
    bar_compliance: float = 0.0  # of the elongation, over the sheet's
    bar_drawn_on: bool = False  # its picture goes straight on from the sheet's end
    weight_N_per_m: float = 0.0
    bar_weight: float = 2.0  # of the elongation, over the sheet's
    rocking_Nm_per_rad: float = 0.0


@dataclass
class Shapes:
    """Solved equilibria, each array (n,) or (n, places)."""

    force_N: Array  # (2, n) on the sheet
    contact_m: Array  # s_hat
    angle_rad: Array  # phi_hat
    beta_rad: Array  # polar angle of the contact
    closed: npt.NDArray[np.bool_]
    s_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    x_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    y_m: Array = field(default_factory=lambda: np.zeros((0, 0)))
    phi_rad: Array = field(default_factory=lambda: np.zeros((0, 0)))

    def of_object(self) -> tuple[Array, Array]:
        """Return the force on the load cell, along the arc's tangent and outward: (n,) each."""
        fx, fy = -self.force_N
        c, s = np.cos(self.beta_rad), np.sin(self.beta_rad)
        return fy * c - fx * s, fx * c + fy * s

    def way(self) -> Array:
        """Return the sign of N, the normal force of the sheet on the object."""
        n = _frame(self.angle_rad)[1]
        return np.asarray(-np.sign(np.sum(self.force_N * n, axis=0)))


class Shooting:
    """The equilibria of one strip."""

    def __init__(self, strip: Strip, around: Surroundings) -> None:
        self.strip, self.around = strip, around
        self.bar = strip.elongation_m > 0.0

    # -- the shot

    def _curvature(self, s: Array, load: Array, lanes: Lanes) -> Array:
        here = Section(
            s, self.strip.length_m, self.strip.rest_per_m(s) + lanes.bow_per_m,
            lanes.moment_Nm, load, lanes.stiffness_Nm2, lanes,
        )  # fmt: skip
        for law in self.around.laws:
            law(here)
        return here.rest_per_m + (here.eibm_Nm + here.load_Nm) / here.stiffness_Nm2

    def _shot(
        self, lanes: Lanes, state: Array, a: Array, b: Array,
        load: Callable[[Array, Array], Array], dense: bool,
    ) -> Array:  # fmt: skip
        """Integrate (phi, x, y, integral of x) from a to b: (4, n), or (4, n, places)."""
        n, span = state.shape[1], b - a

        def slope(t: float, flat: Array) -> Array:
            y = flat.reshape(4, n)
            s = a + t * span
            k = self._curvature(s, load(s, y), lanes)
            return (span * np.stack([k, np.cos(y[0]), np.sin(y[0]), y[1]])).ravel()

        at = np.linspace(0.0, 1.0, PLACES) if dense else None
        found = solve_ivp(
            slope, (0.0, 1.0), state.ravel(), "DOP853", t_eval=at,
            rtol=RTOL, atol=ATOL, first_step=0.25,
        )  # fmt: skip
        result: Array = found.y.reshape(4, n, -1)
        return result if dense else result[:, :, -1]

    def _held(
        self, lanes: Lanes, q: Array, weight: Array, couple: Array, dense: bool = False
    ) -> list[Array]:
        """Shoot to the contact: states at its ends, or the parts of the shape."""
        force, s_hat = self._force(q), q[2] * self.strip.radius_m
        hold = self._hold(lanes, force)
        length = self.strip.length_m
        heavy, bar = self.around.weight_N_per_m, self.around.bar_weight * self.strip.elongation_m

        def load(s: Array, y: Array) -> Array:
            moment = (hold[0] - y[1]) * force[1] - (hold[1] - y[2]) * force[0] + couple
            if heavy:
                moment = moment - (weight - heavy * (y[3] + (length - s + bar) * y[1]))
            return moment

        arm = hold[0] * force[1] - hold[1] * force[0] + couple - weight
        start = np.zeros((4, len(s_hat)))
        most = self.around.clamp_most_rad
        turn = self.around.clamp_rad_per_Nm * arm / most
        start[0] = lanes.root_rad + most * turn / np.sqrt(1.0 + turn**2)
        zero = np.zeros(len(s_hat))
        if not self.bar:
            return [self._shot(lanes, start, zero, s_hat, load, dense)]
        first = self._shot(lanes, start, zero, zero + length, load, dense)
        end = first[:, :, -1] if dense else first
        return [first, self._along_bar(lanes, end, s_hat, load, dense)]

    def _along_bar(
        self, lanes: Lanes, end: Array, s_hat: Array,
        load: Callable[[Array, Array], Array], dense: bool,
    ) -> Array:  # fmt: skip
        length, give = self.strip.length_m, self.around.bar_compliance
        if give:
            tapered = self.strip.elongation_m

            def soft(s: Array, y: Array) -> Array:
                more = 0.5 + (s - length) / tapered  # a bar that becomes thinner
                return give * more * load(s, y)

            stiff = Shooting(
                replace(self.strip, rest_per_m=np.zeros_like), Surroundings()
            )  # nothing but the load bends the bar
            none = Lanes.of(lanes.position_m, np.zeros(len(s_hat)), lanes.stiffness_Nm2)
            return stiff._shot(none, end, 0.0 * s_hat + length, s_hat, soft, dense)
        t = np.linspace(0.0, 1.0, PLACES) if dense else np.ones(1)
        d = (s_hat - length)[:, None] * t
        c, s = np.cos(end[0])[:, None], np.sin(end[0])[:, None]
        x, y = end[1][:, None] + c * d, end[2][:, None] + s * d
        area = end[3][:, None] + (end[1][:, None] + 0.5 * c * d) * d
        ray = np.stack([end[0][:, None] + 0.0 * d, x, y, area])
        return ray if dense else ray[:, :, 0]

    # -- the contact

    def _force(self, q: Array) -> Array:
        return np.asarray(q[:2] * self.strip.stiffness_Nm2 / self.strip.radius_m**2)

    def _beta(self, lanes: Lanes, force: Array) -> Array:
        """Return where the load cell is once it has given way, along the tangent there."""
        stated = lanes.position_m / self.strip.radius_m
        beta, a = stated, self.around
        for _ in range(4 if a.give_m_per_N or a.backlash_m else 0):
            along = force[0] * np.sin(beta) - force[1] * np.cos(beta)
            moved = a.give_m_per_N * along / (1.0 + np.abs(along) / a.give_from_N)
            moved = moved + a.backlash_m * np.tanh(along / a.backlash_N)
            beta = stated + moved / self.strip.radius_m
        return beta

    def _hold(self, lanes: Lanes, force: Array) -> Array:
        beta = self._beta(lanes, force)
        return self.strip.radius_m * np.stack([np.cos(beta), np.sin(beta)])

    def _residual(self, lanes: Lanes, q: Array, weight: Array, couple: Array) -> Array:
        end = self._held(lanes, q, weight, couple)[-1]
        force = self._force(q)
        t, n = _frame(end[0])
        gap = end[1:3] + lanes.offset_m * n - self._hold(lanes, force)
        scale = self.strip.radius_m**2 / self.strip.stiffness_Nm2
        normal = -np.sum(force * n, axis=0)
        slide = (np.sum(force * t, axis=0) - lanes.friction * normal) * scale
        return np.concatenate([gap / self.strip.radius_m, slide[None]])

    def solve(self, lanes: Lanes, guess: Array | None = None, *, dense: bool = False) -> Shapes:
        """Return the equilibria; `guess` (3, n) as `unknowns` gives it."""
        q = self._cold(lanes) if guess is None else guess.copy()
        weight, couple = np.zeros(q.shape[1]), np.zeros(q.shape[1])
        slow = bool(self.around.weight_N_per_m or self.around.rocking_Nm_per_rad)
        if slow:
            weight, couple = self._slow_terms(lanes, q, weight, couple)
        residual = self._residual(lanes, q, weight, couple)
        jacobian = np.zeros((q.shape[1], 3, 3))
        stale = np.ones(q.shape[1], dtype=np.bool_)
        for _ in range(MOST_STEPS):
            norm = np.max(np.abs(residual), axis=0)
            rows = np.flatnonzero(norm >= CLOSED)
            if not len(rows):
                break
            own, old = lanes.take(rows), np.flatnonzero(stale[rows])
            if len(old):
                some = rows[old]
                jacobian[some] = self._jacobian(
                    lanes.take(some), q[:, some], residual[:, some], weight[some], couple[some]
                )
            step = -np.linalg.solve(jacobian[rows], residual.T[rows][:, :, None])[:, :, 0].T
            q[:, rows] += step / np.maximum(1.0, np.max(np.abs(step) / LONGEST, axis=0))
            if slow:
                weight[rows], couple[rows] = self._slow_terms(
                    own, q[:, rows], weight[rows], couple[rows]
                )
            residual[:, rows] = self._residual(own, q[:, rows], weight[rows], couple[rows])
            stale[rows] = np.max(np.abs(residual[:, rows]), axis=0) > 0.1 * norm[rows]
        return self._shapes(lanes, q, weight, couple, residual, dense)

    def _jacobian(
        self, lanes: Lanes, q: Array, residual: Array, weight: Array, couple: Array
    ) -> Array:
        """(n, 3, 3) by differences, all of them in one shot."""
        n, h = q.shape[1], 1e-5
        three = lanes.take(np.tile(np.arange(n), 3))
        moved = np.tile(q, 3)
        for k in range(3):
            moved[k, k * n : (k + 1) * n] += h
        there = self._residual(three, moved, np.tile(weight, 3), np.tile(couple, 3))
        columns = (there.reshape(3, 3, n) - residual[:, None, :]) / h
        return np.ascontiguousarray(columns.transpose(2, 0, 1))

    def _slow_terms(
        self, lanes: Lanes, q: Array, weight: Array, couple: Array
    ) -> tuple[Array, Array]:
        """What depends on the whole shape, from the shape before."""
        end = self._held(lanes, q, weight, couple)
        tip = end[0]
        if not self.bar:
            tip = self._tail(lanes, end[0], q[2] * self.strip.radius_m, dense=False)
        e = self.strip.elongation_m
        bar = self.around.bar_weight * e * (tip[1] + 0.5 * e * np.cos(tip[0]))
        weight = self.around.weight_N_per_m * (tip[3] + bar)
        lean = end[-1][0] - self._beta(lanes, self._force(q))
        return weight, -self.around.rocking_Nm_per_rad * lean

    def _tail(self, lanes: Lanes, end: Array, s_hat: Array, dense: bool) -> Array:
        """From the contact to the sheet's end, which bears no load; its weight is left out."""
        rest = np.maximum(s_hat, self.strip.length_m)

        def nothing(s: Array, _y: Array) -> Array:
            return np.zeros(len(s))

        return self._shot(lanes, end, s_hat, rest, nothing, dense)

    def _cold(self, lanes: Lanes) -> Array:
        """A first guess, from the free shape."""
        n, R = len(lanes.position_m), self.strip.radius_m
        zero = np.zeros(n)
        reach = zero + min(R, self.strip.length_m)
        start = np.zeros((4, n))
        start[0] = lanes.root_rad
        free = self._shot(lanes, start, zero, reach, lambda s, _y: 0.0 * s, dense=False)
        left = np.maximum(R - self.strip.length_m, 0.0)
        x, y = free[1] + left * np.cos(free[0]), free[2] + left * np.sin(free[0])
        gap = lanes.position_m / R - np.arctan2(y, x)
        soft = 1.0 - max(0.0, 1.0 - self.strip.length_m / R) ** 3
        normal = -3.0 * gap / soft
        n_hat = _frame(free[0] + 1.5 * gap)[1]
        return np.concatenate([-normal * n_hat, np.full((1, n), 1.01)])

    def _shapes(
        self, lanes: Lanes, q: Array, weight: Array, couple: Array, residual: Array, dense: bool
    ) -> Shapes:
        parts = self._held(lanes, q, weight, couple, dense=dense)
        force, s_hat = self._force(q), q[2] * self.strip.radius_m
        last = parts[-1][:, :, -1] if dense else parts[-1]
        closed = np.all(np.abs(residual) < 1e-6, axis=0)
        closed &= s_hat <= self.strip.length_m + self.strip.elongation_m
        shapes = Shapes(force, s_hat, last[0], self._beta(lanes, force), closed)
        if dense:
            self._draw(shapes, lanes, parts, last)
        return shapes

    def _draw(self, shapes: Shapes, lanes: Lanes, parts: list[Array], last: Array) -> None:
        t, length = np.linspace(0.0, 1.0, PLACES), self.strip.length_m
        s_hat = shapes.contact_m[:, None]
        if self.bar:
            places = [np.tile(length * t, (len(s_hat), 1)), length + (s_hat - length) * t]
            left = length + self.strip.elongation_m - s_hat
            ray = np.stack([last[0][:, None] + 0.0 * left * t] * 4)
            ray[1] = last[1][:, None] + np.cos(last[0])[:, None] * left * t
            ray[2] = last[2][:, None] + np.sin(last[0])[:, None] * left * t
            parts = [*parts, ray]
            places.append(s_hat + left * t)
            if self.around.bar_drawn_on:
                _draw_on(parts, places)
        else:
            parts = [*parts, self._tail(lanes, last, shapes.contact_m, dense=True)]
            places = [s_hat * t, s_hat + (np.maximum(length, s_hat) - s_hat) * t]
        shapes.s_m = np.concatenate([places[0], *(p[:, 1:] for p in places[1:])], axis=1)
        both = np.concatenate([parts[0], *(p[:, :, 1:] for p in parts[1:])], axis=2)
        shapes.phi_rad, shapes.x_m, shapes.y_m = both[:3]

    def free(self, lanes: Lanes) -> Shapes:
        """Return the shapes that nothing touches."""
        n = len(lanes.position_m)
        zero, length = np.zeros(n), np.full(n, self.strip.length_m)
        weight, heavy = zero, self.around.weight_N_per_m
        bar, e = self.around.bar_weight * self.strip.elongation_m, self.strip.elongation_m

        def load(s: Array, y: Array) -> Array:
            return -(weight - heavy * (y[3] + (length - s + bar) * y[1]))

        start = np.zeros((4, n))
        for _ in range(12 if heavy else 1):
            start[0] = lanes.root_rad
            path = self._shot(lanes, start, zero, length, load, dense=True)
            tip = path[:, :, -1]
            weight = heavy * (tip[3] + bar * (tip[1] + 0.5 * e * np.cos(tip[0])))
        shapes = Shapes(np.zeros((2, n)), length, tip[0], zero, np.ones(n, dtype=np.bool_))
        t = np.linspace(0.0, 1.0, PLACES)
        ray = np.stack([tip[0][:, None] + 0.0 * t] * 3)
        ray[1] = tip[1][:, None] + e * np.cos(tip[0])[:, None] * t
        ray[2] = tip[2][:, None] + e * np.sin(tip[0])[:, None] * t
        joined = np.concatenate([path[:3], ray[:, :, 1:]], axis=2) if e else path[:3]
        s = length[:, None] * t
        shapes.s_m = np.concatenate([s, s[:, -1:] + e * t[1:]], axis=1) if e else s
        shapes.phi_rad, shapes.x_m, shapes.y_m = joined
        return shapes


def _draw_on(parts: list[Array], places: list[Array]) -> None:
    """Draw the elongation, the second and third part, as a line on from the sheet's end."""
    joint = parts[1][:3, :, :1]
    way = np.stack([np.cos(joint[0]), np.sin(joint[0])])
    for k in (1, 2):
        parts[k] = parts[k].copy()
        parts[k][0] = joint[0]
        parts[k][1:3] = joint[1:] + way * (places[k] - places[1][:, :1])


def unknowns(shapes: Shapes, strip: Strip) -> Array:
    """Return (3, n) to start another solution from."""
    scale = strip.radius_m**2 / strip.stiffness_Nm2
    return np.concatenate([shapes.force_N * scale, shapes.contact_m[None] / strip.radius_m])


def _frame(phi: Array) -> tuple[Array, Array]:
    """Tangent and normal, (2, n)."""
    return np.stack([np.cos(phi), np.sin(phi)]), np.stack([-np.sin(phi), np.cos(phi)])
