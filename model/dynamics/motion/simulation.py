"""A motion that goes on, and one from beginning to end.

The sheet bends by its moment Me = alpha U, moves with its mass against its own loss and the fluid,
free or held by the rolls of the load cell. `Simulation` goes on from where it stopped.
"""

from __future__ import annotations

from math import isfinite
from typing import Any, NamedTuple

import numpy as np

from model.dynamics import start
from model.dynamics.beam import ClampTurn, ContactSetup, DynamicBeam, HeldVoltage
from model.dynamics.body import SLIPPED, Given, MotionState, StepHistory, new_history, scheme
from model.dynamics.line import LineModes
from model.dynamics.load_cell import LoadCellFilter
from model.dynamics.motion.between_steps import between_steps
from model.dynamics.motion.boundaries import Boundaries
from model.dynamics.motion.driven_moment import Drive, DrivenMoment, Electrical
from model.dynamics.motion.resolution import SAME_TIME, Resolution, steps
from model.dynamics.motion.sheet_motion import SheetMotion
from model.dynamics.space import Rows, dense, rows_at
from model.measurements import FloatArray, ModelError
from model.mechanics.equilibrium import Engine, Equilibria
from model.mechanics.field import Field


class Steps(NamedTuple):
    """The steps of a piece of a motion: what was given, what came of it."""

    given: Given
    track: StepHistory
    line: Electrical  # at their ends
    ends_s: FloatArray  # (n + 1,) the first is where they begin


