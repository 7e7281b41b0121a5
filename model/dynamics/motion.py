"""`simulate`: voltage in, force, current and shape out, in time.

The sheet bends by its moment Me = alpha U, moves with its mass against its own loss and the fluid,
free or held by the rolls of the load cell. `Simulation` goes on from where it stopped.
"""

from __future__ import annotations

from dataclasses import dataclass
from math import cos, sin
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from model.dynamics import start
from model.dynamics.beam import (
    ClampTurn,
    ContactSetup,
    DynamicBeam,
    HeldVoltage,
    PrescribedMoment,
)
from model.dynamics.body import SLIPPED, Given, MotionState, StepHistory, new_history, scheme
from model.dynamics.line import LineModes
from model.dynamics.load_cell import LoadCellFilter
from model.dynamics.space import Rows, dense, moments, rows_at
from model.measurements import Displayed, FloatArray, ModelError, Summary, dataframe
from model.mechanics.equilibrium import Engine, Equilibria
from model.mechanics.field import Field

if TYPE_CHECKING:
    import pandas as pd

SAME_TIME = 1e-9  # s: instants nearer than this are one


@dataclass(frozen=True, kw_only=True)
class Resolution:
    """Steps and polynomials of a simulation."""

    step_s: float = 1e-3  # the longest
    degrees: tuple[int, ...] = (8, 3)  # coefficients of the panels before and beyond the contact
    free_degrees: int = 10  # of the one panel of a free sheet
    line_terms: int = 12
    rho: float = 0.8  # spectral radius at infinite frequency: 1 keeps all energy, 0.6 damps
    break_m: float | None = None  # between the panels; None: where the sheet first touches
    tolerance_per_s2: float = 1e-2  # of the curvature's second derivative, times the length
    keep: int = 25  # steps that share a matrix

    def __post_init__(self) -> None:
        """Refuse what no scheme is."""
        if not 0.0 < self.step_s < np.inf:
            raise ModelError(f"the step must be positive, not {self.step_s:g} s")
        if not 0.0 <= self.rho <= 1.0:
            raise ModelError(f"the spectral radius rho must be between 0 and 1, not {self.rho:g}")


