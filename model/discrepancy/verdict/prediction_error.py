"""Prediction errors of models, compared with the error that noise alone causes."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass, replace

import numpy as np

from model.discrepancy.thresholds import REPORTED_GAP_RATIO, TIME_GAP_RATIO
from model.discrepancy.verdict.result import BeforeAfter, ClosedGap, ErrorRow, Gap
from model.identification.data.data_vector import Index
from model.identification.likelihood.mixed_model import effects, weigh
from model.identification.likelihood.mixed_model_fit import MixedModelFit
from model.measurements import FloatArray


@dataclass(frozen=True, kw_only=True)
class Cells:
    """Rows by what people ask for: numbers are indices into all rows, each group one number."""

    force: tuple[Index, ...]  # mean forces
    curve: tuple[Index, ...]  # modes of each curve
    drift: tuple[Index, ...]  # trends and first pulses of each condition's readings
    sway: tuple[Index, ...]  # the same of how far out their curves are
    pulse: tuple[Index, ...]  # parts of a pulse
    weight: FloatArray  # (N,) of squares: trends are expected for a reading

    def within(self, rows: Index) -> Cells:
        """Return those of some rows."""

        def kept(groups: tuple[Index, ...]) -> tuple[Index, ...]:
            return tuple(group for group in groups if np.isin(group, rows).all())

        return replace(
            self, force=kept(self.force), curve=kept(self.curve), drift=kept(self.drift),
            sway=kept(self.sway), pulse=kept(self.pulse),
        )  # fmt: skip


def cells(
    fitted: MixedModelFit, without: Collection[int] = (), configuration: str | None = None
) -> Cells:
    """Return where all that stands, of all configurations or of one.

    Conditions `without`, by number over all, do not count.
    """
    forward, first = fitted.problem.forward, 0
    found = Cells(
        force=(), curve=(), drift=(), sway=(), pulse=(), weight=np.ones(forward.row_index.size)
    )
    for block, configuration_model in zip(
        forward.row_index.blocks, forward.configuration_models, strict=True
    ):
        # without contact there is nothing that the sheet's model could be wrong about
        here = configuration in (None, configuration_model.sheet.configuration)
        counts = np.array(
            [
                here and first + k not in without and not one.zero
                for k, one in enumerate(configuration_model.data_vector.seen)
            ]
        )
        readings = np.bincount(block.reading_of, minlength=configuration_model.K)
        found.weight[block.trend_rows] = np.where(
            block.is_mean, 1.0, 1.0 / readings[block.trend_of]
        )
        found.weight[block.sway_rows] = 1.0 / readings[block.sway_of]
        own = np.flatnonzero(counts)
        trends = [block.trend_rows[(block.trend_of == k) & ~block.is_mean] for k in own]
        sways = [block.sway_rows[block.sway_of == k] for k in own]
        found = replace(
            found,
            force=found.force + _each(block.trend_rows[block.is_mean & counts[block.trend_of]]),
            curve=found.curve
            + tuple(
                block.mode_rows[k] for k in np.flatnonzero(configuration_model.has_curve & counts)
            ),
            drift=found.drift + tuple(rows for rows in trends if len(rows)),
            sway=found.sway + tuple(rows for rows in sways if len(rows)),
            pulse=found.pulse + _each(block.bin_rows[counts[block.bin_of]]),
        )
        first += configuration_model.K
    return found


def _each(rows: Index) -> tuple[Index, ...]:
    """Return every row a group of its own."""
    return tuple(np.asarray(rows, dtype=np.int64).reshape(-1, 1))


def variance(fitted: MixedModelFit) -> FloatArray:
    """Of every row: noise and the scatter of set-ups (N,)."""
    row_index = fitted.problem.forward.row_index
    V = np.linalg.inv(fitted.solution.weights)
    diagonal: FloatArray = np.einsum("rii->ri", V)[row_index.run_of, row_index.row_of]
    return diagonal


def gap(residual: FloatArray, variance_: FloatArray, where: Cells) -> Gap:
    """Return root mean squares; chi2 of mean forces and curves, each row by itself."""
    both = [*where.force, *where.curve]
    chi2 = np.nan
    if both:
        rows = np.concatenate(both)
        chi2 = float(np.mean(residual[rows] ** 2 / variance_[rows]))
    return _gap(residual**2, where, chi2)


def floor(variance_: FloatArray, where: Cells) -> Gap:
    """Return the prediction error that noise alone causes."""
    return _gap(variance_, where, 1.0)


def _gap(square: FloatArray, where: Cells, chi2: float) -> Gap:
    weighed = square * where.weight

    def rms(groups: tuple[Index, ...]) -> float:
        if not groups:
            return np.nan
        return 1e3 * float(np.sqrt(np.mean([np.sum(weighed[g]) for g in groups])))

    kinds = (where.force, where.curve, where.drift, where.sway, where.pulse)
    force, curve, drift, sway, pulse = (rms(groups) for groups in kinds)
    return Gap(
        force_rmse_mN=force,
        curve_rmse_mm=curve,
        chi2_per_dof=chi2,
        drift_rmse_mN=drift,
        pulse_rmse_mN=pulse,
        drift_rmse_mm=sway,
    )


# name of the gap, what readers call it, unit, times its floor from which on there is a gap to close
MEANS = "force and neutral curve"
_QUANTITIES = (
    ("force_rmse_mN", "force", "mN", REPORTED_GAP_RATIO),
    ("curve_rmse_mm", "neutral curve", "mm", REPORTED_GAP_RATIO),
    ("chi2_per_dof", MEANS, "times the noise", TIME_GAP_RATIO),
    ("drift_rmse_mN", "force along a run", "mN", TIME_GAP_RATIO),
    ("drift_rmse_mm", "neutral curve along a run", "mm", TIME_GAP_RATIO),
    ("pulse_rmse_mN", "force within a pulse", "mN", TIME_GAP_RATIO),
)


def closed_gap(left_out: BeforeAfter, least: Gap) -> ClosedGap | None:
    """Return how much is closed of the gap that stands out of its noise most; None: none does.

    Mean forces and curves in units of their noise are one of them: what only fine shapes tell is
    little in mm, where coarse ones differ from set-up to set-up.
    """
    best, found = 0.0, None
    for name, quantity, unit, clear in _QUANTITIES:
        values = [getattr(g, name) for g in (left_out.before, left_out.after, least)]
        if name == "chi2_per_dof":  # a mean of squares
            values = [float(np.sqrt(v)) for v in values]
        before, after, noise = values
        if not (np.isfinite(before) and before > clear * noise):
            continue
        standing = before / noise if noise > 0.0 else np.inf
        if standing > best:
            best = standing
            share = 1.0 - max(after**2 - noise**2, 0.0) / (before**2 - noise**2)
            found = ClosedGap(
                share=float(share), quantity=quantity, before=before, after=after, floor=noise,
                unit=unit,
            )  # fmt: skip
    if found is not None and found.quantity == MEANS:
        return replace(found, quantity=_means_of(left_out.before))
    return found


def _means_of(gap: Gap) -> str:
    """Return which of mean forces and curves there are."""
    if not np.isfinite(gap.force_rmse_mN):
        return "neutral curve"
    return MEANS if np.isfinite(gap.curve_rmse_mm) else "force"


def closed_share(left_out: BeforeAfter, least: Gap) -> float:
    """Return the share of `closed_gap`; NaN where no gap stands out of the noise."""
    found = closed_gap(left_out, least)
    return np.nan if found is None else found.share


def refitted(fitted: MixedModelFit) -> FloatArray:
    """Return residuals (N,) with the linear parameters where they are best."""
    beta = fitted.solution.beta
    result: FloatArray = fitted.linear.residual - fitted.linear.columns @ beta
    return result


def at_set_ups(fitted: MixedModelFit, log_sigma: FloatArray) -> FloatArray:
    """Return residuals (N,) from the model at each set-up's most likely offsets.

    `log_sigma` is the scatter of the set-ups by which an offset is judged; the parameters stay.
    """
    data, row_index = fitted.linear.data, fitted.problem.forward.row_index
    solution = replace(weigh(data, log_sigma), beta=fitted.solution.beta)
    result = refitted(fitted).copy()
    for Z, u in zip(data.groups, effects(data, solution), strict=False):
        result -= np.einsum("rnq,rq->rn", Z, u)[row_index.run_of, row_index.row_of]
    return result


def table(
    base: MixedModelFit, final: MixedModelFit, before: FloatArray, after: FloatArray
) -> tuple[ErrorRow, ...]:
    """Every condition, measured and simulated; `before`, `after` (N,) are left-out residuals."""
    noise, log_sigma = np.sqrt(variance(final)), final.solution.log_sigma
    set_ups = [at_set_ups(fitted, log_sigma) for fitted in (base, final)]
    nominal = [refitted(fitted) for fitted in (base, final)]
    forces = [*nominal, before, after, *set_ups]
    rows = []
    for c, (block, seen) in enumerate(
        zip(base.problem.forward.row_index.blocks, base.problem.forward.data_vectors, strict=True)
    ):
        for k, one in enumerate(seen.seen):
            if one.zero:
                continue
            mean = block.trend_rows[(block.trend_of == k) & block.is_mean]
            force = float(np.mean(one.kept_N)) if len(mean) else np.nan
            sigma = float(noise[mean[0]]) if len(mean) else np.nan
            expected = [force - float(r[mean[0]]) if len(mean) else np.nan for r in forces]
            measured = base.problem.forward.configuration_models[c].measured(k)
            first, last, offset_first, offset_last = (
                _simulated(fitted, c, k, off)
                for fitted, off in zip((base, final) * 2, (*nominal, *set_ups), strict=True)
            )
            rows.append(
                ErrorRow(
                    configuration=one.configuration,
                    position_m=None if one.free else one.position_m,
                    voltage_V=one.voltage_V,
                    force_N=force,
                    sigma_N=sigma,
                    before_N=expected[0],
                    after_N=expected[1],
                    s_m=measured[0],
                    x_m=measured[1],
                    y_m=measured[2],
                    before_xy_m=first[0],
                    after_xy_m=last[0],
                    before_off_m=first[1],
                    after_off_m=last[1],
                    held_out_before_N=expected[2],
                    held_out_after_N=expected[3],
                    before_at_setup_N=expected[4],
                    after_at_setup_N=expected[5],
                    before_at_setup_xy_m=offset_first[0],
                    after_at_setup_xy_m=offset_last[0],
                ),
            )
    return tuple(rows)


def _simulated(
    fitted: MixedModelFit, c: int, k: int, residual: FloatArray
) -> tuple[tuple[FloatArray, FloatArray], FloatArray]:
    """Return places (x, y) of a curve's points as a model has them, and how far off they are."""
    forward = fitted.problem.forward
    configuration_model, solved = forward.configuration_models[c], fitted.linear.states[c].solved
    s, x, y = configuration_model.measured(k)
    n = len(s)
    off = configuration_model.along(k, residual[forward.row_block(c).mode_rows[k]])[:n]
    return (x - off * solved.nx[k, :n], y - off * solved.ny[k, :n]), off
