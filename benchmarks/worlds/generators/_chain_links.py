"""A clamped strip as a chain of rigid links, held by a frictionless point on an arc.

`LINKS` links of equal length reach from the clamp to the contact, or to the strip's free end where
the contact is on the rigid elongation. Torsion springs join them: half a link's share of the
strip's bending in the joint at the clamp, half in the last one, one share in each other one. In
equilibrium the energy of springs and contact is stationary in all joint angles, in the length
between clamp and contact, and in the contact force; Newton's method finds that point, along the
arc from where the free strip crosses it. Two chains, one twice as fine, are extrapolated to links
of no length (Richardson): the error of a chain is of second order.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.interpolate import CubicSpline

Floats = npt.NDArray[np.float64]
Bending = Callable[[Floats], Floats]  # curvature over the rest curvature, from moment over B

LINKS = 20
FINE = 401  # points along the strip at which its properties are given
STEPS = 6  # along the arc
ROUNDS = 30
ENOUGH = 1e-10
STEP_M = 1e-7  # of the numerical derivative by the length


@dataclass(frozen=True, kw_only=True)
class Strip:
    """What bends. All along `s_m` (FINE,), from the clamp to the free end."""

    s_m: Floats
    rest_per_m: Floats
    driven_per_m: Floats  # EIBM over B at amplitude 1
    even_per_m: Floats  # moment over B that goes with the amplitude's square
    softness: Floats  # B over the local stiffness
    stiffness_Nm2: float  # B
    clamp_angle_rad: float = 0.0
    clamp_give_rad_per_Nm: float = 0.0
    bending: Bending | None = None  # None: Hooke's law


@dataclass(frozen=True, kw_only=True)
class Hold:
    """Where strips are held: one entry of (n,) for each equilibrium. Lengths in m."""

    amplitude: Floats  # of the EIBM
    position_m: Floats  # along the arc
    radius_m: float
    beside_m: float = 0.0  # from the sheet to the point on the arc, along the sheet's normal
    drag_N: Floats | float = 0.0  # on the sheet, along its tangent
    weight_N_per_m: float = 0.0  # along -y, of strip and elongation
    whole_m: float = 0.0  # length of strip and elongation: what has weight


@dataclass(frozen=True, kw_only=True)
class Equilibria:
    """Each of (n,) entries."""

    force_N: tuple[Floats, Floats]  # x and y, on the sheet
    length_m: Floats  # from the clamp to the contact
    angle_rad: Floats  # of the sheet at the contact
    at: Floats  # (m,) share of the chain
    bent_per_m: Floats  # (n, m) curvature that the load adds
    root_rad: Floats  # by which the clamp gives way
    unknowns: Floats  # of the coarser chain


class _Along:
    """A property along the strip with its integral; beyond the end it is 0."""

    def __init__(self, s_m: Floats, values: Floats) -> None:
        self._value = CubicSpline(s_m, values)
        self._integral = self._value.antiderivative()
        self._end = float(s_m[-1])

    def at(self, s_m: Floats) -> Floats:
        return np.asarray(self._value(np.minimum(s_m, self._end)))

    def upto(self, s_m: Floats) -> Floats:
        return np.asarray(self._integral(np.minimum(s_m, self._end)))


class Chain:
    """A strip cut into links."""

    def __init__(self, strip: Strip, links: int = LINKS) -> None:
        self.strip, self.links = strip, links
        self.free_m = float(strip.s_m[-1])
        self._rest = _Along(strip.s_m, strip.rest_per_m)
        self._driven = _Along(strip.s_m, strip.driven_per_m)
        self._even = _Along(strip.s_m, strip.even_per_m)
        self._soft = _Along(strip.s_m, strip.softness)

    # ------------------------------------------------------------------------- what is at rest

    def unloaded(self, s_m: Floats, amplitude: Floats) -> Floats:
        """Return the angle of the strip under no load, (n, m) at (n, m)."""
        u, strip = amplitude[:, None], self.strip
        turned = self._rest.upto(s_m) + u * self._driven.upto(s_m) + u * u * self._even.upto(s_m)
        if strip.bending is not None:
            drive = u * strip.driven_per_m + u * u * strip.even_per_m
            more = strip.bending(drive) - drive  # (n, FINE)
            for row, own, at in zip(turned, more, s_m, strict=True):
                row += _Along(strip.s_m, own).upto(at)
        return np.asarray(turned + strip.clamp_angle_rad)

    def _joint_angles(
        self, moment: Floats, s_m: Floats, span: tuple[Floats, Floats], u: Floats
    ) -> Floats:
        """Return the angles (n, m) that springs take under moments over B (n, m)."""
        low, high = s_m - span[0], s_m + span[1]
        free = [p.upto(high) - p.upto(low) for p in (self._rest, self._driven, self._even)]
        width = high - low
        loaded = self._soft.at(s_m) * moment
        angle = free[0] + u * free[1] + u * u * free[2] + width * loaded
        if self.strip.bending is not None:
            whole = u * self._driven.at(s_m) + u * u * self._even.at(s_m) + loaded
            angle += width * (self.strip.bending(whole) - whole)
        give = self.strip.clamp_give_rad_per_Nm * self.strip.stiffness_Nm2
        angle[:, 0] += give * moment[:, 0] + self.strip.clamp_angle_rad
        return np.asarray(angle)

    def _compliance(self, moment: Floats, s_m: Floats, width: Floats, u: Floats) -> Floats:
        """Return the derivative of joint angles by moments over B."""
        slope = np.ones_like(moment)
        if self.strip.bending is not None:
            whole = u * self._driven.at(s_m) + u * u * self._even.at(s_m)
            whole += self._soft.at(s_m) * moment
            slope = (self.strip.bending(whole + 1e-4) - self.strip.bending(whole - 1e-4)) / 2e-4
        result = width * self._soft.at(s_m) * slope
        result[:, 0] += self.strip.clamp_give_rad_per_Nm * self.strip.stiffness_Nm2
        return np.asarray(result)

    # ------------------------------------------------------------------------- equilibrium

    def residual(self, x: Floats, hold: Hold, extra: Floats) -> tuple[Floats, _State]:
        """Return what is out of balance, (n, links + 4), and the chain as it lies."""
        n = self.links
        angles, length, force = x[:, : n + 1], x[:, n + 1], x[:, n + 2 :]
        state = _State.of(self, angles, length, force, extra)
        u = hold.amplitude[:, None]
        want = self._joint_angles(state.moment, state.s_m, state.span, u)
        beta = hold.position_m / hold.radius_m
        end = state.angle_rad
        beside = hold.beside_m
        out = np.empty_like(x)
        out[:, : n + 1] = angles - want
        out[:, n + 1] = state.end[0] - beside * np.sin(end) - hold.radius_m * np.cos(beta)
        out[:, n + 2] = state.end[1] + beside * np.cos(end) - hold.radius_m * np.sin(beta)
        drag = np.asarray(hold.drag_N) / self.strip.stiffness_Nm2
        out[:, n + 3] = force[:, 0] * np.cos(end) + force[:, 1] * np.sin(end) - drag
        return out, state

    def _jacobian(self, x: Floats, hold: Hold, extra: Floats, out: Floats, state: _State) -> Floats:
        """Return derivatives (n, links + 4, links + 4), those by length and force by steps."""
        n, count = self.links, len(x)
        J = np.zeros((count, n + 4, n + 4))
        give = self._compliance(
            state.moment, state.s_m, state.span[0] + state.span[1], hold.amplitude[:, None]
        )
        along = state.work[:, np.maximum.outer(np.arange(n + 1), np.arange(n + 1))]
        J[:, : n + 1, : n + 1] = np.eye(n + 1) - give[:, :, None] * along
        end, beside = state.angle_rad, hold.beside_m
        # a turn of joint m moves the end at right angles to the line from m to it
        J[:, n + 1, : n + 1] = -state.lever[1] - (beside * np.cos(end))[:, None]
        J[:, n + 2, : n + 1] = state.lever[0] - (beside * np.sin(end))[:, None]
        turned = -x[:, n + 2] * np.sin(end) + x[:, n + 3] * np.cos(end)
        J[:, n + 3, : n + 1] = turned[:, None]
        for k, step in ((n + 1, STEP_M), (n + 2, 1e-3), (n + 3, 1e-3)):
            moved = x.copy()
            moved[:, k] += step
            J[:, :, k] = (self.residual(moved, hold, extra)[0] - out) / step
        return J

    def newton(self, x: Floats, hold: Hold, extra: Floats) -> Floats:
        """Return the stationary point near `x`; raise `ValueError` where there is none."""
        for _ in range(ROUNDS):
            out, state = self.residual(x, hold, extra)
            if np.max(np.abs(out)) < ENOUGH:
                return x
            J = self._jacobian(x, hold, extra, out, state)
            try:
                step = np.linalg.solve(J, out[..., None])[..., 0]
            except np.linalg.LinAlgError:
                break
            size = np.max(np.abs(step[:, : self.links + 1]), axis=1, keepdims=True)
            x = x - step * np.minimum(1.0, 0.3 / np.maximum(size, 1e-300))
        raise ValueError("the chain cannot be held there")


@dataclass(frozen=True)
class _State:
    """A chain as it lies. Moments are over B."""

    s_m: Floats  # (n, links + 1) of the joints
    span: tuple[Floats, Floats]  # of each joint's spring, before and behind it
    end: tuple[Floats, Floats]
    angle_rad: Floats
    lever: tuple[Floats, Floats]  # (n, links + 1) from each joint to the end
    moment: Floats
    work: Floats  # (n, links + 1) derivative of the moment by the angle of this or an earlier joint

    @staticmethod
    def of(chain: Chain, angles: Floats, length: Floats, force: Floats, extra: Floats) -> _State:
        n = chain.links
        link = np.minimum(length, chain.free_m)[:, None] / n
        phi = np.cumsum(angles, axis=1)  # (n, links + 1): of each link, then of the elongation
        part = np.concatenate(
            [np.repeat(link, n, axis=1), np.maximum(length - chain.free_m, 0.0)[:, None]], axis=1
        )
        fx, fy = force[:, :1], force[:, 1:]
        dx, dy = part * np.cos(phi), part * np.sin(phi)
        lever = _from(dx), _from(dy)
        half = np.full(n + 1, 0.5)
        before, behind = half.copy(), half.copy()
        before[0], behind[-1] = 0.0, 0.0
        return _State(
            s_m=link * np.arange(n + 1),
            span=(link * before, link * behind),
            end=(lever[0][:, 0], lever[1][:, 0]),
            angle_rad=phi[:, -1],
            lever=lever,
            moment=lever[0] * fy - lever[1] * fx + extra,
            work=-(lever[0] * fx + lever[1] * fy),
        )


def _from(parts: Floats) -> Floats:
    """Return sums from each place to the end."""
    return np.asarray(np.cumsum(parts[:, ::-1], axis=1)[:, ::-1])


def _crossing(chain: Chain, hold: Hold) -> tuple[Floats, Floats]:
    """Return length (n,) and position (n,) where free strips cross the arc."""
    s = np.linspace(0.0, 1.5 * hold.radius_m, 1501)
    phi = chain.unloaded(np.broadcast_to(s, (len(hold.amplitude), len(s))), hold.amplitude)
    x, y = integrate(s, phi)
    far = np.hypot(x, y) > hold.radius_m
    first = np.argmax(far, axis=1)
    rows = np.arange(len(first))
    before, behind = (np.hypot(x, y)[rows, first + k] for k in (-1, 0))
    share = (hold.radius_m - before) / (behind - before)
    at = [v[rows, first - 1] + share * (v[rows, first] - v[rows, first - 1]) for v in (x, y)]
    return s[first - 1] + share * (s[1] - s[0]), hold.radius_m * np.arctan2(at[1], at[0])


def integrate(s_m: Floats, phi: Floats) -> tuple[Floats, Floats]:
    """Return x and y along curves from the angles."""
    both = CubicSpline(s_m, np.stack([np.cos(phi), np.sin(phi)]), axis=-1).antiderivative()
    x, y = both(s_m)
    return np.asarray(x), np.asarray(y)


def _started(chain: Chain, hold: Hold) -> Floats:
    """Return the chain under no load, where it crosses the arc."""
    n = chain.links
    length, _ = _crossing(chain, hold)
    link = np.minimum(length, chain.free_m)[:, None] / n
    edges = link * np.clip(np.arange(n + 2) - 0.5, 0.0, n)
    angles = np.diff(chain.unloaded(edges, hold.amplitude), axis=1)
    angles[:, 0] += chain.strip.clamp_angle_rad
    return np.concatenate([angles, length[:, None], np.zeros((len(length), 2))], axis=1)


def _weight(chain: Chain, hold: Hold, x: Floats) -> Floats:
    """Return the weight's moments over B at the joints, (n, links + 1); what is beyond is stiff."""
    if hold.weight_N_per_m == 0.0:
        return np.zeros((len(x), chain.links + 1))
    n = chain.links
    state = _State.of(chain, x[:, : n + 1], x[:, n + 1], x[:, n + 2 :], np.zeros((1, 1)))
    steps = -np.diff(state.lever[0], axis=1, append=0.0)
    link = np.diff(state.s_m, axis=1, append=0.0)
    link[:, -1] = np.maximum(x[:, n + 1] - chain.free_m, 0.0)
    # from joint j to the middle of link i, for all i from j on
    middle = state.lever[0][:, :, None] - (state.lever[0] - 0.5 * steps)[:, None, :]
    beyond = np.triu(np.ones((n + 1, n + 1)))
    moment = np.sum(middle * link[:, None, :] * beyond, axis=2)
    tail = np.maximum(hold.whole_m - x[:, n + 1], 0.0)[:, None]
    moment += tail * (state.lever[0] + 0.5 * tail * np.cos(state.angle_rad)[:, None])
    return np.asarray(-hold.weight_N_per_m / chain.strip.stiffness_Nm2 * moment)


