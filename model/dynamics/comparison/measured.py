"""Measured runs, their noise, and how far a model's response is from them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from model.dynamics.models import DrivenSheet, Response
from model.measurements import Curve, FloatArray, ModelError

PLACES = 9  # of a measured curve that count, from the clamp's next to the sheet's end


@dataclass(frozen=True, kw_only=True)
class MeasuredRun:
    """A driven sheet and what was measured of it; NaN: not measured at this sample."""

    driven: DrivenSheet
    force_N: FloatArray | None = None  # (n,)
    current_A: FloatArray | None = None  # (n,)
    curves: tuple[Curve, ...] = ()  # one for each of the drive's frames

    def __post_init__(self) -> None:
        """Refuse what does not belong together."""
        for name, values in (("force", self.force_N), ("current", self.current_A)):
            if values is not None and values.shape != self.driven.time_s.shape:
                raise ModelError(f"the {name} of a run needs a value for each of its times")
        if len(self.curves) != len(self.driven.frames):
            raise ModelError("a run needs a curve for each of its frames")


@dataclass(frozen=True, kw_only=True)
class Noise:
    """Standard deviations of single samples; noise of force and current may be correlated."""

    force_N: float = 1e-4
    current_A: float = 5e-5
    curve_m: float = 3e-4
    correlation_s: float = 0.0  # of an exponential correlation; 0: white

    def __post_init__(self) -> None:
        """Refuse noise that is not positive."""
        if not (min(self.force_N, self.current_A, self.curve_m) > 0.0 <= self.correlation_s):
            raise ModelError("standard deviations must be positive, a correlation not negative")


def residuals(run: MeasuredRun, response: Response) -> dict[str, FloatArray]:
    """Return predicted less measured: force (n,), current (n,), curve (frames, PLACES).

    NaN where a quantity is not measured or not predicted. A model that predicts the tip alone has
    the height of the last place only.
    """
    found: dict[str, FloatArray] = {}
    for name, measured, predicted in (
        ("force", run.force_N, response.force_N), ("current", run.current_A, response.current_A)
    ):  # fmt: skip
        if measured is not None:
            nothing = np.full_like(measured, np.nan)
            found[name] = nothing if predicted is None else predicted - measured
    if run.curves:
        found["curve"] = np.stack([_of_curve(run, response, i) for i in range(len(run.curves))])
    return found


def measured_values(run: MeasuredRun) -> dict[str, FloatArray]:
    """Return what `residuals` compares with: of curves, heights above the clamp's tangent."""
    found = {"force": run.force_N, "current": run.current_A}
    values = {name: one for name, one in found.items() if one is not None}
    if run.curves:
        values["curve"] = np.stack([_places(run, curve)[1] for curve in run.curves])
    return values


def whitened(values: FloatArray, sigma: float, rho: FloatArray | None) -> FloatArray:
    """Return independent residuals of standard deviation 1 (finite ones only).

    rho (n,): correlation of each sample with the one before; None: white.
    """
    if rho is None:
        good = values[np.isfinite(values)]
        return np.asarray(good / sigma)
    use = np.isfinite(values)
    before = np.concatenate([[0.0], values[:-1]])
    linked = np.where(np.isfinite(before), rho, 0.0)
    new = values - linked * np.nan_to_num(before)
    return np.asarray((new / (sigma * np.sqrt(1.0 - linked**2)))[use])


def correlations(run: MeasuredRun, noise: Noise) -> FloatArray | None:
    """Return the noise's correlation of each sample with the one before, (n,)."""
    if noise.correlation_s == 0.0:
        return None
    steps = np.diff(run.driven.time_s)
    return np.concatenate([[0.0], np.exp(-steps / noise.correlation_s)])


def split_at(run: MeasuredRun, time_s: float) -> tuple[MeasuredRun, MeasuredRun]:
    """Return the same run with what was measured before a time, and with the rest.

    Both keep the whole drive, so the second begins with the state that the first has left.
    """
    before = run.driven.time_s < time_s
    return _only(run, before), _only(run, ~before)


def _only(run: MeasuredRun, use: np.ndarray[tuple[int], np.dtype[np.bool_]]) -> MeasuredRun:
    def kept(values: FloatArray | None) -> FloatArray | None:
        return None if values is None else np.where(use, values, np.nan)

    frames = [i for i, sample in enumerate(run.driven.frames) if use[sample]]
    return MeasuredRun(
        driven=replace(run.driven, frames=run.driven.frames[frames]),
        force_N=kept(run.force_N), current_A=kept(run.current_A),
        curves=tuple(run.curves[i] for i in frames),
    )  # fmt: skip


def split_positions(
    runs: Sequence[MeasuredRun], every: int = 3
) -> tuple[list[MeasuredRun], list[MeasuredRun]]:
    """Return the runs to fit, and every n-th position in contact, to be predicted."""
    places = sorted({r.driven.position_m for r in runs if r.driven.position_m is not None})
    out = {*places[every // 2 :: every]} if len(places) > 1 else set()
    held_out = [run for run in runs if run.driven.position_m in out]
    return [run for run in runs if run.driven.position_m not in out], held_out


def _places(run: MeasuredRun, curve: Curve) -> tuple[FloatArray, FloatArray]:
    s = run.driven.sheet.free_length_m * np.arange(1, PLACES + 1) / PLACES
    outside = s > curve.s_m[-1] + 1e-3
    x, y = (np.interp(s, curve.s_m, one) for one in (curve.x_m, curve.y_m))
    return np.where(outside, np.nan, x), np.where(outside, np.nan, y)


def _of_curve(run: MeasuredRun, response: Response, frame: int) -> FloatArray:
    x, y = _places(run, run.curves[frame])
    if response.curves_m is not None:
        return _across(x, y, response.curves_m[0][frame], response.curves_m[1][frame])
    only_tip = np.full(PLACES, np.nan)
    if response.tip_m is not None:
        only_tip[-1] = response.tip_m[run.driven.frames[frame]] - y[-1]
    return only_tip


def _across(x: FloatArray, y: FloatArray, along_x: FloatArray, along_y: FloatArray) -> FloatArray:
    """Return the signed distances (places,) of a polyline from points; beyond it, of its ends."""
    dx, dy = np.diff(along_x), np.diff(along_y)
    ax, ay = x[:, None] - along_x[:-1], y[:, None] - along_y[:-1]
    t = (ax * dx + ay * dy) / (dx**2 + dy**2)
    inner = np.clip(t, 0.0, 1.0)
    inner[:, -1] = np.maximum(t[:, -1], 0.0)
    squared = (ax - inner * dx) ** 2 + (ay - inner * dy) ** 2
    at = np.argmin(np.nan_to_num(squared, nan=0.0), axis=1)
    row = np.arange(len(x))
    side = dx[at] * ay[row, at] - dy[at] * ax[row, at]
    return np.asarray(-np.sign(side) * np.sqrt(squared[row, at]))
