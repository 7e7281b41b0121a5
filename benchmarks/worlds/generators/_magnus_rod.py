"""The sheet held at a contact, as a chain of plane motions: Magnus maps of fourth order on SE(2).

Unknown are the curvatures at the two Gauss points of each segment, the force on the sheet and where
along the sheet the contact is. A segment of length h with the curvatures k1, k2 moves the frame by
exp(h, sqrt(3)/12 h^2 (k1 - k2), h (k1 + k2)/2): exact for an arc, of fourth order else. The least
potential energy gives the equations of the curvatures; the force is the multiplier of the closure.
Newton's iteration has the exact second derivatives, and is made for many sheets at once: every
array of `Cases` has shape (n,), curvatures have (n, SEGMENTS, 2).
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, fields

import numpy as np
import numpy.typing as npt

from benchmarks.worlds.generators._magnus_motion import (
    GAUSS,
    SIDE,
    Path,
    at_gauss,
    hanging,
    path_of,
    turned,
)

Array = npt.NDArray[np.float64]
SEGMENTS = 12
OPEN = 2 * SEGMENTS  # curvatures of a case
PLACE = ((np.arange(SEGMENTS)[:, None] + GAUSS) / SEGMENTS)[None]
OF_SEGMENT = np.repeat(np.arange(SEGMENTS), 2)
LATER = np.where(
    OF_SEGMENT[:, None] > OF_SEGMENT, np.arange(OPEN)[:, None], np.arange(OPEN)[None, :]
)
MOST_STEPS = 50
STEP_M = 1e-8  # of the contact, for derivatives
CLOSED, SETTLED = 3e-7, 1e-9  # last changes: of Newton's unknowns (its square is left), of the rest


@dataclass(frozen=True, kw_only=True)
class Rod:
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
    load_N_per_m: Array  # along -y
    farther_m: Array  # radius of the arc less that stated

    @staticmethod
    def of(position_m: Array, moment_Nm: Array, stiffness_Nm2: Array) -> Cases:
        """Return cases of which nothing else is known."""
        rest = [np.zeros(len(position_m)) for _ in range(6)]
        return Cases(position_m + 0.0, moment_Nm + 0.0, stiffness_Nm2 + 0.0, *rest)

    def table(self) -> Array:
        """All of them, (n, fields)."""
        return np.stack([getattr(self, f.name) for f in fields(self)], axis=1)

    def take(self, rows: npt.NDArray[np.intp]) -> Cases:
        """Return some of them."""
        return Cases(*(getattr(self, f.name)[rows] for f in fields(self)))


@dataclass
class Section:
    """Places of the sheets, (n, ...) each; a law changes what a moment follows from."""

    s_m: Array
    length_m: float
    curvature_per_m: Array
    rest_per_m: Array
    eibm_Nm: Array
    stiffness_Nm2: Array


Law = Callable[[Section], None]


@dataclass(frozen=True)
class Setting:
    """What acts beside the contact."""

    laws: Sequence[Law] = ()
    clamp_rad_per_Nm: float = 0.0
    give_m_per_N: float = 0.0
    joint_rad: float = 0.0  # the elongation's joint turns by so much at most
    joint_Nm: float = 5e-5  # moment at which it has made 76 % of that
    bar_bow_per_m: float = 0.0  # curvature of the elongation


@dataclass
class State:
    """Sheets as they lie; what changes little follows from the step before."""

    kappa: Array  # (n, SEGMENTS, 2)
    force_N: Array  # (n, 2), on the sheet
    contact_m: Array
    root_rad: Array
    beta_rad: Array
    bent_rad: Array  # of the elongation's joint
    extra_Nm: Array  # (n, SEGMENTS, 2) moment of the weight
    angle_rad: Array  # of the sheet, or elongation, at the contact
    held: npt.NDArray[np.bool_]

    def take(self, rows: npt.NDArray[np.intp]) -> State:
        """Return some of them."""
        return State(*(getattr(self, f.name)[rows] for f in fields(self)))

    def put(self, rows: npt.NDArray[np.intp], some: State) -> None:
        """Take some of them over."""
        for f in fields(self):
            getattr(self, f.name)[rows] = getattr(some, f.name)

    def between(self, other: State, share: Array) -> State:
        """Return what lies between two, not solved."""
        mixed = []
        for f in fields(self):
            low, high = getattr(self, f.name), getattr(other, f.name)
            part = share.reshape((-1,) + (1,) * (low.ndim - 1))
            if f.name == "held":
                mixed.append(low & high)
            else:  # an equilibrium that there is not may be at the other end
                mixed.append(np.where(part == 0.0, low, low + part * (high - low)))
        return State(*mixed)

    def shown(self) -> tuple[Array, Array]:
        """Return the force on the load cell along the arc's tangent and outward."""
        c, s = np.cos(self.beta_rad), np.sin(self.beta_rad)
        x, y = -self.force_N.T
        return y * c - x * s, x * c + y * s

    def normal_N(self) -> Array:
        """Return N, of the sheet on the object."""
        x, y = -self.force_N.T
        return np.asarray(y * np.cos(self.angle_rad) - x * np.sin(self.angle_rad))


