"""A recorded run as every model is compared with it: one time grid, one whitening, one misfit."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property
from typing import Literal

import numpy as np

from model.dynamics.identification import RecordedRun, RecordingNoise, RunPlan
from model.dynamics.identification.noise import Whitening
from model.dynamics.identification.residuals import away_from_edges
from model.dynamics.models import DrivenSheet, Response
from model.measurements import FloatArray, ModelError, SheetGeometry

Quantity = Literal["force", "current", "shape"]
QUANTITIES: tuple[Quantity, ...] = ("force", "current", "shape")
WANTED = {"force": {"force"}, "current": {"current"}, "shape": {"curve"}}
SAME_TIME = 1e-9  # s: instants nearer than this are one
LN_2PI = float(np.log(2.0 * np.pi))


@dataclass(frozen=True, kw_only=True)
class ComparedRun:
    """A run of a sheet, with the noise of what was measured in it.

    Samples of the current at a voltage edge do not count: there it jumps, and models differ in
    which side they report.
    """

    run: RecordedRun
    sheet: SheetGeometry
    noise: RecordingNoise

    def __post_init__(self) -> None:
        """Refuse what published models cannot follow."""
        setup = self.run.plan.setup
        if setup is not None and callable(setup.position_m):
            raise ModelError(f"{self.run.plan.name}: the load cell moves during the run")

    @property
    def plan(self) -> RunPlan:
        """Return what was driven, and measured when."""
        return self.run.plan

    @property
    def position_m(self) -> float | None:
        """Return where the load cell is; None: away."""
        at = self.plan.setup.position_m if self.plan.setup else None
        return None if at is None or callable(at) else at

    @cached_property
    def driven(self) -> DrivenSheet:
        """Return the drive on a grid of all its edges, samples and frames."""
        plan = self.plan
        last = max([0.0, *plan.time_s[-1:], *plan.frame_s[-1:]])
        first = min(0.0, float(plan.drive.time_s[0]))
        edges = plan.drive.time_s[plan.drive.time_s <= last]
        times = np.unique(np.concatenate([[first, 0.0], edges, plan.time_s, plan.frame_s]))
        times = times[np.diff(times, prepend=-np.inf) > SAME_TIME]
        wanted = [WANTED[q] for q in self.measured]
        return DrivenSheet(
            sheet=self.sheet, position_m=self.position_m, time_s=times,
            drive_V=plan.drive.at(times + SAME_TIME), frames=_places(times, plan.frame_s),
            wanted=frozenset().union(*wanted),
        )  # fmt: skip

    @property
    def measured(self) -> tuple[Quantity, ...]:
        """Return the quantities that were measured."""
        there = {
            "force": self.run.force_N is not None,
            "current": self.run.current_A is not None and bool(self._away.any()),
            "shape": self.run.y_m is not None,
        }
        return tuple(q for q in QUANTITIES if there[q])

    def sampled(self, whole: Response) -> Response:
        """Return a response on the grid of `driven` at the samples and frames alone."""
        at = _places(self.driven.time_s, self.plan.time_s)
        force, current = whole.force_N, whole.current_A
        return Response(
            force_N=None if force is None else force[at],
            current_A=None if current is None else current[at],
            curves_m=whole.curves_m,
        )  # fmt: skip

    def values(self, quantity: Quantity) -> FloatArray:
        """Return what `residuals` compares with; of curves, heights above the clamp's tangent."""
        run = self.run
        if quantity == "force" and run.force_N is not None:
            return run.force_N
        if quantity == "current" and run.current_A is not None:
            return run.current_A[self._away]
        if quantity == "shape" and run.y_m is not None:
            return run.y_m
        raise ModelError(f"{self.plan.name}: the {quantity} was not measured")

    def count(self, quantity: Quantity) -> int:
        """Return how many values of it were measured."""
        return int(np.isfinite(self.values(quantity)).sum())

    def residuals(self, response: Response, quantity: Quantity) -> FloatArray | None:
        """Return predicted less measured, at the samples and frames; None: not predicted.

        Of shapes (frames, points): the distance of the measured points from the predicted curve,
        NaN where nothing was seen.
        """
        if quantity == "force":
            return None if response.force_N is None else response.force_N - self.values("force")
        if quantity == "current":
            if response.current_A is None:
                return None
            return np.asarray(response.current_A[self._away] - self.values("current"))
        if response.curves_m is None or self.run.x_m is None or self.run.y_m is None:
            return None
        return distances_m(self.run.x_m, self.run.y_m, *response.curves_m)

    def whitened(self, residuals: FloatArray, quantity: Quantity) -> FloatArray:
        """Return independent residuals of variance 1."""
        if quantity == "shape":
            return np.asarray(residuals[np.isfinite(residuals)] / self.noise.curve_m)
        return self._whitening(quantity)(residuals[:, None])[:, 0]

    def ln_density_at_0(self, residuals: FloatArray, quantity: Quantity) -> float:
        """Return the logarithm of the noise's density at 0 of what `residuals` has."""
        count = int(np.isfinite(residuals).sum())
        if quantity == "shape":
            return -count * (float(np.log(self.noise.curve_m)) + 0.5 * LN_2PI)
        return self._whitening(quantity).ln_determinant - 0.5 * count * LN_2PI

    def least_sigma(self, quantity: Quantity) -> float:
        """Return the white noise of a sample."""
        noise = self.noise
        white = {"force": noise.force.white, "current": noise.current.white}
        return white.get(quantity, noise.curve_m)

    def only(self, quantity: Quantity) -> ComparedRun:
        """Return the run with nothing but one quantity measured."""
        return self._with(force=quantity == "force", current=quantity == "current",
                          frames=slice(None) if quantity == "shape" else slice(0))  # fmt: skip

    def thinned(self, rate_hz: float) -> ComparedRun:
        """Return the run with about so many samples a second; none are averaged."""
        times = self.plan.time_s
        if len(times) < 2:
            return self
        every = max(1, round(1.0 / (rate_hz * float(np.median(np.diff(times))))))
        plan = self.plan
        return self._with(
            force=plan.force, current=plan.current, frames=slice(None),
            samples=slice(None, None, every),
        )  # fmt: skip

    def part(self, low_s: float, high_s: float) -> ComparedRun | None:
        """Return what was measured from one time to before another, after the whole drive before.

        None where that is nothing.
        """
        plan = self.plan
        samples, frames = (
            slice(*np.searchsorted(t, [low_s, high_s])) for t in (plan.time_s, plan.frame_s)
        )
        some = bool(len(plan.time_s[samples]))
        if not some and not len(plan.frame_s[frames]):
            return None
        return self._with(
            force=plan.force and some, current=plan.current and some, frames=frames, samples=samples
        )

    def _with(
        self, *, force: bool, current: bool, frames: slice, samples: slice = slice(None)
    ) -> ComparedRun:
        run, plan = self.run, self.plan
        frame_s = plan.frame_s[frames]
        points_m = plan.points_m if len(frame_s) else plan.points_m[:0]
        left = replace(
            plan, force=force, current=current, time_s=plan.time_s[samples], frame_s=frame_s,
            points_m=points_m,
        )  # fmt: skip
        seen = len(frame_s) > 0

        def kept(values: FloatArray | None, which: slice, wanted: bool) -> FloatArray | None:
            return values[which] if wanted and values is not None else None

        made = RecordedRun(
            plan=left, force_N=kept(run.force_N, samples, force),
            current_A=kept(run.current_A, samples, current),
            x_m=kept(run.x_m, frames, seen), y_m=kept(run.y_m, frames, seen),
        )  # fmt: skip
        return replace(self, run=made)

    @cached_property
    def _away(self) -> np.ndarray[tuple[int], np.dtype[np.bool_]]:
        return away_from_edges(self.plan, self.noise)

    def _whitening(self, quantity: Quantity) -> Whitening:
        return self._force_whitening if quantity == "force" else self._current_whitening

    @cached_property
    def _force_whitening(self) -> Whitening:
        return Whitening(self.noise.force, self.plan.time_s, self.noise.mains_hz)

    @cached_property
    def _current_whitening(self) -> Whitening:
        return Whitening(self.noise.current, self.plan.time_s[self._away], self.noise.mains_hz)


