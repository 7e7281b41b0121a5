"""The sheet in equilibrium with a load on the arc: the mechanics behind everything else.

A sheet is clamped at the origin along x and touches, without friction, an object at polar angle
beta on the arc of radius R. In arc length s, with phi the tangential angle and k = dphi/ds:
    (1)  k(s) = k*(s) - nu c(s) a(s) for s <= min(l, s_hat), k* = k0 + Me/B(s) beyond, 0 for s > l
with a = (p_hat - r(s)).t_hat the lever of the contact force, nu = N/B, c(s) = B/B(s), and B a
reference stiffness. Only k* and the geometry enter the shape; the force scales with B.
`solve` takes a batch of such problems that share geometry and panels.
"""

from __future__ import annotations

from collections.abc import Callable
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass, replace
from enum import IntEnum
from itertools import pairwise
from math import isfinite
from typing import Any, Literal, NamedTuple

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError
from model.mechanics.collocation import rule
from model.mechanics.field import Field, for_each_field, merged_breaks, padded

LEAST_SHARE = 200  # problems that are worth a thread
Engine = Literal["auto", "compiled", "numpy"]
Accuracy = Literal["normal", "reference"]
# nodes for panels whose width over R, and a quarter of the angle they turn, add up to less
_NODES: dict[Accuracy, tuple[tuple[float, int], ...]] = {
    "normal": ((0.05, 4), (0.22, 5), (0.56, 6), (0.85, 7), (1.0, 8), (1.2, 9), (np.inf, 10)),
    "reference": ((0.05, 6), (0.2, 8), (0.5, 10), (np.inf, 16)),
}
_PASSES: dict[Accuracy, int] = {"normal": 1, "reference": 2}
_TURN: dict[Accuracy, float] = {"normal": 3.2, "reference": 1.0}  # rad of free curvature in a panel
_SHARE: dict[Accuracy, float] = {"normal": 1.6, "reference": 0.7}  # of R in a panel


class SolverStatus(IntEnum):
    """How the search ended."""

    SOLVED = 0
    SLIPPED = 1  # the contact would be beyond the sheet's end
    FAILED = 2


@dataclass(frozen=True, kw_only=True)
class Problems:
    """A batch of K problems on the same panels."""

    breaks_m: FloatArray  # (P + 1,) from 0 to l
    kappa: FloatArray  # (K, P, D) k* as coefficients of t, see `field`
    softness: FloatArray  # (1 or K, P, Dc) c(s); Dc = 0: 1 everywhere
    radius_m: float  # the least
    reach_m: float  # the visible end of sheet or elongation
    angle_rad: FloatArray  # (K,) beta
    radii_m: FloatArray | None = None  # (K,) of each; None: all have the same
    turn_rad: float | None = None  # bound of what a panel of kappa turns; None: to be worked out

    def __len__(self) -> int:
        return len(self.angle_rad)

    @property
    def length_m(self) -> float:
        """The free length l."""
        return float(self.breaks_m[-1])

    @property
    def each_radius_m(self) -> FloatArray:
        """The radius of all (1,), or of each (K,)."""
        return np.array([self.radius_m]) if self.radii_m is None else self.radii_m


def problems(
    kappa: Field | list[Field],
    angle_rad: npt.ArrayLike,
    radius_m: float,
    elongation_m: float = 0.0,
    softness: Field | None = None,
    accuracy: Accuracy = "normal",
) -> Problems:
    """Return a batch from fields: one free curvature k* for each angle, or one for all."""
    angles = np.asarray(angle_rad, dtype=float).reshape(-1)
    fields = [kappa] if isinstance(kappa, Field) else kappa
    if not fields:
        raise ModelError("a batch of problems needs at least one free curvature")
    length = fields[0].length_m
    _check(fields, softness, angles, radius_m, elongation_m)
    first = fields[0].breaks_m
    different = list({id(f): f for f in fields}.values())
    others = [f.breaks_m for f in different[1:]] + ([softness.breaks_m] if softness else [])
    breaks = merged_breaks([first, *others]) if others else first
    largest = max(f.largest for f in different)
    breaks = finer(breaks, largest, radius_m, accuracy)
    if len(fields) == 1:
        rows = fields[0].on(breaks).coefficients[None]
    else:
        degree = max(f.coefficients.shape[1] for f in different)
        rows = np.stack(for_each_field(lambda f: padded(f.on(breaks).coefficients, degree), fields))
    soft = softness.on(breaks).coefficients if softness else np.zeros((len(breaks) - 1, 0))
    if len(rows) < len(angles):
        rows = np.repeat(rows, len(angles), axis=0)
    turn = largest * _widest(breaks)
    return Problems(
        breaks_m=breaks,
        kappa=rows,
        softness=soft[None],
        radius_m=radius_m,
        reach_m=length + elongation_m,
        angle_rad=angles,
        turn_rad=turn,
    )