class Sheets:
    """The equilibria of one rod."""

    def __init__(self, rod: Rod, setting: Setting) -> None:
        self.rod, self.setting = rod, setting
        self.bar = rod.elongation_m > 0.0
        self.whole_m = rod.length_m + rod.elongation_m

    # -- material

    def moment(self, cases: Cases, s: Array, k: Array) -> Array:
        """Return the moment of curvatures."""
        wide = (slice(None),) + (None,) * (k.ndim - 1)
        one = np.ones_like(k)
        at = Section(
            s, self.rod.length_m, k, self.rod.rest_per_m(s) + cases.bow_per_m[wide],
            cases.moment_Nm[wide] * one, cases.stiffness_Nm2[wide] * one,
        )  # fmt: skip
        for law in self.setting.laws:
            law(at)
        return at.stiffness_Nm2 * (k - at.rest_per_m) - at.eibm_Nm

    def tangent(self, cases: Cases, s: Array, k: Array) -> Array:
        """Return the derivative of the moment with respect to the curvature."""
        if not self.setting.laws:
            wide = (slice(None),) + (None,) * (k.ndim - 1)
            return cases.stiffness_Nm2[wide] * np.ones_like(k)
        step = 1e-3
        above, below = (self.moment(cases, s, k + d) for d in (step, -step))
        return (above - below) / (2.0 * step)

    def curvature(self, cases: Cases, s: Array, moment: Array) -> Array:
        """Return the curvature at which there is this moment."""
        wide = (slice(None),) + (None,) * (s.ndim - 1)
        k = self.rod.rest_per_m(s) + (cases.moment_Nm / cases.stiffness_Nm2)[wide]
        for _ in range(12):
            step = (self.moment(cases, s, k) - moment) / self.tangent(cases, s, k)
            k = k - step
            if float(np.max(np.abs(step), initial=0.0)) < 1e-9:
                break
        return k

    # -- equilibria

    def solve(self, cases: Cases, start: State) -> State:
        """Return the held equilibria, from states near them."""
        now = start.take(np.arange(len(cases.position_m)))
        now.held[:] = False
        left = np.arange(len(now.held))
        for _ in range(MOST_STEPS):
            own = now.take(left)
            change = _Step(self, cases.take(left), own).change()
            now.put(left, own)
            now.held[left[change < 1.0]] = True
            left = left[(change >= 1.0) & np.isfinite(change)]
            if not len(left):
                break
        now.held &= (now.contact_m <= self.whole_m) & (now.contact_m > 0.0)
        return self._told(now)

    def _told(self, now: State) -> State:
        """Leave something that can be drawn where there is no equilibrium."""
        lost = ~now.held
        now.force_N[lost] = 0.0
        now.kappa[lost] = np.clip(np.nan_to_num(now.kappa[lost]), -200.0, 200.0)
        contact = np.nan_to_num(now.contact_m[lost], nan=self.rod.length_m)
        now.contact_m[lost] = np.clip(contact, 0.3 * self.rod.length_m, self.whole_m)
        for turn in (now.root_rad, now.beta_rad, now.bent_rad, now.extra_Nm, now.angle_rad):
            turn[lost] = np.nan_to_num(turn[lost])
        return now

    def cold(self, cases: Cases) -> State:
        """Return the held equilibria as a session reaches them: put in place, then driven."""
        idle = cases.take(np.arange(len(cases.position_m)))
        idle.moment_Nm[:] = 0.0
        state, begin = self._touched(idle)
        for share in (0.0, 0.35, 0.7, 1.0):
            idle.position_m = begin + share * (cases.position_m - begin)
            state = self.solve(idle, state)
        for share in (0.25, 0.5, 0.75, 1.0):
            idle.moment_Nm = share * cases.moment_Nm
            state = self.solve(idle, state)
        return state

    def _touched(self, cases: Cases) -> tuple[State, Array]:
        """Return sheets under no load where they cross the arc, and the positions there."""
        n, zero = len(cases.position_m), np.zeros(len(cases.position_m))
        R = self.rod.radius_m + cases.farther_m
        mesh = np.full(n, self.rod.length_m)
        contact, h = mesh, mesh[:, None] / SEGMENTS
        kappa = self.curvature(cases, mesh[:, None, None] * PLACE, np.zeros((n, SEGMENTS, 2)))
        path = path_of(kappa, h, zero, zero, cases.root_rad)
        x, y, phi = path.x[:, -1], path.y[:, -1], path.phi[:, -1]
        for _ in range(30):  # Newton's iteration for the crossing, along the end's direction
            c, s = np.cos(phi), np.sin(phi)
            far = (np.hypot(x, y) - R) / np.maximum((x * c + y * s) / np.hypot(x, y), 0.2)
            contact = contact - far
            if not self.bar:
                mesh = np.clip(contact, 0.3 * self.rod.length_m, self.rod.length_m)
            h = mesh[:, None] / SEGMENTS
            kappa = self.curvature(cases, mesh[:, None, None] * PLACE, np.zeros((n, SEGMENTS, 2)))
            path = path_of(kappa, h, zero, zero, cases.root_rad)
            lever, phi = contact - mesh, path.phi[:, -1]
            x = path.x[:, -1] + lever * np.cos(phi)
            y = path.y[:, -1] + lever * np.sin(phi)
            if float(np.max(np.abs(far), initial=0.0)) < 1e-7:
                break
        beta = np.arctan2(y, x)
        state = State(
            kappa, np.zeros((n, 2)), contact.copy(), cases.root_rad.copy(), beta.copy(),
            zero.copy(), np.zeros_like(kappa), phi.copy(), np.zeros(n, dtype=np.bool_),
        )  # fmt: skip
        return state, beta * R


