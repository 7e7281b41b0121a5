"""Solves setups of one configuration, wherever their contacts and clamps are.

Setups whose contacts lie on the arc itself are one batch, those whose neutral curves pass beside
that point (`offset_m`) another one, in which each contact has a radius of its own.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from model.measurements import FloatArray, ModelError, length_scale
from model.mechanics.equilibrium import (
    Equilibria,
    Problems,
    Shapes,
    SolverStatus,
    check_softness,
    problems,
    solve,
)
from model.mechanics.field import (
    Field,
    for_each_field,
    merged_breaks,
    padded,
    smooth_each,
    values_of_each,
)
from model.mechanics.free_shape import free_shape
from model.sheet.beam_problem import ConditionProblem

SPACING_M = 0.5e-3  # of a shape's points, of a sheet of the paper's size
RIGID = 1e-7  # B over the stiffness of an elongation that does not bend, beside others that do
_BESIDE = 4  # rounds of placing a contact beside the arc; each gains a factor of offset/R


def free_curvature(setup: ConditionProblem) -> Field:
    """k* = k0 + Me/B(s)."""
    return _free_curvatures([setup])[0]


def _free_curvatures(setups: Sequence[ConditionProblem]) -> list[Field]:
    """Return each one's free curvature; setups that share their fields share it."""
    keys = [(id(s.rest), id(s.eibm), id(s.softness), s.B_Nm2) for s in setups]
    each = dict(zip(keys, setups, strict=True))
    made = {key: s.rest + s.eibm * (1.0 / s.B_Nm2) for key, s in each.items() if s.softness is None}
    bent = {key: s for key, s in each.items() if s.softness is not None}
    made |= dict(zip(bent, _softened(list(bent.values())), strict=True))
    return [made[key] for key in keys]


def _softened(setups: Sequence[ConditionProblem]) -> list[Field]:
    """Return the free curvature of setups with a softness, on panels that do for all of them."""
    if not setups:
        return []
    soft, eibm = [s.softness for s in setups if s.softness is not None], [s.eibm for s in setups]
    B_Nm2 = np.array([s.B_Nm2 for s in setups])[:, None]

    def bend(s_m: FloatArray) -> FloatArray:
        return np.asarray(values_of_each(eibm, s_m) * values_of_each(soft, s_m) / B_Nm2)

    # a stated rest curvature has many panels, of which the product needs none
    kinks = merged_breaks([f.breaks_m for f in (*soft, *eibm)])
    bends = smooth_each(bend, setups[0].rest.length_m, kinks)
    return [one.rest + more for one, more in zip(setups, bends, strict=True)]


def batch(setups: Sequence[ConditionProblem]) -> Problems:
    """Return the beam problems of setups of one sheet, all with the contact at one radius."""
    radius_m = setups[0].sheet.arc_radius_m + setups[0].reach_m
    return _batch(setups, [s.angle_rad - s.clamp_rad for s in setups], radius_m)


def _batch(
    setups: Sequence[ConditionProblem], angles: Sequence[float], radius_m: float
) -> Problems:
    sheet = setups[0].sheet
    kappa, softness = _free_curvatures(setups), [s.softness for s in setups]
    bends = any(s.elongation_soft > 0.0 for s in setups) and sheet.elongation_m > 0.0
    if not bends and all(c is softness[0] for c in softness):
        return problems(kappa, angles, radius_m, sheet.elongation_m, softness[0])
    soft = [Field.constant(1.0, sheet.free_length_m) if c is None else c for c in softness]
    beyond = sheet.elongation_m
    if bends:  # the elongation is a part of the sheet whose stiffness is another
        kappa = [_longer(k, beyond, 0.0) for k in kappa]
        softer = [max(s.elongation_soft, RIGID) for s in setups]
        soft = [_longer(c, beyond, value) for c, value in zip(soft, softer, strict=True)]
        beyond = 0.0
    breaks = merged_breaks([f.breaks_m for f in (*kappa, *soft)])
    made = problems(for_each_field(lambda k: k.on(breaks), kappa), angles, radius_m, beyond)
    rows = for_each_field(lambda c: c.on(made.breaks_m).coefficients, soft)
    degree = max(r.shape[1] for r in rows)
    return replace(made, softness=np.stack([padded(r, degree) for r in rows]))


def _longer(field: Field, by_m: float, value: float) -> Field:
    row = np.zeros((1, field.coefficients.shape[1]))
    row[0, 0] = value
    breaks = np.append(field.breaks_m, field.length_m + by_m)
    return Field(breaks, np.concatenate([field.coefficients, row]))


def sampled_s(setup: ConditionProblem) -> FloatArray:
    """Points from the clamp to the visible end, the sheet's end among them."""
    length, end = setup.sheet.free_length_m, setup.sheet.free_length_m + setup.sheet.elongation_m
    spacing_m = SPACING_M * length_scale(setup.sheet)
    inner = np.linspace(0.0, length, max(2, int(np.ceil(length / spacing_m - 1e-9)) + 1))
    outer = np.linspace(length, end, int(np.ceil((end - length) / spacing_m - 1e-9)) + 1)[1:]
    return np.concatenate([inner, outer])


