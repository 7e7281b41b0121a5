"""A plane curve from its curvature, a cubic B-spline of the arc length.

`phi` is the spline's exact antiderivative, `r` its integral by Simpson's rule. All lengths here
are in pixels of the sheet's plane (world coordinates times px_per_m), y up. Beyond the free length
the curvature is zero where the elongation is taken as straight. Else it may turn at its joint, and
its curvature is linear between a few nodes and zero at its end, as under a force.

Parameters: [offset along the normal at the clamp, angle at the clamp, spline coefficients, those
of an elongation that is not straight].
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
import numpy.typing as npt

from labrig.vision.curve.smoothness import block_diagonal, log_weights, smooth_priors
from labrig.vision.jit import jit

FloatArray = npt.NDArray[np.float64]

ELONGATION_PIECES = 3  # in which the curvature of one that bends is linear
ELONGATION_TURN_RAD = 0.3  # what it may bend by, and turn at its joint


@dataclass(frozen=True, eq=False, kw_only=True)
class ShapeBasis:
    """The spline and its antiderivative on a fixed grid of `cells` equal steps."""

    free_px: float
    total_px: float
    step_px: float
    s: FloatArray  # (nodes,) = cells + 1
    curvature: FloatArray  # (nodes, coefficients): k = curvature @ c
    angle: FloatArray  # (nodes, coefficients): phi - phi0 = angle @ c
    angle_mid: FloatArray  # (cells, coefficients): the same in the cells' middles
    penalty: FloatArray  # (coefficients, coefficients): c' penalty c = int (dk/ds)^2 ds
    priors: FloatArray  # (kinds, coefficients, coefficients): see smooth_priors
    log_weight: FloatArray  # (kinds,)
    rest_bends: bool = False  # whether the elongation may

    @property
    def size(self) -> int:
        """Number of parameters."""
        return 2 + int(self.curvature.shape[1])


@dataclass(frozen=True, eq=False, kw_only=True)
class CurveShape:
    """A curve on a basis' grid."""

    basis: ShapeBasis
    start: FloatArray  # (2,): the clamp's nominal place
    heading: float  # the clamp's nominal angle
    parameters: FloatArray
    x: FloatArray  # (nodes,)
    y: FloatArray
    phi: FloatArray
    k: FloatArray

    def moved(self, parameters: FloatArray) -> CurveShape:
        """Return the curve with other parameters."""
        return make_shape(self.basis, self.start, self.heading, parameters)

    def from_node(self, node: int) -> CurveShape:
        """Return the part of the line from a node on; the parameters stay those of the whole."""
        return replace(self, x=self.x[node:], y=self.y[node:], phi=self.phi[node:], k=self.k[node:])

    def slid(self, by: float) -> CurveShape:
        """Return the same line in the plane with its start `by` further along it."""
        basis, heading = self.basis, self.heading
        turn = float(self.parameters[1])
        wanted = np.interp(basis.s + by, basis.s, self.phi) - heading - turn
        weight = np.full(len(basis.s), 1e8)
        c = fit_angles(basis, wanted, weight, 1.0)
        along = np.array([math.cos(heading), math.sin(heading)])
        parameters = np.concatenate([self.parameters[:2], c])
        return make_shape(basis, self.start + by * along, heading, parameters)

    def normal_modes(self) -> FloatArray:
        """Return (nodes, parameters): displacement along the normal for each parameter."""
        return _normal_modes(self.basis.angle, self.phi, self.heading, self.basis.step_px)


@jit
def _normal_modes(angle: FloatArray, phi: FloatArray, heading: float, step: float) -> FloatArray:
    """Return dr/dp = int n dphi/dp ds, so along the normal: n(s) . int n A ds, by trapezia."""
    nodes, coefficients = angle.shape
    modes = np.empty((nodes, 2 + coefficients))
    east, north = np.zeros(1 + coefficients), np.zeros(1 + coefficients)
    before_c, before_s = math.cos(phi[0]), math.sin(phi[0])
    for i in range(nodes):
        c, s = math.cos(phi[i]), math.sin(phi[i])
        # the clamp's offset moves the whole curve along the normal of the clamp
        modes[i, 0] = math.cos(phi[i] - heading)
        for q in range(1 + coefficients):
            if i > 0:
                here = angle[i, q - 1] if q > 0 else 1.0
                before = angle[i - 1, q - 1] if q > 0 else 1.0
                east[q] -= 0.5 * step * (s * here + before_s * before)
                north[q] += 0.5 * step * (c * here + before_c * before)
            modes[i, 1 + q] = c * north[q] - s * east[q]
        before_c, before_s = c, s
    return modes


def make_shape(
    basis: ShapeBasis, start: FloatArray, heading: float, parameters: FloatArray
) -> CurveShape:
    """Integrate the curvature into a curve."""
    offset, turn, c = parameters[0], parameters[1], parameters[2:]
    phi = heading + turn + basis.angle @ c
    middle = heading + turn + basis.angle_mid @ c
    sixth = basis.step_px / 6
    x = _integral(np.cos(phi), np.cos(middle), sixth)
    y = _integral(np.sin(phi), np.sin(middle), sixth)
    return CurveShape(
        basis=basis,
        start=start,
        heading=heading,
        parameters=parameters,
        x=start[0] - offset * math.sin(heading) + x,
        y=start[1] + offset * math.cos(heading) + y,
        phi=phi,
        k=basis.curvature @ c,
    )


def _integral(nodes: FloatArray, middles: FloatArray, sixth: float) -> FloatArray:
    out = np.zeros_like(nodes)
    np.cumsum((nodes[1:] + nodes[:-1] + 4 * middles) * sixth, out=out[1:])
    return out