def distances_m(
    x_m: FloatArray, y_m: FloatArray, along_x_m: FloatArray, along_y_m: FloatArray
) -> FloatArray:
    """Return the signed distances (m, p) of m polylines (m, n) from the points (m, p) of each.

    Beyond its end a polyline goes on straight.
    """
    dx, dy = np.diff(along_x_m)[:, None], np.diff(along_y_m)[:, None]
    ax, ay = x_m[..., None] - along_x_m[:, None, :-1], y_m[..., None] - along_y_m[:, None, :-1]
    t = (ax * dx + ay * dy) / (dx**2 + dy**2)
    inner = np.clip(t, 0.0, 1.0)
    inner[..., -1] = np.maximum(t[..., -1], 0.0)
    squared = (ax - inner * dx) ** 2 + (ay - inner * dy) ** 2
    nearest = np.argmin(np.where(np.isfinite(squared), squared, 0.0), axis=-1)[..., None]
    side = np.take_along_axis(dx * ay - dy * ax, nearest, axis=-1)
    away = np.sqrt(np.take_along_axis(squared, nearest, axis=-1))
    return np.asarray((-np.sign(side) * away)[..., 0])


def _places(times: FloatArray, of: FloatArray) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    return np.searchsorted(times, of - SAME_TIME)