def _solved(chain: Chain, hold: Hold, x: Floats | None) -> Floats:
    """Return the unknowns in equilibrium, from a start near it or along the arc."""
    none = np.zeros((len(hold.amplitude), chain.links + 1))
    if x is None:
        x = _started(chain, hold)
        _, begin = _crossing(chain, hold)
        for share in np.arange(1, STEPS + 1) / STEPS:
            moved = begin + share * (hold.position_m - begin)
            x = chain.newton(x, _at(hold, moved), none)
    extra = none
    for _ in range(4 if hold.weight_N_per_m else 1):
        extra = _weight(chain, hold, x)
        x = chain.newton(x, hold, extra)
    return x


def _at(hold: Hold, position_m: Floats) -> Hold:
    return Hold(amplitude=hold.amplitude, position_m=position_m, radius_m=hold.radius_m)


def held(strip: Strip, hold: Hold, near: Equilibria | None = None) -> Equilibria:
    """Return equilibria of strips, from others near them if any; `ValueError`: they slip out."""
    coarse, fine = Chain(strip), Chain(strip, 2 * LINKS)
    x = _solved(coarse, hold, None if near is None else near.unknowns)
    guess = _refined(x)
    z = _solved(fine, hold, guess)
    first, second = _described(coarse, hold, x), _described(fine, hold, z)
    return Equilibria(
        force_N=(
            _extrapolated(first.force_N[0], second.force_N[0]),
            _extrapolated(first.force_N[1], second.force_N[1]),
        ),
        length_m=_extrapolated(first.length_m, second.length_m),
        angle_rad=_extrapolated(first.angle_rad, second.angle_rad),
        at=first.at,
        # each second joint of the finer chain is one of the coarser
        bent_per_m=_extrapolated(first.bent_per_m, second.bent_per_m[:, ::2]),
        root_rad=_extrapolated(first.root_rad, second.root_rad),
        unknowns=x,
    )


