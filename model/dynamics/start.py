"""Where a motion begins: at rest in equilibrium, or at rest in a shape from which it is let go."""

from __future__ import annotations

from collections import OrderedDict, deque
from collections.abc import Callable
from functools import lru_cache
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from model.dynamics.beam import ContactSetup, DynamicBeam
from model.dynamics.body import Body, MotionState, Packed
from model.dynamics.equations import (
    Motions,
    at_contact,
    derivative,
    moments,
    newton,
    static_residual,
)
from model.dynamics.space import Panels, Space, dense, norms, operators, rows_at, space
from model.dynamics.space import moments as projection
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import Engine, Equilibria, SolverStatus, problems, solve
from model.mechanics.field import Field

LEAST_TAIL = 0.02  # of the length: a shorter panel beyond the contact is not worth its own
SMALL = 1e-11  # a step of Newton's method that ends it


def equilibrium(
    beam: DynamicBeam, setup: ContactSetup, kappa: Field, angle_rad: float, engine: Engine
) -> Equilibria:
    """Return the static solution on the physical branch. Raises ModelError where there is none."""
    found = solve(
        problems(kappa, angle_rad, setup.radius_m, beam.elongation.length_m), engine=engine
    )
    if found.status[0] != SolverStatus.SOLVED:
        raise ModelError(
            f"the rolls cannot be reached at {np.degrees(angle_rad):.3g} degrees of the arc:"
            " the sheet would slip out of them"
        )
    return found


def sheet_space(beam: DynamicBeam, degrees: tuple[int, ...], break_m: float | None) -> Space:
    """Return one panel, or two where `break_m` is within the sheet and two degrees are given."""
    length = beam.length_m
    inside = break_m is not None and LEAST_TAIL * length < break_m < (1.0 - LEAST_TAIL) * length
    if inside and break_m is not None and len(degrees) > 1:
        return space([0.0, break_m, length], degrees[:2], beam.elongation.length_m)
    return space([0.0, length], degrees[:1], beam.elongation.length_m)


def body_of(beam: DynamicBeam, on: Space) -> Body:
    """Return the arrays of the sheet and its elongation."""
    w, bends = on.weight_m, np.arange(len(on.s_m)) < on.first_node[on.flexible]
    end, fluid = beam.elongation, (beam.fluid, beam.elongation.fluid)

    def along(sheet: float, elongation: float) -> FloatArray:
        return np.asarray(w * np.where(bends, sheet, elongation))

    mass = along(beam.mass_per_length_kg_per_m, end.mass_per_length_kg_per_m)
    mass[-1] = end.end_mass_kg  # the panel of no width
    rows = [
        along(getattr(fluid[0], name), getattr(fluid[1], name))
        for name in (
            "added_mass_kg_per_m", "normal_Ns_per_m2", "quadratic_Ns2_per_m3",
            "tangential_Ns_per_m2",
        )
    ]  # fmt: skip
    return Body(
        space=on, angle=dense(on)[0], mass=mass, added=rows[0], normal=rows[1],
        quadratic=rows[2], tangential=rows[3], wet=bool(np.any(rows)),
        stiffness=beam.material.B_Nm2 * norms(on), rest=coefficients(on, beam.rest),
        viscous_s=beam.material.viscous_time_s, shares=np.array(beam.material.shares),
        times_s=np.array(beam.material.times_s), reach_m=float(on.breaks_m[-1]) * (1.0 + 1e-12),
        made=packed(on, mass, np.array(rows)),
    )  # fmt: skip