class Simulation:
    """A motion that goes on: `advance` returns the next piece of it."""

    def __init__(
        self,
        beam: DynamicBeam,
        setup: ContactSetup | None,
        drive: Drive,
        *,
        resolution: Resolution | None = None,
        clamp: ClampTurn | None = None,
        released_from: Field | None = None,
        engine: Engine = "auto",
    ) -> None:
        """Begin at rest at time 0: in equilibrium, or free in the curvature `released_from`.

        What a `HeldVoltage` held before time 0 has charged the electrodes.
        """
        self.beam, self.setup, self.engine = beam, setup, engine
        self.resolution = resolution or Resolution()
        self.time_s = 0.0
        self.slipped_s: float | None = None
        if setup is not None and released_from is not None:
            raise ModelError("only a free sheet can be released from a shape")
        self._found: Equilibria | None = None
        self._held = Boundaries(setup, clamp)
        self._driven = DrivenMoment(beam, drive, self.resolution.line_terms)
        self._begin(drive, released_from)
        on = self.body.space
        self._scheme = scheme(
            self.resolution.rho,
            self.resolution.tolerance_per_s2 / beam.length_m,
            self.resolution.keep,
        )
        self._dense = dense(on)
        self._rows: tuple[FloatArray, Rows] | None = None
        self._filter = LoadCellFilter(setup) if setup else None
        self.made: Steps | None = None  # of the last piece

    def _begin(self, drive: Drive, released_from: Field | None) -> None:
        beam, setup, by = self.beam, self.setup, self.resolution
        zero = np.zeros(1)
        psi, place = self._held.clamp(zero)[0], self._held.places(zero)[0]
        break_m = None
        if setup is not None:
            break_m = by.break_m or float(self._static(drive, setup).s_hat_m[0])
        self.break_m = break_m
        degrees = by.degrees if setup is not None else (by.free_degrees,)
        self.body = start.body_of(beam, start.sheet_space(beam, degrees, break_m))
        self._driven.take(self.body.space)
        moment = self._driven.at_begin(drive)
        self.state: MotionState
        if released_from is not None:
            self.state = start.let_go(self.body, released_from, moment, psi)
        elif setup is not None:
            self.state = start.resting(
                self.body, lambda: self._static(drive, setup), moment, float(psi[0]), place
            )
        else:
            self.state = start.at_rest(self.body, None, moment, float(psi[0]), place)
            if psi.any():
                start.accelerate(self.body, self.state, moment, psi)

    def _static(self, drive: Drive, setup: ContactSetup) -> Equilibria:
        """Return the static solution that the motion begins with, computed once."""
        if self._found is None:
            zero = np.zeros(1)
            angle = float(setup.angles(zero)[0]) - float(self._held.clamp(zero)[0, 0])
            kappa = self._driven.bent_at_begin(drive)
            self._found = start.equilibrium(self.beam, setup, kappa, angle, self.engine)
        return self._found

    @property
    def line(self) -> LineModes | None:
        """Return the electrodes; None where the moment is prescribed."""
        return self._driven.line

    @property
    def moment_per_volt_Nm(self) -> FloatArray:
        """Return the slope of Me by the sheet's voltage at each node; at 0 V the mean of both."""
        return self._driven.moment_per_volt_Nm()

    def advance(
        self,
        drive: Drive,
        times_s: FloatArray,
        s_m: FloatArray | None = None,
    ) -> SheetMotion:
        """Return the motion at `times_s`, ascending, the first not before where it stopped.

        s_m: points along sheet and elongation, none or more; None: 21, evenly. Raises ModelError
        where the motion cannot be followed in steps of this length.
        """
        times = np.atleast_1d(np.asarray(times_s, dtype=float))
        # those between two finite ones are finite where they ascend
        whole = len(times) == 0 or (isfinite(times[0]) and isfinite(times[-1]))
        if not (whole and (times[1:] > times[:-1]).all()):
            raise ModelError("the times of a motion must be finite and ascend")
        if len(times) == 0 or times[0] < self.time_s - SAME_TIME:
            raise ModelError(f"a motion cannot go back to before {self.time_s:g} s")
        step_s, rows = steps(self.time_s, times, _edges(drive), self.resolution)
        ends = np.full(len(step_s) + 1, self.time_s)
        ends[1:] += np.cumsum(step_s)
        moment, line = self._driven.follow(drive, ends, step_s)
        given = Given(
            step_s=step_s, moment=moment, clamp=self._held.clamp(ends),
            place=self._held.places(ends), contact=self.setup is not None,
        )  # fmt: skip
        made = Steps(given, new_history(given, self.body.space.size), line, ends)
        self.made = made
        if self.slipped_s is None:
            self._march(made, ends)
        self.time_s = float(times[-1])
        return self._report(times, rows, made, s_m)

    def _march(self, made: Steps, ends: FloatArray) -> None:
        march = _engine(self.engine).march
        done, why = march(self.body, made.given, self.state, self._scheme, made.track)
        if why == SLIPPED:
            self.slipped_s = float(ends[done])
        elif why:
            raise ModelError(
                f"the motion could not be followed beyond {ends[done]:.6g} s in steps of"
                f" {made.given.step_s[done] * 1e3:.3g} ms: take shorter ones"
            )

    def clamp_at(self, time_s: float) -> FloatArray:
        """Return psi and its two derivatives at an instant, (3,)."""
        return np.asarray(self._held.clamp(np.array([time_s]))[0])

    def _report(
        self,
        times: FloatArray,
        rows: np.ndarray[Any, Any],
        made: Steps,
        s_m: FloatArray | None,
    ) -> SheetMotion:
        track, given, line = made.track, made.given, made.line
        s, at = self._points(s_m)
        q, psi = track.q[rows], given.clamp[rows, 0]
        x_m = y_m = np.zeros((len(q), 0))
        if len(s):
            phi = q @ self._dense[0].T + psi[:, None]
            x_m, y_m = np.cos(phi) @ at.position.T, np.sin(phi) @ at.position.T
        normal, s_hat, phi_hat, force, reading = self._touch(track.x, given, rows)
        return SheetMotion(
            time_s=times, drive_V=line[0][rows], sheet_V=line[1][rows], current_A=line[2][rows],
            force_N=force, reading_N=reading, normal_N=normal, s_hat_m=s_hat, phi_hat_rad=phi_hat,
            s_m=s, x_m=x_m, y_m=y_m,
            phi_rad=q @ at.angle.T + psi[:, None], curvature_per_m=q @ at.curvature.T,
            slipped_s=self.slipped_s,
        )  # fmt: skip

    def curves(
        self, times_s: FloatArray, s_m: FloatArray
    ) -> tuple[FloatArray, FloatArray, FloatArray]:
        """Return x, y and phi (T, S) at times of the last piece, which need not end a step."""
        if self.made is None:
            raise ModelError("a sheet has curves when it has moved: advance it first")
        made, at = self.made, self._points(s_m)[1]
        q = between_steps(made.ends_s, made.track.q, made.track.v, times_s)
        psi = self._held.clamp(times_s)[:, :1]
        phi = q @ self._dense[0].T + psi
        x_m, y_m = np.cos(phi) @ at.position.T, np.sin(phi) @ at.position.T
        return x_m, y_m, q @ at.angle.T + psi

    def _touch(
        self, x: FloatArray, given: Given, rows: np.ndarray[Any, Any]
    ) -> tuple[FloatArray, ...]:
        """Return N, s_hat, phi_hat, F and the load cell's reading of it at `rows`."""
        if self.setup is None or self._filter is None:
            zero, nowhere = np.zeros(len(rows)), np.full(len(rows), np.nan)
            return zero, nowhere, nowhere, zero, zero
        normal, s_hat, phi_hat = x[rows].T
        if not self._filter.slow:
            force = normal * np.cos(phi_hat - self._held.polar(given.place[rows]))
            return normal, s_hat, phi_hat, force, force
        every = x[:, 0] * np.cos(x[:, 2] - self._held.polar(given.place))
        reading = self._filter.follow(given.step_s, every)
        return normal, s_hat, phi_hat, every[rows], reading[rows]

    def _points(self, s_m: FloatArray | None) -> tuple[FloatArray, Rows]:
        """Return the points and their matrices, kept from piece to piece."""
        end = float(self.body.space.breaks_m[-1])
        s = np.linspace(0.0, end, 21) if s_m is None else np.asarray(s_m, dtype=float)
        if self._rows is None or not np.array_equal(self._rows[0], s):
            if not np.all((s >= 0.0) & (s <= end * (1.0 + 1e-12))):
                raise ModelError(f"points along the sheet must lie within {end * 1e3:g} mm")
            self._rows = (s, rows_at(self.body.space, s))
        return self._rows