def _widest(breaks_m: FloatArray) -> float:
    if len(breaks_m) == 2:
        return float(breaks_m[1] - breaks_m[0])
    return float((breaks_m[1:] - breaks_m[:-1]).max())


def finer(
    breaks_m: FloatArray, curvature_per_m: float, radius_m: float, accuracy: Accuracy = "normal"
) -> FloatArray:
    """Panels cut until each turns little enough for the collocation to be exact."""
    widest = min(_SHARE[accuracy] * radius_m, _TURN[accuracy] / max(curvature_per_m, 1e-9))
    if len(breaks_m) == 2 and breaks_m[1] - breaks_m[0] <= widest:
        return breaks_m
    pieces = [
        np.linspace(low, high, int(np.ceil((high - low) / widest - 1e-9)) + 1)[:-1]
        for low, high in pairwise(breaks_m)
    ]
    return np.concatenate([*pieces, breaks_m[-1:]])


def nodes_for(batch: Problems, accuracy: Accuracy = "normal") -> int:
    """Collocation nodes a panel: as many as the one that asks for most; 5e-10 of N R^2/B."""
    widest, turn = _widest(batch.breaks_m), batch.turn_rad
    if turn is None:
        turn = widest * float(np.max(np.sum(np.abs(batch.kappa), axis=2), initial=0.0))
    measure = widest / batch.radius_m + 0.25 * turn
    return next(nodes for most, nodes in _NODES[accuracy] if measure < most)


@dataclass(frozen=True, kw_only=True)
class Shapes:
    """Curves of a batch at points s."""

    s_m: FloatArray  # (S,) or (K, S)
    x_m: FloatArray  # (K, S)
    y_m: FloatArray
    phi_rad: FloatArray
    curvature_per_m: FloatArray


class Directions(NamedTuple):
    """Q parameters to differentiate a batch by; leading axis K or 1 (the same for all)."""

    kappa: FloatArray  # (K, Q, P, D) change of k*(s)
    softness: FloatArray  # (K, Q, P, Dc) change of c(s); Dc = 0: none
    angle: FloatArray  # (K, Q) change of beta
    radius: FloatArray  # (K, Q) change of R
    length: FloatArray  # (K, Q) change of l

    @staticmethod
    def of(
        kappa: FloatArray,
        softness: FloatArray | None = None,
        angle: FloatArray | None = None,
        radius: FloatArray | None = None,
        length: FloatArray | None = None,
    ) -> Directions:
        """Directions of which only the free curvature's (K, Q, P, D) must be given."""
        K, Q, P, _ = kappa.shape
        zero = np.zeros((K, Q))
        soft = np.zeros((K, Q, P, 0)) if softness is None else softness
        others = [
            zero if a is None else np.asarray(a, dtype=float) for a in (angle, radius, length)
        ]
        return Directions(np.ascontiguousarray(kappa), soft, *others)


@dataclass(frozen=True, kw_only=True)
class EquilibriumSensitivities:
    """Derivatives of a batch with respect to Q parameters."""

    nu: FloatArray  # (K, Q)
    s_hat: FloatArray
    phi_hat: FloatArray
    x: FloatArray  # (K, Q, S)
    y: FloatArray