@dataclass(frozen=True, kw_only=True)
class SolvedProblems:
    """Solutions in the order of the setups; NaN where there is no equilibrium, or no contact."""

    setups: tuple[ConditionProblem, ...]
    status: npt.NDArray[np.int64]  # (K,) `SolverStatus`; SOLVED where nothing touches
    nu: FloatArray  # (K,) N/B, 1/m^2
    s_hat_m: FloatArray
    phi_hat_rad: FloatArray  # against the x axis
    parts: tuple[tuple[npt.NDArray[np.int64], Equilibria], ...]  # rows, and how they were solved

    @property
    def reachable(self) -> npt.NDArray[np.bool_]:
        """(K,) where there is an equilibrium; true where nothing touches."""
        return np.asarray(self.status == SolverStatus.SOLVED)

    @property
    def B_Nm2(self) -> FloatArray:
        """Of each setup."""
        return np.array([s.B_Nm2 for s in self.setups])

    @property
    def gamma_rad(self) -> FloatArray:
        """Angle between the sheet's normal and the arc's tangent."""
        return np.asarray(self.phi_hat_rad - [s.angle_rad for s in self.setups], dtype=float)

    @property
    def normal_N(self) -> FloatArray:
        """N, along the sheet's normal."""
        result: FloatArray = self.B_Nm2 * self.nu
        return result

    @property
    def force_N(self) -> FloatArray:
        """(5) F along the arc's tangent."""
        return np.asarray(self.normal_N * np.cos(self.gamma_rad), dtype=float)

    def shapes(self, s_m: FloatArray) -> Shapes:
        """Curves at s_m (S,), with the clamp's own direction; those that nothing touches too."""
        shape = (len(self.setups), len(s_m))
        x, y, phi, k = (np.full(shape, np.nan) for _ in range(4))
        for rows, found in self.parts:
            one = found.shapes(s_m)
            x[rows], y[rows], phi[rows], k[rows] = (
                one.x_m,
                one.y_m,
                one.phi_rad,
                one.curvature_per_m,
            )
        for i, setup in enumerate(self.setups):
            if not setup.touches:
                x[i], y[i], phi[i], k[i] = _hanging(setup, s_m)
        tilt = np.array([s.clamp_rad for s in self.setups])[:, None]
        cos, sin = np.cos(tilt), np.sin(tilt)
        return Shapes(
            s_m=s_m,
            x_m=cos * x - sin * y,
            y_m=sin * x + cos * y,
            phi_rad=phi + tilt,
            curvature_per_m=k,
        )


def _hanging(
    setup: ConditionProblem, s_m: FloatArray
) -> tuple[FloatArray, FloatArray, FloatArray, FloatArray]:
    kappa = free_curvature(setup)
    x, y, phi = free_shape(kappa, s_m)
    inside = s_m <= kappa.length_m
    return x, y, phi, np.where(inside, kappa(np.minimum(s_m, kappa.length_m)), 0.0)


def solved(setups: Sequence[ConditionProblem]) -> SolvedProblems:
    """All setups of one configuration."""
    K = len(setups)
    status = np.zeros(K, np.int64)
    nu, s_hat, phi = (np.full(K, np.nan) for _ in range(3))
    parts = []
    for rows, found in _groups(setups):
        status[rows], nu[rows], s_hat[rows] = found.status, found.nu, found.s_hat_m
        phi[rows] = found.phi_hat_rad + [setups[i].clamp_rad for i in rows]
        parts.append((rows, found))
    return SolvedProblems(
        setups=tuple(setups),
        status=status,
        nu=nu,
        s_hat_m=s_hat,
        phi_hat_rad=phi,
        parts=tuple(parts),
    )


def all_solved(setups: Sequence[ConditionProblem]) -> bool:
    """Return whether all have an equilibrium, with a stiffness positive along the whole sheet."""
    length_m = setups[0].sheet.free_length_m
    try:
        for soft in {id(s.softness): s.softness for s in setups}.values():
            if soft is not None:
                check_softness(soft, length_m)
        return bool(np.all(solved(setups).reachable))
    except ModelError:
        return False


def _groups(setups: Sequence[ConditionProblem]) -> list[tuple[npt.NDArray[np.int64], Equilibria]]:
    on_arc: dict[float, list[int]] = {}
    for i, s in enumerate(setups):
        if s.touches and s.offset_m == 0.0:
            on_arc.setdefault(s.reach_m, []).append(i)
    groups = [(np.array(own), solve(batch([setups[i] for i in own]))) for own in on_arc.values()]
    beside = [i for i, s in enumerate(setups) if s.touches and s.offset_m != 0.0]
    if not beside:
        return groups
    return [*groups, (np.array(beside), _beside([setups[i] for i in beside]))]


def _beside(setups: Sequence[ConditionProblem]) -> Equilibria:
    """r(s_hat) + offset n_hat = p_hat, n_hat turning with the sheet."""
    d = np.array([s.offset_m for s in setups])
    R = np.array([s.sheet.arc_radius_m + s.reach_m for s in setups])
    angle = np.array([s.angle_rad - s.clamp_rad for s in setups])
    gamma, made = np.zeros(len(setups)), _batch(setups, angle.tolist(), float(np.min(R)))
    found: Equilibria | None = None
    for _ in range(_BESIDE):
        along, outward = -d * np.cos(gamma), R + d * np.sin(gamma)
        radii = np.hypot(along, outward)
        made = replace(
            made, angle_rad=angle + np.arctan2(along, outward), radii_m=radii,
            radius_m=float(np.min(radii)),
        )  # fmt: skip
        found = solve(made, found)
        gamma = np.where(found.status == SolverStatus.SOLVED, found.phi_hat_rad - angle, gamma)
    assert found is not None  # noqa: S101 - there is a round
    return found