def simulate(
    beam: DynamicBeam,
    setup: ContactSetup | None,
    drive: Drive,
    times_s: FloatArray,
    *,
    s_m: FloatArray | None = None,
    resolution: Resolution | None = None,
    clamp: ClampTurn | None = None,
    released_from: Field | None = None,
    engine: Engine = "auto",
) -> SheetMotion:
    """Return the motion of a sheet at `times_s`; it begins at rest at time 0.

    setup: the rolls it touches, None: free. s_m: points of its shape, None: 21 along sheet and
    elongation. clamp: a prescribed direction of the clamp. released_from: the curvature of a free
    sheet that is let go at time 0, else it begins in equilibrium. Raises ModelError.
    """
    one = Simulation(
        beam, setup, drive, resolution=resolution, clamp=clamp, released_from=released_from,
        engine=engine,
    )  # fmt: skip
    return one.advance(drive, times_s, s_m)


def _edges(drive: Drive) -> FloatArray:
    if not isinstance(drive, HeldVoltage):
        return np.array(drive.edges_s)
    volts = drive.voltage_V
    return np.asarray(drive.time_s[volts != np.concatenate([[0.0], volts[:-1]])])


def _engine(engine: Engine) -> Any:
    """Return the compiled engine, or NumPy's where numba is missing."""
    if engine != "numpy":
        try:
            from model.dynamics import kernel

            return kernel
        except ImportError:
            if engine == "compiled":
                raise ModelError(
                    "the compiled engine needs numba, which is not installed"
                ) from None
    from model.dynamics import numpy_reference

    return numpy_reference