@dataclass(frozen=True, kw_only=True)
class Equilibria:
    """Solutions of a batch. Where `status` is not SOLVED the numbers are NaN."""

    problems: Problems
    status: npt.NDArray[np.int64]  # (K,)
    nu: FloatArray  # (K,) N/B, 1/m^2
    s_hat_m: FloatArray
    phi_hat_rad: FloatArray
    psi: FloatArray  # (K, P, n) the collocation's own unknowns: a warm start for neighbours
    nodes: int

    @property
    def gamma_rad(self) -> FloatArray:
        """Angle between the sheet's normal and the arc's tangent."""
        return self.phi_hat_rad - self.problems.angle_rad

    @property
    def l_hat_m(self) -> FloatArray:
        """Length of the sheet that is loaded."""
        return np.minimum(self.s_hat_m, self.problems.length_m)

    def of(self, rows: npt.NDArray[np.int64]) -> Equilibria:
        """Return some of them."""
        p = self.problems
        soft = p.softness if len(p.softness) == 1 else p.softness[rows]
        radii = None if p.radii_m is None else p.radii_m[rows]
        some = replace(
            p, kappa=p.kappa[rows], softness=soft, angle_rad=p.angle_rad[rows], radii_m=radii
        )
        return replace(
            self, problems=some, status=self.status[rows], nu=self.nu[rows],
            s_hat_m=self.s_hat_m[rows], phi_hat_rad=self.phi_hat_rad[rows], psi=self.psi[rows],
        )  # fmt: skip

    def force(self, B_Nm2: npt.ArrayLike) -> FloatArray:
        """(5) F, the force on the object along the arc's tangent, in N."""
        return np.asarray(B_Nm2) * self.nu * np.cos(self.gamma_rad)

    def shapes(self, s_m: FloatArray, engine: Engine = "auto") -> Shapes:
        """Curves at s_m, (S,) or (K, S); beyond l the elongation's straight line."""
        return self._describe(s_m, None, engine)[0]

    def mean_lever_m(self, engine: Engine = "auto") -> FloatArray:
        """Return mean of a over [0, l_hat]; (3) the mean moment is -N times it."""
        return self._describe(np.zeros(1), None, engine)[1]

    def answers(
        self, s_m: FloatArray, to: Directions, engine: Engine = "auto"
    ) -> tuple[Shapes, EquilibriumSensitivities]:
        """Curves at s_m, and the derivatives of everything (implicit function theorem)."""
        shapes, _, answers = self._describe(s_m, to, engine)
        return shapes, answers

    def _describe(
        self, s_m: FloatArray, to: Directions | None, engine: Engine
    ) -> tuple[Shapes, FloatArray, EquilibriumSensitivities]:
        p = self.problems
        s = np.ascontiguousarray(np.atleast_2d(np.asarray(s_m, dtype=float)))
        if to is None:
            to = _nothing(p)
        K, Q, S = len(p), to.kappa.shape[1], s.shape[1]
        out, lever = np.full((K, S, 4), np.nan), np.full(K, np.nan)
        dx, dout = np.full((K, Q, 3), np.nan), np.full((K, Q, S, 2), np.nan)
        state = np.stack([self.nu, self.s_hat_m, self.phi_hat_rad], axis=1)
        good = self.status == SolverStatus.SOLVED
        _engine(engine).describe_many(
            breaks=p.breaks_m, kappa=p.kappa, soft=p.softness, rule=rule(self.nodes),
            R=p.each_radius_m, angles=p.angle_rad, psi=self.psi, x=state, good=good, s=s, to=to,
            out=out, lever=lever, dx=dx, dout=dout,
        )  # fmt: skip
        shapes = Shapes(
            s_m=np.asarray(s_m, dtype=float), x_m=out[:, :, 0], y_m=out[:, :, 1],
            phi_rad=out[:, :, 2], curvature_per_m=out[:, :, 3],
        )  # fmt: skip
        answers = EquilibriumSensitivities(
            nu=dx[:, :, 0], s_hat=dx[:, :, 1], phi_hat=dx[:, :, 2], x=dout[..., 0], y=dout[..., 1]
        )
        return shapes, lever / self.l_hat_m, answers


def solve(
    batch: Problems,
    start: Equilibria | None = None,
    accuracy: Accuracy = "normal",
    engine: Engine = "auto",
    workers: int = 1,
) -> Equilibria:
    """Solve each problem on its physical branch, the one continued from the free shape.

    `start`: solutions of the same batch with other numbers, to begin from. `workers`: threads that
    share a large batch.
    """
    nodes, K, by = nodes_for(batch, accuracy), len(batch.angle_rad), _engine(engine)
    state = np.zeros((K, 3))
    psi = np.zeros((K, len(batch.breaks_m) - 1, nodes))
    status, warm = np.zeros(K, np.int64), np.zeros(K, np.bool_)
    if start is not None and start.psi.shape == psi.shape:
        state[:, 0], state[:, 1], psi[:] = start.nu, start.s_hat_m, start.psi
        warm = np.isfinite(state[:, 0])
    for again in range(_PASSES[accuracy]):
        if again:  # from what was found, nearer than the first pass was asked to come
            warm = status == SolverStatus.SOLVED
        found: dict[str, Any] = {"psi": psi, "x": state, "status": status}
        if _share(by.solve_many, workers, batch, nodes, warm=warm, **found):
            _share(by.rescue_many, workers, batch, nodes, **found)
            state[status != SolverStatus.SOLVED] = np.nan
    return Equilibria(
        problems=batch,
        status=status,
        nu=state[:, 0],
        s_hat_m=state[:, 1],
        phi_hat_rad=state[:, 2],
        psi=psi,
        nodes=nodes,
    )