def _extrapolated(coarse: Floats, fine: Floats) -> Floats:
    return np.asarray(fine + (fine - coarse) / 3.0)


def _refined(x: Floats) -> Floats:
    """Return a start for twice as many links: the angle along the chain by a spline."""
    n = x.shape[1] - 4
    upto = np.concatenate([np.zeros((len(x), 1)), np.cumsum(x[:, : n + 1], axis=1)], axis=1)
    edges = np.clip(np.arange(n + 2) - 0.5, 0.0, n) / n
    wanted = np.clip(np.arange(2 * n + 2) - 0.5, 0.0, 2 * n) / (2 * n)
    angles = np.diff(CubicSpline(edges, upto, axis=1)(wanted), axis=1)
    return np.concatenate([angles, x[:, n + 1 :]], axis=1)


def _described(chain: Chain, hold: Hold, x: Floats) -> Equilibria:
    n, B = chain.links, chain.strip.stiffness_Nm2
    extra = _weight(chain, hold, x)
    state = _State.of(chain, x[:, : n + 1], x[:, n + 1], x[:, n + 2 :], extra)
    bent = chain._soft.at(state.s_m) * state.moment
    if chain.strip.bending is not None:
        u = hold.amplitude[:, None]
        drive = u * chain._driven.at(state.s_m) + u * u * chain._even.at(state.s_m)
        bent = chain.strip.bending(drive + bent) - chain.strip.bending(drive)
    return Equilibria(
        force_N=(B * x[:, n + 2], B * x[:, n + 3]),
        length_m=x[:, n + 1],
        angle_rad=state.angle_rad,
        at=np.arange(n + 1) / n,
        bent_per_m=bent,
        root_rad=chain.strip.clamp_give_rad_per_Nm * B * state.moment[:, 0],
        unknowns=x,
    )


