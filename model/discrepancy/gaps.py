"""How far models are from the data: before and after, fitted and left out, and where."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from model.discrepancy.result import BeforeAfter, Gap, Row, Where
from model.discrepancy.rows import Index
from model.discrepancy.score import Candidate, Projected, Score, score
from model.discrepancy.settle import Fitted
from model.measurements import FloatArray
from model.noise import inverse_symmetric

MOST_PLACES = 12
Z_LEAST = 3.3  # of a cell that is mentioned; about one in a thousand by chance


@dataclass(frozen=True)
class Cells:
    """Rows by what people ask for: numbers are indices into all rows."""

    force: Index  # mean forces
    condition: Index  # (of these) number of the condition over all configurations
    modes: tuple[Index, ...]  # of each curve
    curve_of: Index  # number of the condition of each


def cells(fitted: Fitted) -> Cells:
    """Where forces and curves stand."""
    study, first = fitted.problem.study, 0
    force, condition, modes, curve_of = [], [], [], []
    for part, scene in zip(study.layout.parts, study.scenes, strict=True):
        force += part.trend_rows[part.is_mean].tolist()
        condition += (first + part.trend_of[part.is_mean]).tolist()
        for k in np.flatnonzero(scene.has_curve):
            modes.append(part.mode_rows[k])
            curve_of.append(first + int(k))
        first += scene.K
    return Cells(_int(force), _int(condition), tuple(modes), _int(curve_of))


def _int(values: list[int]) -> Index:
    return np.array(values, dtype=np.int64)


def variance(fitted: Fitted) -> FloatArray:
    """Of every row: noise and the scatter of set-ups (N,)."""
    layout = fitted.problem.study.layout
    V = np.linalg.inv(fitted.solution.weights)
    diagonal: FloatArray = np.einsum("rii->ri", V)[layout.run_of, layout.row_of]
    return diagonal


def gap(
    residual: FloatArray, variance_: FloatArray, where: Cells, rows: Index | None = None
) -> Gap:
    """Root mean squares over forces and over curves; chi2 about them, each row by itself."""
    use = (
        np.ones(len(residual), dtype=bool)
        if rows is None
        else np.isin(np.arange(len(residual)), rows)
    )
    force = where.force[use[where.force]]
    curves = [m for m in where.modes if use[m[0]]]
    curve = np.concatenate([np.zeros(0, dtype=np.int64), *curves]).astype(np.int64)
    both = np.concatenate([force, curve])
    chi2 = float(np.mean(residual[both] ** 2 / variance_[both])) if len(both) else np.nan
    square = [float(np.sum(residual[m] ** 2)) for m in curves]
    return Gap(
        float(np.sqrt(np.mean(residual[force] ** 2))) * 1e3 if len(force) else np.nan,
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
    """1 - (after^2 - floor^2)/(before^2 - floor^2), of whichever gap stands out of the noise more."""
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


# -- left out


def left_out(
    base: Fitted, final: Fitted, pool: Sequence[Candidate], groups: list[Index]
) -> tuple[FloatArray, FloatArray, list[str]]:
    """Residuals of rows when they are left out: of the base model, and of the model that is chosen
    without them; and what was chosen each time.

    The choice is repeated among `pool` each time; where it is the final model's first effect, that
    model's columns predict what was left out.
    """
    before, after = refitted(base).copy(), refitted(final).copy()
    study, chosen = base.problem.study, []
    own = final.found[0].effect.name if final.found else ""
    for runs in groups:
        rows = np.flatnonzero(np.isin(study.layout.run_of, runs))
        before[rows] = _predicted(base, base.linear.columns, runs)[rows]
        best = _best_without(base, pool, runs) if own and pool else None
        name = "" if best is None or best.log_bayes <= 0.0 else best.candidate.name
        if final is base or (own and not name):
            after[rows] = before[rows]
        elif best is None or name == own:
            after[rows] = _predicted(final, final.linear.columns, runs)[rows]
        else:
            columns = np.concatenate([base.linear.columns, best.candidate.columns], axis=1)
            extra = np.full(best.candidate.columns.shape[1], best.scale**-2.0)
            after[rows] = _predicted(base, columns, runs, extra)[rows]
        chosen.append(name)
    return before, after, chosen


def _information(
    fitted: Fitted, columns: FloatArray, runs: Index, extra: FloatArray | None
) -> tuple[FloatArray, FloatArray]:
    """Normal equations of all runs but these."""
    data, layout = fitted.linear.data, fitted.problem.study.layout
    kept = np.setdiff1d(np.arange(len(layout.runs)), runs)
    X = layout.pad(columns)[kept]
    W, y = fitted.solution.weights[kept], layout.pad(fitted.linear.residual)[kept]
    WX = W @ X
    precision, away = data.precision, data.away
    if extra is not None:
        precision = np.concatenate([precision, extra])
        away = np.concatenate([away, np.zeros(len(extra))])
    p = X.shape[2]
    A = X.reshape(-1, p).T @ WX.reshape(-1, p) + np.diag(precision)
    return A, WX.reshape(-1, p).T @ y.ravel() - precision * away


def _predicted(
    fitted: Fitted, columns: FloatArray, runs: Index, extra: FloatArray | None = None
) -> FloatArray:
    """Residuals of everything when the parameters come from all runs but these."""
    A, b = _information(fitted, columns, runs, extra)
    result: FloatArray = fitted.linear.residual - columns @ (inverse_symmetric(A) @ b)
    return result


def predictive_gains(before: Fitted, after: Fitted) -> FloatArray:
    """Ln of how much more likely each position's data are in the second model than in the first.

    The position is left out of both fits.
    """
    layout, result = before.problem.study.layout, []
    for runs in position_groups(before):
        values = []
        for fitted in (before, after):
            residual = layout.pad(_predicted(fitted, fitted.linear.columns, runs))[runs]
            W = fitted.solution.weights[runs]
            square = float(np.einsum("ri,rij,rj->", residual, W, residual))
            values.append(0.5 * float(np.sum(np.linalg.slogdet(W)[1])) - 0.5 * square)
        result.append(values[1] - values[0])
    return np.array(result)


def _best_without(base: Fitted, pool: Sequence[Candidate], runs: Index) -> Score:
    """The candidate that the other runs choose, with the noise as it was found."""
    study, layout = base.problem.study, base.problem.study.layout
    weights = base.solution.weights.copy()
    weights[runs] = 0.0
    A, b = _information(base, base.linear.columns, runs, None)
    covariance = inverse_symmetric(A)
    error = layout.pad(base.linear.residual - base.linear.columns @ (covariance @ b))
    We = (weights @ error[:, :, None])[:, :, 0]
    WX = (weights @ base.linear.data.X)[layout.run_of, layout.row_of]
    projected = Projected(weights, WX, covariance, We[layout.run_of, layout.row_of])
    return max((score(study, projected, c) for c in pool), key=lambda s: s.log_bayes)


def position_groups(fitted: Fitted) -> list[Index]:
    """Runs by position, over all configurations; free shapes are never left out."""
    groups: dict[float, list[int]] = {}
    for r, run in enumerate(fitted.problem.study.layout.runs):
        if np.isfinite(run[1]):
            groups.setdefault(round(run[1], 7), []).append(r)
    return [_int(g) for g in groups.values()]


# -- where


def staged(base: Fitted) -> FloatArray:
    """Residuals (N,) with B from 0 V alone, then the EIBM given B: they say where it is wrong.

    All at once would smear what acts under voltage over everything.
    """
    study, problem, linear = base.problem.study, base.problem, base.linear
    layout = study.layout
    at_rest = np.zeros(layout.size, dtype=bool)
    for part, scene in zip(layout.parts, study.scenes, strict=True):
        zero = scene.voltage_V == 0.0
        at_rest[part.trend_rows[zero[part.trend_of]]] = True
        rows = part.mode_rows[zero & scene.has_curve]
        at_rest[rows.ravel()] = True
    if not at_rest.any() or at_rest.all():
        return refitted(base)
    stiff = np.zeros(linear.columns.shape[1], dtype=bool)
    for one in problem.bases.parts:
        stiff[[one.stiffness, *one.rest]] = True
    variance_ = variance(base)
    y = linear.residual.copy()
    for columns, rows in ((stiff, at_rest), (~stiff, ~at_rest)):
        X = linear.columns[rows][:, columns] / np.sqrt(variance_[rows])[:, None]
        A = X.T @ X + np.diag(linear.data.precision[columns])
        b = X.T @ (y[rows] / np.sqrt(variance_[rows]))
        y = y - linear.columns[:, columns] @ (inverse_symmetric(A) @ b)
    return y


def places(base: Fitted, noise: FloatArray) -> tuple[Where, ...]:
    """The cells that stand out of noise and scatter (variances (N,)), the strongest first."""
    residual, study = staged(base), base.problem.study
    z = residual / np.sqrt(noise)
    found: list[Where] = []
    for name, part, scene in zip(study.names, study.layout.parts, study.scenes, strict=True):
        for row, k, mean in zip(part.trend_rows, part.trend_of, part.is_mean, strict=True):
            detail = "" if mean else "how the readings go with time"
            found.append(_where("force", name, scene, k, None, float(z[row]), detail))
        for k in np.flatnonzero(scene.has_curve):
            rows = part.mode_rows[k]
            chi2 = float(np.sum(z[rows] ** 2))
            n = len(rows)
            worth = np.sqrt(max(chi2 - n, 0.0)) if chi2 > n + 3.0 * np.sqrt(2.0 * n) else 0.0
            s = scene.curve_s[k]
            off = np.linalg.pinv(scene.project[k]) @ residual[rows]
            at = float(s[int(np.argmax(np.abs(off)))])
            found.append(_where("curve", name, scene, k, at * 1e3, worth, ""))
        for row, k in zip(part.bin_rows, part.bin_of, strict=True):
            found.append(_where("signal", name, scene, k, None, float(z[row]), "within the pulse"))
    found = [w for w in found if abs(w.z) >= Z_LEAST]
    found.sort(key=lambda w: -abs(w.z))
    return tuple(found[:MOST_PLACES])


def _where(
    observable: str, name: str, scene: object, k: int, s_mm: float | None, z: float, detail: str
) -> Where:
    from model.discrepancy.scene import Scene

    assert isinstance(scene, Scene)
    at = float(scene.stated_m[k])
    position = None if np.isnan(at) else round(at * 1e3, 6)
    return Where(observable, name, float(scene.voltage_V[k]), position, s_mm, z, detail)  # type: ignore[arg-type]


def table(base: Fitted, final: Fitted, before: FloatArray, after: FloatArray) -> tuple[Row, ...]:
    """Every condition, measured and simulated."""
    study, rows = base.problem.study, []
    own, fin, noise = refitted(base), refitted(final), variance(final)
    for c, (part, scene) in enumerate(zip(study.layout.parts, study.scenes, strict=True)):
        first, last = base.linear.states[c], final.linear.states[c]
        for k, seen in enumerate(study.looks[c].seen):
            mean = part.trend_rows[(part.trend_of == k) & part.is_mean]
            force = float(np.mean(seen.force_N)) if len(mean) else np.nan
            i = int(mean[0]) if len(mean) else -1
            n = len(seen.curve.s_m) if seen.curve is not None else 0
            n = min(n, scene.curve_s.shape[1])
            s = scene.curve_s[k, :n]
            back = np.linalg.pinv(scene.project[k]) if n else np.zeros((0, 0))
            offs, curves = [], []
            for residual, state in ((own, first), (fin, last)):
                off = (back @ residual[part.mode_rows[k]])[:n] if n else np.zeros(0)
                normal = state.solved
                x, y = scene.curve_x[k, :n], scene.curve_y[k, :n]
                offs.append(off)
                curves.append((x - off * normal.nx[k, :n], y - off * normal.ny[k, :n]))
            none = np.nan
            rows.append(
                Row(
                    seen.configuration, None if seen.free else seen.position_m, seen.voltage_V,
                    force, float(np.sqrt(noise[i])) if len(mean) else none,
                    force - own[i] if len(mean) else none, force - fin[i] if len(mean) else none,
                    s, scene.curve_x[k, :n], scene.curve_y[k, :n], curves[0], curves[1], offs[0],
                    offs[1], force - before[i] if len(mean) else none,
                    force - after[i] if len(mean) else none,
                )
            )  # fmt: skip
    return tuple(rows)