def _share(
    engine: Callable[..., int], workers: int, batch: Problems, nodes: int, **arrays: Any
) -> int:
    """Run the engine on slices of the batch, one thread each; returns how many are left."""
    same = {
        "breaks": batch.breaks_m, "rule": rule(nodes), "reach": batch.reach_m * (1.0 + 1e-12),
    }  # fmt: skip
    radii = batch.each_radius_m
    if workers <= 1 or len(batch) < 2 * LEAST_SHARE:
        return engine(
            kappa=batch.kappa, soft=batch.softness, R=radii, angles=batch.angle_rad, **arrays,
            **same,
        )  # fmt: skip

    def part(rows: slice) -> int:
        soft = batch.softness if len(batch.softness) == 1 else batch.softness[rows]
        return engine(
            kappa=batch.kappa[rows], soft=soft, angles=batch.angle_rad[rows],
            R=radii if len(radii) == 1 else radii[rows],
            **{name: values[rows] for name, values in arrays.items()}, **same,
        )  # fmt: skip

    ends = np.linspace(0, len(batch), min(workers, len(batch) // LEAST_SHARE) + 1).astype(int)
    with ThreadPoolExecutor(workers) as pool:
        return sum(pool.map(part, [slice(a, b) for a, b in pairwise(ends)]))


def _nothing(p: Problems) -> Directions:
    panels, degree = p.kappa.shape[1:]
    return Directions.of(np.zeros((1, 0, panels, degree)))


def _engine(engine: Engine) -> Any:
    """Return the compiled engine, or NumPy's where numba is missing."""
    if engine != "numpy":
        try:
            from model.mechanics import kernel as _kernel

            return _kernel
        except ImportError:
            if engine == "compiled":
                raise ModelError(
                    "the compiled engine needs numba, which is not installed"
                ) from None
    from model.mechanics import numpy_reference as _twin

    return _twin


def _check(
    fields: list[Field],
    softness: Field | None,
    angles: FloatArray,
    radius_m: float,
    elongation_m: float,
) -> None:
    length = fields[0].length_m
    if not (isfinite(radius_m) and radius_m > 0.0):
        raise ModelError(f"the arc's radius must be positive, not {radius_m * 1e3:g} mm")
    if not (isfinite(elongation_m) and elongation_m >= 0.0):
        raise ModelError(f"the elongation must be zero or longer, not {elongation_m * 1e3:g} mm")
    if not isfinite(np.vdot(angles, angles)):
        raise ModelError("a position on the arc is not a finite number")
    if len(fields) not in (1, len(angles)):
        raise ModelError(f"{len(fields)} free curvatures were given for {len(angles)} positions")
    if not (isfinite(length) and length > 0.0):
        raise ModelError(f"the sheet's free length must be positive, not {length * 1e3:g} mm")
    if any(f.length_m != length for f in fields):
        raise ModelError("all quantities along the sheet must end where its free length ends")
    for field in fields:
        if not isfinite(field.largest):
            raise ModelError("the sheet's free curvature is not finite everywhere")
    if softness is not None:
        check_softness(softness, length)


def check_softness(softness: Field, length_m: float) -> None:
    """Refuse a B/B(s) that ends elsewhere than the sheet, or is not positive everywhere."""
    if softness.length_m != length_m:
        raise ModelError("all quantities along the sheet must end where its free length ends")
    breaks = softness.breaks_m
    inside = np.linspace(0.0, 1.0, 41)[:-1]  # of each panel: none is too narrow to be seen
    s = np.append((breaks[:-1, None] + np.diff(breaks)[:, None] * inside).ravel(), length_m)
    if not np.min(softness(s)) > 0.0:  # nor not a number
        raise ModelError("the bending stiffness must be positive along the whole sheet")