def free(strip: Strip, hold: Hold) -> Equilibria:
    """Return strips that nothing holds, bent by their weight alone."""
    chain, count = Chain(strip, 2 * LINKS), len(hold.amplitude)
    n, u = chain.links, hold.amplitude[:, None]
    x = np.concatenate([np.zeros((count, n + 1)), np.full((count, 1), chain.free_m)], axis=1)
    x = np.concatenate([x, np.zeros((count, 2))], axis=1)
    for _ in range(6):
        extra = _weight(chain, hold, x)
        state = _State.of(chain, x[:, : n + 1], x[:, n + 1], x[:, n + 2 :], extra)
        x[:, : n + 1] = chain._joint_angles(extra, state.s_m, state.span, u)
    return _described(chain, hold, x)


def shapes(strip: Strip, hold: Hold, found: Equilibria, s_m: Floats) -> Floats:
    """Return the points (n, m, 2) of strips along `s_m`."""
    chain, count = Chain(strip), len(hold.amplitude)
    fine = np.linspace(0.0, max(float(s_m[-1]), chain.free_m), 2 * FINE - 1)
    phi = chain.unloaded(np.broadcast_to(fine, (count, len(fine))), hold.amplitude).copy()
    for i, length in enumerate(np.minimum(found.length_m, chain.free_m)):
        bent = CubicSpline(found.at * length, found.bent_per_m[i])
        phi[i] += bent.antiderivative()(np.minimum(fine, length)) + found.root_rad[i]
        tail = chain.free_m - length  # bends under its weight, the moment falling as a square
        if tail > 0.0:
            left = np.clip((chain.free_m - fine) / tail, 0.0, 1.0)
            phi[i] += found.bent_per_m[i, -1] * tail / 3.0 * (1.0 - left**3)
    x, y = integrate(fine, phi)
    return np.asarray(CubicSpline(fine, np.stack([x, y], axis=-1), axis=1)(s_m))