@lru_cache(maxsize=16)
def make_basis(
    free_px: float,
    total_px: float,
    coefficients: int,
    longest_step_px: float = 1.0,
    *,
    straight_rest: bool = True,
) -> ShapeBasis:
    """Return the basis for a sheet of `free_px` and a rest up to `total_px`."""
    from scipy.interpolate import BSpline

    cells = max(16, math.ceil(total_px / min(1.0, longest_step_px)))
    step = total_px / cells
    s: FloatArray = np.arange(cells + 1, dtype=np.float64) * step
    pieces = coefficients - 3
    knots = np.linspace(0, free_px, pieces + 1)
    t = np.concatenate([np.zeros(3), knots, np.full(3, free_px)])
    splines = BSpline(t, np.eye(coefficients), 3)
    integral = splines.antiderivative()
    inside = s <= free_px
    penalty = _penalty(splines.derivative(), knots)
    priors = smooth_priors(penalty, _penalty(splines.derivative(2), knots), free_px)
    curvature = np.where(inside[:, None], splines(np.minimum(s, free_px)), 0.0)
    basis = ShapeBasis(
        free_px=free_px,
        total_px=total_px,
        step_px=step,
        s=s,
        curvature=curvature,
        angle=integral(np.minimum(s, free_px)),
        angle_mid=integral(np.minimum(s[:-1] + step / 2, free_px)),
        penalty=penalty,
        priors=priors,
        log_weight=log_weights(priors),
    )
    return basis if straight_rest or total_px <= free_px else _with_bending_rest(basis)


def _with_bending_rest(basis: ShapeBasis) -> ShapeBasis:
    """Return the basis with what an elongation may bend, behind the spline's coefficients."""
    free, length = basis.free_px, basis.total_px - basis.free_px
    middles: FloatArray = basis.s[:-1] + basis.step_px / 2
    hats = _Hats(free, length / ELONGATION_PIECES)
    # the joint's turn is counted as a curvature over the free length, so that all have one unit
    joint, joint_mid = (free * (s > free)[:, None] for s in (basis.s, middles))
    penalty = np.zeros((1 + ELONGATION_PIECES, 1 + ELONGATION_PIECES))
    penalty[0, 0], penalty[1:, 1:] = 1 / free, hats.penalty()
    prior = np.zeros_like(penalty)
    prior[0, 0] = (free / ELONGATION_TURN_RAD) ** 2
    prior[1:, 1:] = hats.penalty() * length**3 / ELONGATION_TURN_RAD**2
    priors = block_diagonal(basis.priors, prior)
    return replace(
        basis,
        curvature=np.hstack([basis.curvature, np.zeros_like(joint), hats.values(basis.s)]),
        angle=np.hstack([basis.angle, joint, hats.integrals(basis.s)]),
        angle_mid=np.hstack([basis.angle_mid, joint_mid, hats.integrals(middles)]),
        penalty=block_diagonal(basis.penalty[None], penalty)[0],
        priors=priors,
        log_weight=log_weights(priors),
        rest_bends=True,
    )


@dataclass(frozen=True)
class _Hats:
    """Hat functions about nodes `width` apart, from `start` on; all are zero at the end."""

    start: float
    width: float

    def _from_nodes(self, s: FloatArray) -> FloatArray:
        """Return (len(s), nodes): the distance from each node over the width."""
        nodes = self.start + self.width * np.arange(ELONGATION_PIECES)
        return np.asarray((s[:, None] - nodes) / self.width, dtype=np.float64)

    def values(self, s: FloatArray) -> FloatArray:
        """Return (len(s), nodes); zero up to the start."""
        inside = (s > self.start)[:, None]
        return np.asarray(np.maximum(0.0, 1 - np.abs(self._from_nodes(s))) * inside)

    def integrals(self, s: FloatArray) -> FloatArray:
        """Return (len(s), nodes), from the start on."""
        t = np.clip(self._from_nodes(s), -1.0, 1.0)
        whole = self.width * (0.5 + t - np.sign(t) * t**2 / 2)
        whole[:, 0] -= self.width / 2  # its first half lies before the start
        return np.asarray(np.where(s[:, None] > self.start, whole, 0.0))

    def penalty(self) -> FloatArray:
        """Return (nodes, nodes): the integral of the square of their sum's slope."""
        diagonal = np.diag([1.0, *[2.0] * (ELONGATION_PIECES - 1)])
        beside = np.eye(ELONGATION_PIECES, k=1) + np.eye(ELONGATION_PIECES, k=-1)
        return np.asarray((diagonal - beside) / self.width)


def _penalty(slope: object, knots: FloatArray) -> FloatArray:
    # its square is of fourth order at most in each piece: three Gauss points are exact
    at, weight = np.polynomial.legendre.leggauss(3)
    width = np.diff(knots)[:, None]
    where = (knots[:-1, None] + width * (at + 1) / 2).ravel()
    values = slope(where)  # type: ignore[operator]
    return np.asarray((values * (width * weight / 2).ravel()[:, None]).T @ values)


def coefficients_for(free_px: float) -> int:
    """Return about twenty for a long sheet, fewer where pieces were shorter than about 6 pixels."""
    return int(np.clip(round(free_px / 7) + 3, 5, 21))


def fit_angles(basis: ShapeBasis, phi: FloatArray, weight: FloatArray, smooth: float) -> FloatArray:
    """Return coefficients whose angle follows `phi` (nodes,), counted from the clamp's angle."""
    a = basis.angle
    normal = (a * weight[:, None]).T @ a + smooth * basis.penalty
    ridge = 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))
    return np.asarray(np.linalg.solve(normal + ridge, a.T @ (weight * phi)), dtype=np.float64)