class _Step:
    """One step of Newton's iteration; changes what it is given."""

    def __init__(self, sheets: Sheets, cases: Cases, at: State) -> None:
        self.sheets, self.cases, self.at = sheets, cases, at
        self.bow = sheets.setting.bar_bow_per_m
        self.R = sheets.rod.radius_m + cases.farther_m

    def change(self) -> Array:
        """Take the step; return the largest change of each case over what is small enough."""
        at, n = self.at, len(self.cases.position_m)
        moved, half = self._slow(), 0.5 * self._mesh(at.contact_m) / SEGMENTS
        rows, matrix = self._equations()
        K, F = 1.0 / self.R, self.cases.stiffness_Nm2 / self.R**2
        columns = np.concatenate(
            [np.repeat(K[:, None], OPEN, axis=1), np.stack([F, F, self.R], axis=1)], axis=1
        )
        step = _solved(matrix * columns[:, None, :], -rows)
        longest = np.max(np.abs(step), axis=1)
        step = columns * step / np.maximum(1.0, longest / 0.7)[:, None]
        at.kappa += step[:, :OPEN].reshape(n, SEGMENTS, 2)
        at.force_N += step[:, OPEN : OPEN + 2]
        at.contact_m += step[:, OPEN + 2]
        end = at.root_rad + np.sum(at.kappa, axis=(1, 2)) * half
        at.angle_rad = end + at.bent_rad + self.bow * self._lever(at.contact_m)
        return np.maximum(longest / CLOSED, moved / SETTLED)

    def _lever(self, contact: Array) -> Array:
        return contact - self._mesh(contact)

    def _mesh(self, contact: Array) -> Array:
        rod = self.sheets.rod
        return np.full_like(contact, rod.length_m) if self.sheets.bar else contact

    def _slow(self) -> Array:
        """Renew clamp, joint, give and weight from the step before; return how far they moved."""
        at, setting, f = self.at, self.sheets.setting, self.at.force_N
        along, _ = at.shown()
        beta = (self.cases.position_m + setting.give_m_per_N * along) / self.R
        arm = self.R * (np.cos(at.beta_rad) * f[:, 1] - np.sin(at.beta_rad) * f[:, 0])
        root = self.cases.root_rad + setting.clamp_rad_per_Nm * arm
        bent = np.zeros(len(beta))
        if setting.joint_rad:
            moment = -self._lever(at.contact_m) * at.normal_N()
            bent = setting.joint_rad * np.tanh(moment / setting.joint_Nm)
        moved = np.max(np.abs([root - at.root_rad, beta - at.beta_rad, bent - at.bent_rad]), axis=0)
        at.root_rad, at.beta_rad, at.bent_rad = root, beta, bent
        if np.any(self.cases.load_N_per_m):
            extra = weighed(self.sheets, self.cases, at)
            change = np.max(np.abs(extra - at.extra_Nm), axis=(1, 2)) * self.R
            moved = np.maximum(moved, 1e-2 * change / self.cases.stiffness_Nm2)
            at.extra_Nm = extra
        return moved

    def _end(self, contact: Array) -> _End:
        """Return the motions up to the contact."""
        at, mesh = self.at, self._mesh(contact)
        h = mesh[:, None] / SEGMENTS
        zero = np.zeros(len(contact))
        path = path_of(at.kappa, h, zero, zero, at.root_rad)
        lean, lever = path.phi[:, -1] + at.bent_rad, contact - mesh
        (p,), (q,) = turned(self.bow * lever)
        c, s = lever * np.cos(lean), lever * np.sin(lean)
        x, y = path.x[:, -1] + c * p - s * q, path.y[:, -1] + s * p + c * q
        return _End(path, mesh[:, None, None] * PLACE, 0.5 * h, x, y, lean + self.bow * lever)

    def _ways(self, end: _End) -> tuple[Array, Array]:
        """Return how the contact moves with each curvature, x and y: (n, SEGMENTS, 2)."""
        h, path, half = end.path.h, end.path, end.half[..., None]
        aside, by = h * h * (self.at.kappa @ SIDE), SIDE * (h * h)[..., None]
        (a, a1), (b, b1) = turned(np.diff(path.phi, axis=1), 2)
        du = half * (a1 * h - b1 * aside)[..., None] - by * b[..., None]
        dv = half * (b1 * h + a1 * aside)[..., None] + by * a[..., None]
        c, s = np.cos(path.phi[:, :-1])[..., None], np.sin(path.phi[:, :-1])[..., None]
        to_x, to_y = end.beyond()
        return c * du - s * dv - half * to_y, s * du + c * dv + half * to_x

    def _twice(self, end: _End) -> Array:
        """Return F times how it moves with the two of a segment: (n, SEGMENTS, 2, 2)."""
        h, path, half = end.path.h, end.path, end.half[..., None, None]
        aside, by = h * h * (self.at.kappa @ SIDE), SIDE * (h * h)[..., None]
        (_, a1, a2), (_, b1, b2) = turned(np.diff(path.phi, axis=1), 3)
        cross = half * (by[..., :, None] + by[..., None, :])
        uu = half**2 * (a2 * h - b2 * aside)[..., None, None] - cross * b1[..., None, None]
        vv = half**2 * (b2 * h + a2 * aside)[..., None, None] + cross * a1[..., None, None]
        c, s = (f(path.phi[:, :-1])[..., None, None] for f in (np.cos, np.sin))
        to_x, to_y = (to[..., None] for to in end.beyond())
        fx, fy = (f[:, None, None, None] for f in self.at.force_N.T)
        by_x = c * uu - s * vv - half**2 * to_x
        by_y = s * uu + c * vv - half**2 * to_y
        return np.asarray(fx * by_x + fy * by_y)

    def _residual(self, end: _End, ways: tuple[Array, Array]) -> Array:
        """Return what is out of balance: moments, closure, force along the sheet."""
        at, cases, n = self.at, self.cases, len(end.x)
        fx, fy = (f[:, None, None] for f in at.force_N.T)
        M = self.sheets.moment(cases, end.s_m, at.kappa)
        balance = end.half[..., None] * (M - at.extra_Nm) - fx * ways[0] - fy * ways[1]
        rows = np.empty((n, OPEN + 3))
        rows[:, :OPEN] = balance.reshape(n, OPEN)
        rows[:, OPEN] = end.x - cases.offset_m * end.sine - self.R * np.cos(at.beta_rad)
        rows[:, OPEN + 1] = end.y + cases.offset_m * end.cosine - self.R * np.sin(at.beta_rad)
        along, across = end.parts(at.force_N)
        rows[:, OPEN + 2] = along + cases.rubbing * across
        return rows

    def _equations(self) -> tuple[Array, Array]:
        """Return scaled residuals and derivatives: curvatures, force, contact."""
        at, cases, n = self.at, self.cases, len(self.cases.position_m)
        end = self._end(at.contact_m)
        ways = self._ways(end)
        rows = self._residual(end, ways)
        gx, gy = (way.reshape(n, OPEN) for way in ways)
        X, Y, S = OPEN, OPEN + 1, OPEN + 2
        matrix = np.zeros((n, OPEN + 3, OPEN + 3))
        matrix[:, :OPEN, :OPEN] = self._stiffness(end, gx, gy)
        matrix[:, :OPEN, X], matrix[:, :OPEN, Y] = -gx, -gy
        rub, aside = cases.rubbing, end.half * cases.offset_m[:, None]
        along, across = end.parts(at.force_N)
        matrix[:, X, :OPEN] = gx - aside * end.cosine[:, None]
        matrix[:, Y, :OPEN] = gy - aside * end.sine[:, None]
        matrix[:, S, :OPEN] = end.half * (across - rub * along)[:, None]
        matrix[:, S, X], matrix[:, S, Y] = end.cosine - rub * end.sine, end.sine + rub * end.cosine
        if self.sheets.bar:
            matrix[:, :OPEN, S] = -end.half * across[:, None]
            matrix[:, X, S] = end.cosine * (1.0 - self.bow * cases.offset_m)
            matrix[:, Y, S] = end.sine * (1.0 - self.bow * cases.offset_m)
            matrix[:, S, S] = self.bow * (across - rub * along)
        else:
            further = self._end(at.contact_m + STEP_M)
            matrix[:, :, S] = (self._residual(further, self._ways(further)) - rows) / STEP_M
        scale = np.empty((n, OPEN + 3))
        scale[:, :OPEN] = end.half * (cases.stiffness_Nm2 / self.R)[:, None]
        scale[:, X : Y + 1] = self.R[:, None]
        scale[:, S] = cases.stiffness_Nm2 / self.R**2
        return rows / scale, matrix / scale[..., None]

    def _stiffness(self, end: _End, gx: Array, gy: Array) -> Array:
        """Return the energy's second derivatives by the curvatures, (n, OPEN, OPEN)."""
        fx, fy = (f[:, None] for f in self.at.force_N.T)
        turning = end.half * (fy * gx - fx * gy)  # F on what turns with all that lies before it
        matrix = -turning[:, LATER]
        C = self.sheets.tangent(self.cases, end.s_m, self.at.kappa)
        own = (end.half[..., None] * C)[..., None] * np.eye(2) - self._twice(end)
        for e in range(SEGMENTS):
            matrix[:, 2 * e : 2 * e + 2, 2 * e : 2 * e + 2] = own[:, e]
        return matrix


