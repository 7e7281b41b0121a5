"""The sheet's history: its inner state on a fixed time grid, and at any time between.

The grid does not know how reads are cut into pieces, so neither do the values: what is read at a
time depends on that time and on what was written before it.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np
import numpy.typing as npt

from sim_hardware.world.creep import PARTS, parts_of
from sim_hardware.world.mechanics import ELEMENTS, SLIDE_M, Stage
from sim_hardware.world.row_buffer import RowBuffer
from sim_hardware.world.settings import WorldSettings
from sim_hardware.world.sheet_states import SheetStates
from sim_hardware.world.signals.amplifier import SimulatedAmplifier
from sim_hardware.world.signals.load_cell import SimulatedLoadCell

if TYPE_CHECKING:
    from sim_hardware.world.motion.moving_history import MovingHistory

FloatArray = npt.NDArray[np.float64]
Watcher = Callable[[FloatArray, FloatArray, FloatArray], None]
"""Is given times, the voltage across the sheet and the force on the load cell then."""

# Columns of the grid: the state (see state_kernels), what moves the elements that lag, these, and,
# where the sheet creeps, the lags of that.
_VOLTAGE, _UNEVEN, _DRY_S, _STATES = 0, 2, 3, 9
_STATE = slice(0, _STATES)
_MOVED = slice(_STATES, _STATES + 2)
_TURNED = slice(_MOVED.stop, _MOVED.stop + ELEMENTS)
_LAGS = 3  # of each part of what creeps
_COLUMNS = _TURNED.stop
_KEEP_S = 300.0
_MOST_STEPS = 60_000
_INSTANTS = 3  # of an exposure
_MOTIONLESS = 1e-6  # change of drive during an exposure below what an image shows


class History:
    """Moves the state forward as far as it is asked for, and looks it up."""

    def __init__(
        self,
        settings: WorldSettings,
        amplifier: SimulatedAmplifier,
        cell: SimulatedLoadCell,
        first: Stage,
        watcher: Watcher,
    ) -> None:
        from sim_hardware.world import state_kernels

        self._kernels = state_kernels
        self._settings = settings
        self._amplifier = amplifier
        self._cell = cell
        self.start_s = first.start_s
        self._step_s = settings.chain.step_ms * 1e-3
        self._rules = state_kernels.rules_of(settings)
        spread = settings.creep.spread
        self._creep_s = settings.creep.time_s * np.array([1 / spread, 1.0, spread])
        self._creeps = settings.creep.share > 0.0
        row = np.zeros(_COLUMNS + PARTS * _LAGS * self._creeps)
        row[_UNEVEN] = 1.0
        self._rows = RowBuffer(row, round(_KEEP_S / self._step_s))
        # The next row follows from this one: the newest, or as the operator changed it.
        self._from = row
        self._stages = [first]
        self._watcher = watcher

    @property
    def reached_s(self) -> float:
        """Up to here the grid is made: what is written now cannot act earlier."""
        return self.start_s + self._rows.last * self._step_s

    @property
    def _oldest_s(self) -> float:
        return self.start_s + self._rows.oldest * self._step_s

    @property
    def stage(self) -> Stage:
        """The newest."""
        return self._stages[-1]

    def begin(self, stage: Stage) -> None:
        """From its start on, this is the set-up. The grid must have been made up to then."""
        if stage.setup is not self.stage.setup:
            self._from[_TURNED] = stage.first_turned(self._reach(stage))
            self._from[_COLUMNS:] = 0.0
            states = self._from[None, _STATE]
            now, drive = np.array([self.reached_s]), stage.drive(states)
            crept = np.zeros((1, PARTS))
            self._from[_MOVED] = stage.moved(now, drive, states[:, _DRY_S], crept)[0]
        self._stages.append(stage)
        while len(self._stages) > 1 and self._stages[1].start_s <= self._oldest_s:
            del self._stages[0]

    def moisten(self) -> None:
        """Moisten the sheet."""
        self._from[_UNEVEN] = 1.0
        self._from[_DRY_S] = 0.0

    def advance(self, when: float) -> None:
        """Make the grid up to the last step not after `when`."""
        target = math.floor((when - self.start_s) / self._step_s)
        while self._rows.last < target:
            self._make(min(target, self._rows.last + _MOST_STEPS))
        self._amplifier.forget(self._oldest_s)

    def at(self, times: FloatArray) -> list[SheetStates]:
        """Return the state at times in order, in one piece for each set-up that they fall into."""
        times = np.maximum(times, self.start_s)
        self.advance(float(times[-1]))
        starts = [stage.start_s for stage in self._stages]
        which = np.maximum(np.searchsorted(starts, times, side="right") - 1, 0)
        if which[0] == which[-1]:
            return [self._sheet_states(self._stages[which[0]], times)]
        return [self._sheet_states(self._stages[k], times[which == k]) for k in np.unique(which)]

    def exposed(self, until_s: float, exposure_s: float) -> list[SheetStates]:
        """Return the instants of an exposure; only its end, where the sheet does not move."""
        instants = until_s - exposure_s * np.linspace(1.0, 0.0, _INSTANTS)
        states = self.at(instants)
        drives = np.concatenate([m.drive for m in states])
        if len(states) == 1 and np.ptp(drives) < _MOTIONLESS:
            return [self.at(np.array([until_s]))[-1]]
        return states

    def current_A(self, times: FloatArray) -> FloatArray:
        """Return the sheet's charging current and its leak, at times in order."""
        electrical = self._settings.electrical
        times = np.maximum(times, self.start_s)
        self.advance(float(times[-1]))
        sheet_V = self._states(times)[1][:, _VOLTAGE]
        charging = (self._amplifier.output_V(times) - sheet_V) / electrical.rise_time_s
        return np.asarray(
            electrical.capacitance_mF * 1e-3 * charging + sheet_V / electrical.leak_ohm
        )

    def warm_up(self, stage: Stage) -> None:
        """Compile what a set-up needs, one in which the sheet is held."""
        one = np.zeros(1)
        stage.moved(one + stage.start_s, one, one, np.zeros((1, PARTS)))

    def _make(self, until: int) -> None:
        """Rows up to a step, all in one set-up."""
        last, stage = self._from, self.stage
        times = self._time_of(np.arange(self._rows.last, until + 1))
        rows = np.empty((times.size - 1, last.size))
        states = np.empty((times.size, _STATES))
        states[0] = last[_STATE]
        drive_V = self._amplifier.mean_V(times)
        self._kernels.advance(states, drive_V, self._step_s, self._rules)
        rows[:, _STATE] = states[1:]
        dry = states[1:, _DRY_S]
        drive = stage.drive(states[1:])
        stage.watch(times[1:], drive)
        if self._creeps:
            rows[:, _COLUMNS:] = self._creep(stage, drive, last[_COLUMNS:])
        rows[:, _MOVED] = stage.moved(times[1:], drive, dry, self._crept(rows))
        rows[:, _TURNED] = self._kernels.turn_stops(
            _hung(rows[:, _MOVED]), _hung(last[None, _MOVED])[0], last[_TURNED], self._reach(stage)
        )
        self._rows.append(rows)
        self._from = rows[-1].copy()
        rubbed_N = stage.friction_N(times[1:], drive, dry, rows[:, _TURNED.stop - 1])
        self._watcher(times[1:], states[1:, _VOLTAGE], rows[:, _MOVED.start] + rubbed_N)

    def _sheet_states(self, stage: Stage, times: FloatArray) -> SheetStates:
        rows, states = self._states(times)
        dry = states[:, _DRY_S]
        drive = stage.drive(states)
        crept = self._crept(rows)
        moved = stage.moved(times, drive, dry, crept)
        reach = self._reach(stage)
        turned = rows[:, _TURNED] + _hung(moved) - _hung(rows[:, _MOVED])
        turned = np.minimum(np.maximum(turned, -reach), reach)
        true_N = moved[:, 0] + stage.friction_N(times, drive, dry, turned[:, 2])
        felt_N = self._cell.felt_N(true_N, turned)
        felt_N = felt_N + self._cell.stray_N(stage.setup.position_m, states[:, _VOLTAGE])
        return SheetStates(
            stage=stage,
            times=times,
            states=states,
            drive=drive,
            true_N=true_N,
            felt_N=felt_N,
            crept=crept,
        )

    def _creep(self, stage: Stage, drive: FloatArray, last: FloatArray) -> FloatArray:
        """Return the lags of creep (n, columns), from those of the row before."""
        if not stage.setup.crept:  # a place that cannot be reached
            return np.zeros((drive.size, last.size))
        start = last.reshape(PARTS, _LAGS)
        parts = self._kernels.follow(parts_of(drive), start, self._step_s, self._creep_s)
        return parts.reshape(drive.size, -1)

    def _crept(self, rows: FloatArray) -> FloatArray:
        """Return how far each part has crept: the mean of its lags (n, PARTS)."""
        if not self._creeps:
            return np.zeros((len(rows), PARTS))
        return np.asarray(rows[:, _COLUMNS:].reshape(len(rows), PARTS, _LAGS).mean(axis=2))

    def _states(self, times: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Rows of the grid before some times, and the states at the times."""
        steps = self._step_of(times)
        rows = self._rows.at(steps)
        from_s = np.minimum(self._time_of(steps), times)
        drive_V = self._amplifier.mean_between(from_s, times)
        states = np.ascontiguousarray(rows[:, _STATE])
        return rows, self._kernels.part_steps(states, drive_V, times - from_s, self._rules)

    def _reach(self, stage: Stage) -> FloatArray:
        return np.array([*self._cell.reaches_N(stage.sticking_N), SLIDE_M])

    def _step_of(self, times: FloatArray) -> npt.NDArray[np.int64]:
        return np.floor((times - self.start_s) / self._step_s).astype(np.int64)

    def _time_of(self, steps: npt.ArrayLike) -> FloatArray:
        return np.asarray(self.start_s + np.asarray(steps) * self._step_s)


def _hung(moved: FloatArray) -> FloatArray:
    """Return the driver of each element: the force, the force, the place along the sheet."""
    return np.ascontiguousarray(moved[:, [0, 0, 1]])


def history_of(
    settings: WorldSettings,
    amplifier: SimulatedAmplifier,
    cell: SimulatedLoadCell,
    first: Stage,
    watcher: Watcher,
) -> History | MovingHistory:
    """Return the history of a sheet that is at rest at each moment, or of one that moves."""
    if settings.moving:
        from sim_hardware.world.motion.moving_history import MovingHistory

        return MovingHistory(settings, amplifier, cell, first, watcher)
    return History(settings, amplifier, cell, first, watcher)
