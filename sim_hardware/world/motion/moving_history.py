"""The history of a moving sheet: as `History`, on a grid of half milliseconds."""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
import numpy.typing as npt

from sim_hardware.world import state_kernels
from sim_hardware.world.loading import WorldError
from sim_hardware.world.mechanics import Stage
from sim_hardware.world.motion import march
from sim_hardware.world.motion.links import room
from sim_hardware.world.motion.moving_sheet import MovingSheet
from sim_hardware.world.motion.moving_sheet_states import MovingSheetStates
from sim_hardware.world.motion.travel import Travel
from sim_hardware.world.row_buffer import RowBuffer
from sim_hardware.world.settings import WorldSettings
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.load_cell import SimulatedLoadCell

FloatArray = npt.NDArray[np.float64]

# Columns of the grid: those of `march`, the slow state (see state_kernels), what lags behind the
# load cell's force.
_MOVED, _SLOW, _TURNED = slice(0, 9), slice(9, 18), slice(18, 20)
_UNEVEN, _DRY_S = 2, 3
_COLUMNS = 20
_KEEP_S, _KEEP_SHAPES_S = 300.0, 60.0
_MOST_STEPS = 20_000
_INSTANTS = 9  # of an exposure
_MOTIONLESS_M = 1e-6


class MovingHistory:
    """Moves the sheet forward as far as it is asked for, and looks it up; see `History`.

    A row at t_k knows the voltages and forces at t_k, and the angles up to t_k plus a step. What is
    asked for in between follows from it alone.
    """

    def __init__(
        self,
        settings: WorldSettings,
        amplifier: SimulatedAmplifier,
        cell: SimulatedLoadCell,
        first: Stage,
        watcher: Callable[[FloatArray, FloatArray, FloatArray], None],
    ) -> None:
        self._settings, self._amplifier, self._cell = settings, amplifier, cell
        self._watcher = watcher
        self._rules = state_kernels.rules_of(settings)
        self._step_s = settings.chain.moving_step_ms * 1e-3
        self.start_s = first.start_s
        self._stages = [first]
        self._sheets = [MovingSheet(setup=first.setup)]
        self._travels = [_resting(first)]
        self._room = room(settings.chain.moving_links)
        row = np.zeros(_COLUMNS)
        row[_SLOW][_UNEVEN] = 1.0
        self._from = row
        self._rows = RowBuffer(row, round(_KEEP_S / self._step_s))
        U = np.zeros(settings.chain.moving_links)
        self._state = self._at_rest(first, self._sheets[0], U)
        self._shapes = RowBuffer(self._state.phi[2].astype(np.float32), self._shapes_kept)
        self._put(row)

    @property
    def _shapes_kept(self) -> int:
        return round(_KEEP_SHAPES_S / self._step_s)

    @property
    def reached_s(self) -> float:
        """Up to here the grid is made: what is written now cannot act earlier."""
        return self.start_s + self._rows.last * self._step_s

    @property
    def stage(self) -> Stage:
        """The newest."""
        return self._stages[-1]

    def begin(self, stage: Stage) -> None:
        """From its start on, this is the set-up. The grid must have been made up to then.

        Rolls that hold the sheet carry it to a new position, or let it go; where they come to it,
        or where another sheet is mounted, it has come to rest.
        """
        before, old = self.stage, self._travels[-1]
        same = stage.setup is before.setup
        self._stages.append(stage)
        self._sheets.append(self._sheets[-1] if same else MovingSheet(setup=stage.setup))
        self._travels.append(old if same else _resting(stage))
        if not same and stage.setup.configuration == before.setup.configuration:
            came_m, goes_m = before.setup.position_m, stage.setup.position_m
            if came_m is not None and goes_m is not None:
                self._travels[-1] = self._way(old, stage)
            elif came_m is None or goes_m is not None:
                self._rest_anew(stage)
            else:
                self._state.row[march.HELD] = 0.0
        elif not same:
            self._state.U[:] = 0.0
            self._rest_anew(stage)
        self._forget_stages()

    def moisten(self) -> None:
        """Moisten the sheet."""
        self._from[_SLOW][_UNEVEN] = 1.0
        self._from[_SLOW][_DRY_S] = 0.0

    def advance(self, when: float) -> None:
        """Make the grid up to the last step not after `when`."""
        target = math.floor((when - self.start_s) / self._step_s)
        while self._rows.last < target:
            self._make(min(target, self._rows.last + _MOST_STEPS))
        self._amplifier.forget(float(self._time_of(self._rows.oldest)))

    def at(self, times: FloatArray) -> list[MovingSheetStates]:
        """Return the sheet at times in order, in one piece for each set-up that they fall into."""
        times = np.maximum(times, self.start_s)
        self.advance(float(times[-1]))
        starts = [stage.start_s for stage in self._stages]
        which = np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)
        return [self._sheet_states(int(k), times[which == k]) for k in np.unique(which)]

    def exposed(self, until_s: float, exposure_s: float) -> list[MovingSheetStates]:
        """Return the instants of an exposure; only its end, where the sheet does not move."""
        states = self.at(until_s - exposure_s * np.linspace(1.0, 0.0, _INSTANTS))
        turned_rad = float(np.ptp(states[-1].phi_rad, axis=0).max())
        reach_m = states[-1].stage.setup.chain.sheet.visible_m
        if len(states) == 1 and turned_rad * reach_m < _MOTIONLESS_M:
            return self.at(np.array([until_s]))
        return states

    def current_A(self, times: FloatArray) -> FloatArray:
        """Return the current into the electrodes, at times in order."""
        times = np.maximum(times, self.start_s)
        self.advance(float(times[-1]))
        line = self._sheets[-1].line
        steps = self._step_of(times)
        rows, from_s = self._rows.at(steps), np.minimum(self._time_of(steps), times)
        mean_V = self._amplifier.mean_between(from_s, times)
        rise = line.rise_S_per_s * mean_V - rows[:, march.SINK]
        back = rows[:, march.BACK] + rise * (times - from_s)
        return np.asarray(line.now_S * self._amplifier.output_V(times) - back)

    def warm_up(self, stage: Stage) -> None:
        """Compile what a set-up needs, one in which the sheet is held."""
        sheet = MovingSheet(setup=stage.setup)
        state = self._at_rest(stage, sheet, self._state.U)
        times, one = np.array([stage.start_s]), np.zeros((1, 9))
        self._march(sheet, self._course(times, np.zeros(1), one), state)

    # ------------------------------------------------------------------------------ internals

    def _make(self, until: int) -> None:
        """Rows up to a step, all in one set-up."""
        stage, sheet = self.stage, self._sheets[-1]
        times = self._time_of(np.arange(self._rows.last, until + 1))
        slow = np.empty((times.size, 9))
        slow[0] = self._from[_SLOW]
        drive_V = self._amplifier.mean_V(times)
        state_kernels.advance(slow, drive_V, self._step_s, self._rules)
        rows = np.empty((times.size - 1, _COLUMNS))
        course = self._course(times[1:], drive_V, slow[1:])
        moved, shapes = self._march(sheet, course, self._state)
        if len(moved) < len(rows):
            raise WorldError(
                f"the moving sheet is lost {times[len(moved)] - self.start_s:.3f} s after the "
                f"beginning; a [chain] moving_step_ms below {self._step_s * 1e3:g} may help"
            )
        rows[:, _MOVED], rows[:, _SLOW] = moved, slow[1:]
        before = self._from[[march.CELL, march.CELL]]
        rows[:, _TURNED] = state_kernels.turn_stops(
            np.ascontiguousarray(moved[:, [march.CELL, march.CELL]]), before, self._from[_TURNED],
            self._cell.reaches_N(stage.sticking_N),
        )  # fmt: skip
        self._rows.append(rows)
        self._shapes.append(shapes)
        self._from = rows[-1].copy()
        self._watcher(times[1:], drive_V, moved[:, march.FORCE])

    def _march(
        self, sheet: MovingSheet, course: march.Course, state: march.ChainState
    ) -> tuple[FloatArray, FloatArray]:
        """Return rows and shapes of as many steps as can be made."""
        count, cell = course.drive_V.size, self._settings.load_cell
        rows, shapes = np.empty((count, march.COLUMNS)), np.empty((count, state.phi.shape[1]))
        made = march.march(
            sheet.links, sheet.line, sheet.law, omega=2 * math.pi * cell.resonance_hz,
            damping=cell.damping, dt=self._step_s, end_m=sheet.chain.sheet.visible_m,
            course=course, state=state, space=self._room, rows=rows, shapes=shapes,
        )  # fmt: skip
        return rows[:made], shapes[:made]

    def _course(self, times: FloatArray, drive_V: FloatArray, slow: FloatArray) -> march.Course:
        """Return what meets the sheet in the steps that end at these times."""
        stage, setup = self.stage, self.stage.setup
        dry, travel = slow[:, _DRY_S], self._travels[-1]
        polar, ahead = travel.at(times), travel.at(times + self._step_s)
        radius_m = setup.arc.radius_m
        off = math.radians(self._settings.load_cell.misalignment_deg)
        # The clamp of another set-up may hold the sheet in another direction: on the way there.
        tilt, was = self._sheets[-1].chain.sheet.clamp_rad, self._clamp_before
        share = travel.done(times + self._step_s)
        return march.Course(
            drive_V=drive_V,
            share=stage.moment_share(slow),
            stiff=stage.stiffening(dry),
            axis_rad=polar + off,
            beside_N=np.full(times.size, stage.load_N),
            held_N=stage.meniscus_N(dry),
            roll_x_m=radius_m * np.cos(ahead),
            roll_y_m=radius_m * np.sin(ahead),
            clamp_rad=np.where(share >= 1.0, tilt, was + (tilt - was) * share),
        )

    def _sheet_states(self, which: int, times: FloatArray) -> MovingSheetStates:
        stage, travel = self._stages[which], self._travels[which]
        steps = self._step_of(times)
        rows, after = self._rows.at(steps), np.maximum(times - self._time_of(steps), 0.0)
        cell = self._settings.load_cell
        start = np.ascontiguousarray(rows[:, : march.CELL_RATE + 1])
        shown_N = march.rings(start, after, 2 * math.pi * cell.resonance_hz, cell.damping)
        reach = self._cell.reaches_N(stage.sticking_N)
        turned = rows[:, _TURNED] + (shown_N - rows[:, march.CELL])[:, None]
        felt_N = self._cell.felt_N(shown_N, np.clip(turned, -reach, reach))
        felt_N = felt_N + self._cell.stray_N(stage.setup.position_m, rows[:, _SLOW][:, 0])
        part = (after / self._step_s)[:, None]
        phi = (1 - part) * self._shapes.at(steps - 1) + part * self._shapes.at(steps)
        polar = travel.at(times)
        return MovingSheetStates(
            stage=stage,
            times=times,
            chain=self._sheets[which].chain,
            phi_rad=phi,
            true_N=rows[:, march.FORCE] + rows[:, march.SLOPE] * after,
            felt_N=felt_N,
            polar_rad=polar,
            angle_rad=np.where(rows[:, march.HELD] == 1.0, rows[:, march.ANGLE], polar),
        )

    def _way(self, old: Travel, stage: Stage) -> Travel:
        """Return the way from where the rolls are to where they shall be."""
        radius_m = stage.setup.arc.radius_m
        speed = self._settings.load_cell.travel_mm_per_s * 1e-3 / radius_m
        here = float(old.at(np.array([self.reached_s]))[0])
        self._clamp_before = float(self._state.phi[2, 0])
        return Travel.at_most(self.reached_s, here, stage.setup.arc_rad, speed)

    def _rest_anew(self, stage: Stage) -> None:
        """Let the sheet have come to rest in a set-up, under the voltages that it has."""
        self._state = self._at_rest(stage, self._sheets[-1], self._state.U)
        reach = self._cell.reaches_N(stage.sticking_N)
        self._from[_TURNED] = stage.first_turned(np.append(reach, 0.0))[:2]
        self._put(self._from)

    def _at_rest(self, stage: Stage, sheet: MovingSheet, U: FloatArray) -> march.ChainState:
        slow = self._from[None, _SLOW]
        self._clamp_before = sheet.chain.sheet.clamp_rad
        stiff = float(stage.stiffening(slow[:, _DRY_S])[0])
        share = float(stage.moment_share(slow)[0])
        held_N = float(stage.meniscus_N(slow[:, _DRY_S])[0])
        return sheet.at_rest(U, share, stiff, beside_N=stage.load_N, held_N=held_N)

    def _put(self, row: FloatArray) -> None:
        """Let the newest row be that of the state."""
        row[_MOVED] = self._state.row
        self._rows.replace(row)
        self._shapes.replace(self._state.phi[2], 2)

    def _forget_stages(self) -> None:
        oldest_s = self._time_of(self._rows.oldest)
        while len(self._stages) > 1 and self._stages[1].start_s <= oldest_s:
            del self._stages[0], self._sheets[0], self._travels[0]

    def _step_of(self, times: FloatArray) -> npt.NDArray[np.int64]:
        return np.floor((times - self.start_s) / self._step_s).astype(np.int64)

    def _time_of(self, steps: npt.ArrayLike) -> FloatArray:
        return np.asarray(self.start_s + np.asarray(steps) * self._step_s)


def _resting(stage: Stage) -> Travel:
    """Where the rolls are, at rest; away they are anywhere."""
    at_rad = 0.0 if stage.setup.position_m is None else stage.setup.arc_rad
    return Travel(start_s=-math.inf, from_rad=at_rad, to_rad=at_rad)
