"""How far models are from the data: forces and curves, against what noise alone would leave."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass

import numpy as np

from model.discrepancy.features import Index
from model.discrepancy.result import BeforeAfter, Gap, Row
from model.discrepancy.settle import Fitted
from model.measurements import FloatArray


@dataclass(frozen=True)
class Cells:
    """Rows by what people ask for: numbers are indices into all rows."""

    force: Index  # mean forces
    modes: tuple[Index, ...]  # of each curve


def cells(fitted: Fitted, without: Collection[int] = ()) -> Cells:
    """Where forces and curves stand; conditions `without`, by number over all, do not count."""
    study, first = fitted.problem.study, 0
    force: list[int] = []
    modes: list[Index] = []
    for part, scene in zip(study.layout.parts, study.scenes, strict=True):
        counts = np.array([first + k not in without for k in range(scene.K)])
        force += part.trend_rows[part.is_mean & counts[part.trend_of]].tolist()
        modes += [part.mode_rows[k] for k in np.flatnonzero(scene.has_curve & counts)]
        first += scene.K
    return Cells(np.array(force, dtype=np.int64), tuple(modes))


def variance(fitted: Fitted) -> FloatArray:
    """Of every row: noise and the scatter of set-ups (N,)."""
    layout = fitted.problem.study.layout
    V = np.linalg.inv(fitted.solution.weights)
    diagonal: FloatArray = np.einsum("rii->ri", V)[layout.run_of, layout.row_of]
    return diagonal


def gap(residual: FloatArray, variance_: FloatArray, where: Cells) -> Gap:
    """Root mean squares over forces and over curves; chi2 about them, each row by itself."""
    force = residual[where.force]
    both = np.concatenate([where.force, *where.modes])
    chi2 = float(np.mean(residual[both] ** 2 / variance_[both])) if len(both) else np.nan
    square = [float(np.sum(residual[m] ** 2)) for m in where.modes]
    return Gap(
        float(np.sqrt(np.mean(force**2))) * 1e3 if len(force) else np.nan,
        float(np.sqrt(np.mean(square))) * 1e3 if square else np.nan,
        chi2,
    )


def floor(variance_: FloatArray, where: Cells) -> Gap:
    """What the noise alone would leave."""
    force = np.sqrt(np.mean(variance_[where.force])) * 1e3 if len(where.force) else np.nan
    square = [float(np.sum(variance_[m])) for m in where.modes]
    curve = np.sqrt(np.mean(square)) * 1e3 if square else np.nan
    return Gap(float(force), float(curve), 1.0)


def closed_share(left_out: BeforeAfter, least: Gap) -> float:
    """1 - (after^2 - floor^2)/(before^2 - floor^2) of the gap that stands out of noise more."""
    best, share = 0.0, np.nan
    for name in ("force_rmse_mN", "curve_rmse_mm"):
        before, after, noise = (getattr(g, name) for g in (left_out.before, left_out.after, least))
        if np.isfinite(before) and before > noise:
            standing = before / noise
            if standing > best:
                best = standing
                share = 1.0 - max(after**2 - noise**2, 0.0) / (before**2 - noise**2)
    return float(share)


def refitted(fitted: Fitted) -> FloatArray:
    """Residuals (N,) with the linear parameters where they are best."""
    beta = fitted.solution.beta
    result: FloatArray = fitted.linear.residual - fitted.linear.columns @ beta
    return result


def table(base: Fitted, final: Fitted, before: FloatArray, after: FloatArray) -> tuple[Row, ...]:
    """Every condition, measured and simulated; `before`, `after` (N,) are left-out residuals."""
    noise = np.sqrt(variance(final))
    forces = [refitted(base), refitted(final), before, after]
    rows = []
    for c, (part, seen) in enumerate(
        zip(base.problem.study.layout.parts, base.problem.study.looks, strict=True)
    ):
        for k, one in enumerate(seen.seen):
            mean = part.trend_rows[(part.trend_of == k) & part.is_mean]
            force = float(np.mean(one.force_N)) if len(mean) else np.nan
            sigma = float(noise[mean[0]]) if len(mean) else np.nan
            told = [force - float(r[mean[0]]) if len(mean) else np.nan for r in forces]
            measured = base.problem.study.scenes[c].measured(k)
            first, last = (_simulated(fitted, c, k) for fitted in (base, final))
            rows.append(
                Row(
                    one.configuration, None if one.free else one.position_m, one.voltage_V, force,
                    sigma, told[0], told[1], *measured, first[0], last[0], first[1], last[1],
                    told[2], told[3],
                )
            )  # fmt: skip
    return tuple(rows)


def _simulated(fitted: Fitted, c: int, k: int) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Places (x, y) of a curve's points as a model has them, and how far off they are."""
    study = fitted.problem.study
    scene, solved = study.scenes[c], fitted.linear.states[c].solved
    s, x, y = scene.measured(k)
    n = len(s)
    off = scene.along(k, refitted(fitted)[study.part(c).mode_rows[k]])[:n]
    return (x - off * solved.nx[k, :n], y - off * solved.ny[k, :n]), off