def packed(on: Space, mass: FloatArray, fluid: FloatArray) -> Packed:
    """Return the arrays of the compiled kernel."""
    holds = np.flatnonzero(mass + fluid.sum(axis=0))
    nodes = max(int(on.first_node[on.flexible]), int(holds[-1]) + 1 if len(holds) else 0)
    if on.breaks_m[-1] > on.breaks_m[on.flexible]:  # the rolls may be on the elongation
        nodes = max(nodes, int(on.first_node[on.flexible + 1]))
    M, P = -(-nodes // 4) * 4, -(-on.size // 4) * 4
    of_space = operators(on, nodes, M, P)
    whole = np.zeros((5, M))
    whole[:, :nodes] = np.stack([mass, *fluid])[:, :nodes]
    return Packed(
        **of_space, mass=whole[0], fluid=whole[1:], wet=bool(np.any(fluid)),
        breaks_m=on.breaks_m, flexible=on.flexible, first_node=on.first_node,
        first_dof=on.first_dof,
    )  # fmt: skip


def coefficients(on: Space, quantity: Field) -> FloatArray:
    """Return the best approximation of a quantity along the sheet, (N,); not to be changed."""
    return _coefficients(Panels(on), _FieldKey(quantity))


class _FieldKey:
    """A field as a key: a search asks about the same one again and again."""

    __slots__ = ("_key", "field")

    def __init__(self, field: Field) -> None:
        self.field = field
        self._key = (field.breaks_m.tobytes(), field.coefficients.tobytes())

    def __hash__(self) -> int:
        return hash(self._key)

    def __eq__(self, other: object) -> bool:
        return isinstance(other, _FieldKey) and self._key == other._key


@lru_cache(maxsize=64)
def _coefficients(panels: Panels, of: _FieldKey) -> FloatArray:
    on, quantity = panels.on, of.field
    breaks = np.unique(np.concatenate([quantity.breaks_m, on.breaks_m[: on.flexible + 1]]))
    values = np.zeros(on.size)
    x, w = np.polynomial.legendre.leggauss(16)
    for low, high in pairwise(breaks):
        s = 0.5 * (low + high) + 0.5 * (high - low) * x
        values += 0.5 * (high - low) * (rows_at(on, s).curvature.T @ (w * quantity(s)))
    return np.asarray(values / norms(on))


MOST_RESTING, MOST_OF_ONE = 64, 8
NEAR_MOMENT = 0.02  # of the largest coefficient: the next equilibrium is a few steps from the last


class _Resting(NamedTuple):
    """An equilibrium on the rolls, over B: of a moment Me/B it depends on nothing else."""

    curvature: FloatArray  # (N,) Me/B, coefficients
    q: FloatArray  # (N,)
    x: FloatArray  # (3,) N/B, s_hat, phi_hat


# the last few of each space and place of the rolls; see `resting`
_RESTING: OrderedDict[tuple[bytes, ...], deque[_Resting]] = OrderedDict()


def resting(
    body: Body, found: Callable[[], Equilibria], moment: FloatArray, clamp_rad: float,
    place: FloatArray,
) -> MotionState:  # fmt: skip
    """Return `at_rest`; the same moment over B is found once, a little more of it from there.

    Only N grows with B. A search for B and all else asks for hundreds of motions from there.
    """
    on = body.space
    B = body.stiffness[0] / on.breaks_m[1]
    bent = moment / body.stiffness
    key = (
        on.breaks_m.tobytes(), on.first_dof.tobytes(), body.rest.tobytes(), place.tobytes(),
        np.float64(clamp_rad).tobytes(),
    )  # fmt: skip
    known = _RESTING.setdefault(key, deque(maxlen=MOST_OF_ONE))
    state = None
    if known:
        before = tuple(known)  # another thread may add to them
        off = [float(np.max(np.abs(one.curvature - bent))) for one in before]
        kept = before[int(np.argmin(off))]
        if min(off) == 0.0:
            return _state(body, kept.q, kept.x * np.array([B, 1.0, 1.0]))
        if min(off) < NEAR_MOMENT * np.max(np.abs(kept.q)):
            begun = np.concatenate([kept.q, [kept.x[0] * B, kept.x[1]]])
            state = _solved(body, begun, moment, clamp_rad, place)
    state = state or at_rest(body, found(), moment, clamp_rad, place)
    known.append(_Resting(bent, state.q.copy(), state.x / np.array([B, 1.0, 1.0])))
    while len(_RESTING) > MOST_RESTING:
        _RESTING.popitem(last=False)
    return state


def at_rest(
    body: Body, found: Equilibria | None, moment: FloatArray, clamp_rad: float, place: FloatArray
) -> MotionState:
    """Return the equilibrium of the space, from the static solution `found` (None: free)."""
    if found is None:
        return _state(body, body.rest + moment / body.stiffness, np.zeros(3))
    on, bends = body.space, body.space.first_node[body.space.flexible]
    shape = found.shapes(on.s_m[:bends])
    k = np.zeros(len(on.s_m))
    k[:bends] = shape.curvature_per_m[0]
    B = body.stiffness[0] / on.breaks_m[1]
    u = np.concatenate([projection(on) @ k / norms(on), [found.nu[0] * B, found.s_hat_m[0]]])
    state = _solved(body, u, moment, clamp_rad, place)
    if state is None:
        raise ModelError("no equilibrium to begin from was found in the chosen space")
    return state


def _solved(
    body: Body, u: FloatArray, moment: FloatArray, clamp_rad: float, place: FloatArray
) -> MotionState | None:
    """Return the equilibrium near u = (q, N, s_hat); None: none was found."""
    on = body.space
    B = body.stiffness[0] / on.breaks_m[1]
    scale = np.concatenate([
        np.full(on.size, 1.0 / on.length_m), [B / on.length_m**2, on.length_m]
    ])  # fmt: skip
    solved = newton(
        lambda u: static_residual(body, u, moment, np.array([clamp_rad]), place, contact=True),
        u, scale, SMALL,
    )  # fmt: skip
    if solved is None:
        return None
    q, x = solved[: on.size], solved[on.size :]
    turned = at_contact(on, x[1:])[0][0] @ q + clamp_rad
    return _state(body, q, np.append(x, turned))


def let_go(body: Body, curvature: Field, moment: FloatArray, clamp: FloatArray) -> MotionState:
    """Return a free sheet at rest in a given shape, with the acceleration it begins with."""
    state = _state(body, coefficients(body.space, curvature), np.zeros(3))
    accelerate(body, state, moment, clamp)
    return state


def accelerate(body: Body, state: MotionState, moment: FloatArray, clamp: FloatArray) -> None:
    """Write the acceleration with which a free sheet at rest begins; its loss is relaxed."""
    q, size = state.q[None], body.space.size
    zero = np.zeros(1)

    def inertia(a: FloatArray) -> FloatArray:
        rest = np.zeros((len(a), size))
        at = Motions(np.repeat(q, len(a), axis=0), rest, a, zero, zero)
        return np.asarray(moments(body, at, clamp, contact=False)[0])

    missing = moment - body.stiffness * (state.q - body.rest) - inertia(np.zeros((1, size)))[0]
    state.a[:] = np.linalg.solve(derivative(inertia, np.zeros(size)), missing)
    state.a_mean[:] = state.a


def _state(body: Body, q: FloatArray, x: FloatArray) -> MotionState:
    zero = np.zeros_like(q)
    z = np.repeat((q - body.rest)[None], len(body.shares), axis=0)
    x = np.asarray(x, dtype=float)
    return MotionState(q.copy(), zero.copy(), zero.copy(), zero.copy(), z, x)