@dataclass
class _End:
    """Where the contact is, seen from the clamp."""

    path: Path
    s_m: Array  # (n, SEGMENTS, 2)
    half: Array  # (n, 1), of a segment's length
    x: Array
    y: Array
    angle_rad: Array

    def __post_init__(self) -> None:
        self.cosine, self.sine = np.cos(self.angle_rad), np.sin(self.angle_rad)

    def beyond(self) -> tuple[Array, Array]:
        """Return the way from each segment's end to the contact, (n, SEGMENTS, 1)."""
        x, y = self.x[:, None] - self.path.x[:, 1:], self.y[:, None] - self.path.y[:, 1:]
        return x[..., None], y[..., None]

    def parts(self, force_N: Array) -> tuple[Array, Array]:
        """Return a force along the sheet and across."""
        x, y = force_N.T
        return x * self.cosine + y * self.sine, y * self.cosine - x * self.sine


def _solved(matrix: Array, rows: Array) -> Array:
    """Solve, and give back what is not finite where there is no solution."""
    good = np.all(np.isfinite(matrix), axis=(1, 2)) & np.all(np.isfinite(rows), axis=1)
    result = np.full_like(rows, np.nan)
    try:
        result[good] = np.linalg.solve(matrix[good], rows[good][..., None])[..., 0]
    except np.linalg.LinAlgError:
        matrix = matrix + 1e-12 * np.eye(matrix.shape[1])
        result[good] = np.linalg.solve(matrix[good], rows[good][..., None])[..., 0]
    return result