@dataclass(frozen=True, kw_only=True, repr=False)
class SheetMotion(Displayed):
    """What was computed at T times and S points; NaN after the sheet has slipped out."""

    time_s: FloatArray  # (T,)
    drive_V: FloatArray  # of the source; at an edge the voltage before it
    sheet_V: FloatArray  # between the electrodes at the clamp
    current_A: FloatArray
    force_N: FloatArray  # F of the sheet on the rolls along the arc's tangent; 0 where it is free
    reading_N: FloatArray  # the same as the load cell follows it
    normal_N: FloatArray  # N
    s_hat_m: FloatArray  # NaN where the sheet is free
    phi_hat_rad: FloatArray
    s_m: FloatArray  # (S,)
    x_m: FloatArray  # (T, S)
    y_m: FloatArray
    phi_rad: FloatArray
    curvature_per_m: FloatArray
    slipped_s: float | None = None  # when the sheet left the rolls

    def summary(self) -> Summary:
        """Return the range of each quantity over time."""
        rows = []
        for name, values in self._over_time().items():
            known = values[np.isfinite(values)]
            if len(known):
                span = (f"{known.min():.4g}", f"{known.max():.4g}", f"{known[-1]:.4g}")
                rows.append((name, *span))
        slipped = () if self.slipped_s is None else (f"slips out at {self.slipped_s:.3f} s",)
        length = f"{len(self.time_s)} times, {len(self.s_m)} points of the shape"
        columns = ("quantity", "least", "most", "last")
        return Summary(f"SheetMotion: {length}", columns, rows, slipped)

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each time as a pandas data frame, in SI units; the shape as its tip."""
        return dataframe(self._over_time())

    def _over_time(self) -> dict[str, FloatArray]:
        names = (
            "time_s", "drive_V", "sheet_V", "current_A", "force_N", "reading_N", "normal_N",
            "s_hat_m", "phi_hat_rad",
        )  # fmt: skip
        tip = {f"tip_{name}": getattr(self, name)[:, -1] for name in ("x_m", "y_m", "phi_rad")}
        return {**{name: getattr(self, name) for name in names}, **tip}


class Steps(NamedTuple):
    """The steps of a piece of a motion: what was given, what came of it."""

    given: Given
    track: StepHistory
    line: tuple[FloatArray, FloatArray, FloatArray]  # source, V(0) and current at their ends


class Simulation:
    """A motion that goes on: `advance` returns the next piece of it."""

    def __init__(
        self,
        beam: DynamicBeam,
        setup: ContactSetup | None,
        drive: HeldVoltage | PrescribedMoment,
        *,
        resolution: Resolution | None = None,
        clamp: ClampTurn | None = None,
        released_from: Field | None = None,
        engine: Engine = "auto",
    ) -> None:
        """Begin at rest at time 0: in equilibrium, or free in the curvature `released_from`.

        What a `HeldVoltage` held before time 0 has charged the electrodes.
        """
        self.beam, self.setup, self.clamp, self.engine = beam, setup, clamp, engine
        self.resolution = resolution or Resolution()
        self.time_s = 0.0
        self.slipped_s: float | None = None
        if setup is not None and released_from is not None:
            raise ModelError("only a free sheet can be released from a shape")
        self._found: Equilibria | None = None
        # the rolls' polar angle, where they do not move
        self._rests_rad = (
            float(setup.angles(np.zeros(1))[0])
            if setup is not None and not callable(setup.position_m)
            else None
        )
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

    def _begin(self, drive: HeldVoltage | PrescribedMoment, released_from: Field | None) -> None:
        beam, setup, by = self.beam, self.setup, self.resolution
        zero = np.zeros(1)
        psi = self._clamp(zero)[0]
        break_m = None
        self.line: LineModes | None = None
        if beam.electrodes is not None:
            self.line = LineModes(beam.electrodes, beam.length_m, by.line_terms)
            self._line_state = np.zeros(by.line_terms)
            if isinstance(drive, HeldVoltage):
                self._line_state = self.line.charged(drive.time_s, drive.voltage_V)
        elif any(beam.moment_per_volt_Nm):
            raise ModelError("a moment per volt needs the sheet's electrodes")
        if setup is not None:
            break_m = by.break_m or float(self._static(drive, setup).s_hat_m[0])
        self.break_m = break_m
        degrees = by.degrees if setup is not None else (by.free_degrees,)
        self.body = start.body_of(beam, start.sheet_space(beam, degrees, break_m))
        on = self.body.space
        self._moments = moments(on)
        if self.line is not None:
            self._line_at_nodes = self.line.at(np.minimum(on.s_m, beam.length_m))
            up = beam.moment_per_volt_Nm[0]
            self._moment_per_mode = up * (self._moments @ self._line_at_nodes).T
        if isinstance(drive, PrescribedMoment):
            moment = self._moments @ drive.at(zero, on.s_m)[0]
        else:
            modes = self._line_state[None] if self.line is not None else np.zeros((1, 1))
            moment = self._moment_of(modes)[0]
        self.state: MotionState
        if released_from is not None:
            self.state = start.let_go(self.body, released_from, moment, psi)
            return
        place = self._places(zero)[0]
        if setup is not None:
            self.state = start.resting(
                self.body, lambda: self._static(drive, setup), moment, float(psi[0]), place
            )
            return
        self.state = start.at_rest(self.body, None, moment, float(psi[0]), place)
        if psi.any():
            start.accelerate(self.body, self.state, moment, psi)

    def _static(self, drive: HeldVoltage | PrescribedMoment, setup: ContactSetup) -> Equilibria:
        """Return the static solution that the motion begins with, computed once."""
        if self._found is None:
            zero = np.zeros(1)
            angle = float(setup.angles(zero)[0]) - float(self._clamp(zero)[0, 0])
            kappa = self._bent_at_begin(drive)
            self._found = start.equilibrium(self.beam, setup, kappa, angle, self.engine)
        return self._found

    def _bent_at_begin(self, drive: HeldVoltage | PrescribedMoment) -> Field:
        """Return the curvature that a free sheet would begin with."""
        beam, zero = self.beam, np.zeros(1)
        kinks = beam.rest.breaks_m[1:-1]
        B = beam.material.B_Nm2
        if isinstance(drive, PrescribedMoment):
            return Field.smooth(
                lambda s: beam.rest(s) + drive.at(zero, s)[0] / B, beam.length_m, kinks
            )
        if self.line is None or not self._line_state.any():
            return beam.rest
        line, modes = self.line, self._line_state
        return Field.smooth(
            lambda s: beam.rest(s) + beam.moment_of(line.at(s) @ modes) / B, beam.length_m, kinks
        )

    def _moment_of(self, modes: FloatArray) -> FloatArray:
        """Return int Me P_j ds (n, N) of the line's modes (n, T)."""
        if self.line is None:
            return np.zeros((len(modes), self.body.space.size))
        up, down = self.beam.moment_per_volt_Nm
        if up == down:
            return np.asarray(modes @ self._moment_per_mode)
        return np.asarray(self.beam.moment_of(modes @ self._line_at_nodes.T) @ self._moments.T)

    def advance(
        self,
        drive: HeldVoltage | PrescribedMoment,
        times_s: FloatArray,
        s_m: FloatArray | None = None,
    ) -> SheetMotion:
        """Return the motion at `times_s`, ascending, the first not before where it stopped.

        s_m: points along sheet and elongation, none or more; None: 21, evenly. Raises ModelError
        where the motion cannot be followed in steps of this length.
        """
        times = np.atleast_1d(np.asarray(times_s, dtype=float))
        if not np.all(np.isfinite(times)) or np.any(np.diff(times) <= 0.0):
            raise ModelError("the times of a motion must be finite and ascend")
        if len(times) == 0 or times[0] < self.time_s - SAME_TIME:
            raise ModelError(f"a motion cannot go back to before {self.time_s:g} s")
        step_s, rows = steps(self.time_s, times, _edges(drive), self.resolution.step_s)
        ends = self.time_s + np.concatenate([[0.0], np.cumsum(step_s)])
        moment, line = self._drive(drive, ends, step_s)
        given = Given(
            step_s=step_s, moment=moment, clamp=self._clamp(ends), place=self._places(ends),
            contact=self.setup is not None,
        )  # fmt: skip
        made = Steps(given, new_history(given, self.body.space.size), line)
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
        return np.asarray(self._clamp(np.array([time_s]))[0])

    def _clamp(self, times: FloatArray) -> FloatArray:
        """Return psi and its two derivatives, (n, 3)."""
        out = np.zeros((len(times), 3))
        if self.clamp is not None:
            out[:, 0] = self.clamp.angle_rad(times)
            out[:, 1] = self.clamp.rate_rad_per_s(times)
            out[:, 2] = self.clamp.acceleration_rad_per_s2(times)
        return out

    def _places(self, times: FloatArray) -> FloatArray:
        """Return p_hat, (n, 2)."""
        places = np.zeros((len(times), 2))
        if self._rests_rad is not None and self.setup is not None:
            R, beta = self.setup.radius_m, self._rests_rad
            places[:] = (R * cos(beta), R * sin(beta))
        elif self.setup is not None:
            angles = self.setup.angles(times)
            places[:, 0] = self.setup.radius_m * np.cos(angles)
            places[:, 1] = self.setup.radius_m * np.sin(angles)
        return places

    def _polar(self, places: FloatArray) -> FloatArray | float:
        """Return the polar angles of the rolls; one where they rest."""
        if self._rests_rad is not None:
            return self._rests_rad
        return np.arctan2(places[:, 1], places[:, 0])

    def _drive(
        self, drive: HeldVoltage | PrescribedMoment, ends: FloatArray, step_s: FloatArray
    ) -> tuple[FloatArray, tuple[FloatArray, FloatArray, FloatArray]]:
        """Return int Me P_j ds (n + 1, N), and voltage, V(0) and current at the steps' ends."""
        nothing = np.zeros(len(ends))
        if isinstance(drive, PrescribedMoment):
            return drive.at(ends, self.body.space.s_m) @ self._moments.T, (nothing,) * 3
        held = drive.at(ends[:-1] + 0.5 * step_s)
        source = np.concatenate([held[:1], held]) if len(held) else nothing
        if self.line is None:
            return np.zeros((len(ends), self.body.space.size)), (source, source, nothing)
        modes = self.line.respond(self._line_state, step_s, held)
        self._line_state = modes[-1]
        moment = self._moment_of(modes)
        clamp = self.line.clamp_V(modes, source)
        return moment, (source, clamp, (source - clamp) / self.line.line.source_ohm)

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
        normal, force, reading = (np.zeros(len(times)) for _ in range(3))
        s_hat, phi_hat = np.full(len(times), np.nan), np.full(len(times), np.nan)
        if self.setup is not None and self._filter is not None:
            normal, s_hat, phi_hat = track.x[rows].T
            which = slice(None) if self._filter.slow else rows  # a slow load cell needs all steps
            gamma = track.x[which, 2] - self._polar(given.place[which])
            force = reading = track.x[which, 0] * np.cos(gamma)
            if self._filter.slow:
                reading, force = self._filter.follow(given.step_s, force)[rows], force[rows]
        return SheetMotion(
            time_s=times, drive_V=line[0][rows], sheet_V=line[1][rows], current_A=line[2][rows],
            force_N=force, reading_N=reading, normal_N=normal, s_hat_m=s_hat, phi_hat_rad=phi_hat,
            s_m=s, x_m=x_m, y_m=y_m,
            phi_rad=q @ at.angle.T + psi[:, None], curvature_per_m=q @ at.curvature.T,
            slipped_s=self.slipped_s,
        )  # fmt: skip

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
    drive: HeldVoltage | PrescribedMoment,
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


def steps(
    begin_s: float, times_s: FloatArray, edges_s: FloatArray, longest_s: float
) -> tuple[FloatArray, np.ndarray[Any, Any]]:
    """Return steps that end at all times and edges, and after how many each time comes."""
    edges = edges_s[(edges_s > begin_s) & (edges_s < times_s[-1])]
    knots = np.concatenate([[begin_s], times_s])
    if len(edges):
        knots = np.unique(np.concatenate([knots, edges]))
    widths = np.diff(knots)
    apart = widths > SAME_TIME
    if not apart.all():
        knots = knots[np.concatenate([[True], apart])]
        widths = np.diff(knots)
    counts = np.ceil(widths / longest_s - 1e-6).astype(int)
    after = np.zeros(len(counts) + 1, dtype=int)
    np.cumsum(counts, out=after[1:])
    nearest = np.searchsorted(knots, times_s - SAME_TIME)
    return np.repeat(widths / counts, counts), after[np.minimum(nearest, len(after) - 1)]


def _edges(drive: HeldVoltage | PrescribedMoment) -> FloatArray:
    return drive.time_s if isinstance(drive, HeldVoltage) else np.array(drive.edges_s)


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