# ---------------------------------------------------------------------------------- the weight


def weighed(sheets: Sheets, cases: Cases, at: State) -> Array:
    """Return the weight's moment at the Gauss points of held sheets."""
    n = len(at.contact_m)
    zero = np.zeros(n)
    mesh = np.full(n, sheets.rod.length_m) if sheets.bar else at.contact_m
    path = path_of(at.kappa, mesh[:, None] / SEGMENTS, zero, zero, at.root_rad)
    q = cases.load_N_per_m
    if sheets.bar:
        left, lean = np.full(n, sheets.rod.elongation_m), np.cos(path.phi[:, -1] + at.bent_rad)
        beyond = -q * 0.5 * left**2 * lean
    else:
        left = np.maximum(sheets.rod.length_m - at.contact_m, 0.0)
        _, tail = beyond_contact(sheets, cases, at, path)
        beyond = hanging(tail, q, zero, zero)[0][:, 0]
    values, slopes = hanging(path, q, q * left, beyond)
    return at_gauss(values, slopes, path.h)


def beyond_contact(sheets: Sheets, cases: Cases, at: State, path: Path) -> tuple[Array, Path]:
    """Return curvatures and path of the sheet beyond the contact."""
    left = np.maximum(sheets.rod.length_m - at.contact_m, 0.0)
    start = path.x[:, -1], path.y[:, -1], path.phi[:, -1]
    return unheld(sheets, cases, at.contact_m, left, start, passes=4)


def unheld(
    sheets: Sheets, cases: Cases, from_m: Array, left: Array, start: tuple[Array, Array, Array],
    passes: int,
) -> tuple[Array, Path]:  # fmt: skip
    """Return a part that nothing touches: its own weight, and that of what it carries, bends it."""
    h = left[:, None] / SEGMENTS
    s = from_m[:, None, None] + left[:, None, None] * PLACE
    moment, q = np.zeros_like(s), cases.load_N_per_m
    carried = q * sheets.rod.elongation_m
    for _ in range(passes if np.any(q) else 1):
        kappa = sheets.curvature(cases, s, moment)
        path = path_of(kappa, h, *start)
        lean = 0.5 * sheets.rod.elongation_m * np.cos(path.phi[:, -1])
        values, slopes = hanging(path, q, carried, -carried * lean)
        moment = at_gauss(values, slopes, h)
    return kappa, path
